"""Who is at a take: one at a time, by the store's clock, taken over only on purpose."""

import time
from concurrent.futures import ThreadPoolExecutor
from datetime import timedelta
from threading import Barrier

import pytest

from markermend.errors import Taken
from markermend.model import Finding, Span, Take
from markermend.review import Accept
from markermend.review.claims import Claim, claim, claimed, release, renew, second_seat
from markermend.review.session import ReviewSession
from markermend.review.store import ReviewRecord, Store


def peak(n: int) -> Finding:
    return Finding("A", Span(n, n + 3), "peak")


@pytest.fixture
def record(store: Store, take: Take) -> ReviewRecord:
    return ReviewSession.open(store, take, "anna").record


def test_a_take_is_claimed_by_one(store: Store, record: ReviewRecord) -> None:
    mine = claim(store, record, "anna", "a1")
    with pytest.raises(Taken, match=r"anna has been reviewing .* look on, or take") as no:
        claim(store, record, "bo", "b1")
    assert no.value.by == "anna"
    assert claimed(store, record.take) == (mine,)
    assert claimed(store, "f" * 64) == ()
    assert mine.until - mine.since == timedelta(seconds=90)
    release(store, mine)
    assert claimed(store) == ()
    assert claim(store, record, "bo", "b1").operator == "bo"


def test_another_window_of_the_same_person_goes_on(store: Store, record: ReviewRecord) -> None:
    first = claim(store, record, "anna", "a1")
    second = claim(store, record, "anna", "a2")
    assert (second.session, second.since) == ("a2", first.since)
    release(store, first)  # the first window is closed late
    assert claimed(store) == (second,)


def test_a_claim_is_taken_over_on_purpose_and_its_owner_hears_of_it(
    store: Store, take: Take, record: ReviewRecord
) -> None:
    anna = ReviewSession(store, record)
    held = claim(store, record, "anna", "a1")
    anna.do(Accept((peak(1),)))
    taken = claim(store, record, "bo", "b1", take_over=True)
    with pytest.raises(Taken, match="bo has been reviewing"):
        renew(store, held)
    with pytest.raises(Taken, match="bo has taken this review over") as refused:
        anna.do(Accept((peak(9),)))
    assert refused.value.by == "bo"
    assert anna.unsaved == ()
    bo = ReviewSession(store, record, "bo")
    bo.do(Accept((peak(20),)))
    release(store, held)
    assert claimed(store) == (taken,)
    anna.refresh()
    assert [step.operator for step in anna.history.steps] == ["anna", "bo"]
    release(store, taken)
    anna.do(Accept((peak(9),)))


def test_silence_ends_a_claim(store: Store, record: ReviewRecord) -> None:
    silent = claim(store, record, "anna", "a1", lease_s=-1)
    assert claimed(store) == ()
    ReviewSession(store, record, "bo").do(Accept((peak(1),)))
    taken = claim(store, record, "bo", "b1")
    assert taken.since >= silent.since
    with pytest.raises(Taken):
        renew(store, silent)


def test_a_renewed_claim_stands_longer(store: Store, record: ReviewRecord) -> None:
    first = claim(store, record, "anna", "a1")
    time.sleep(0.01)
    later = renew(store, first)
    assert later.until > first.until
    assert later.since == first.since


def test_second_reviews_have_seats_of_their_own(store: Store, take: Take) -> None:
    for who in ("anna", "bo", "cleo"):
        mine = ReviewSession.open(store, take, who).record
        seat = "review" if who == "anna" else second_seat(who)
        claim(store, mine, who, who, seat=seat)
    assert [one.operator for one in claimed(store, take.content_hash)] == ["anna", "bo", "cleo"]
    for who in ("anna", "bo", "cleo"):
        ReviewSession.open(store, take, who).do(Accept((peak(1),)))


def test_of_many_at_once_one_gets_it(store: Store, record: ReviewRecord) -> None:
    n, start = 6, Barrier(6)

    def try_it(i: int) -> Claim | None:
        with Store(store.where) as own:
            start.wait(30)
            try:
                return claim(own, record, f"operator {i}", f"session {i}")
            except Taken:
                return None

    with ThreadPoolExecutor(n) as pool:
        got = [one for one in pool.map(try_it, range(n)) if one is not None]
    assert claimed(store) == tuple(got)
    assert len(got) == 1
