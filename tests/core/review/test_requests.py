"""Second reviews that are asked for are seen by those who may answer, until one does."""

import pytest

from markermend.errors import BadInput, StoreError
from markermend.model import Take
from markermend.review.requests import answer, ask, requests, take_back
from markermend.review.session import ReviewSession
from markermend.review.store import Store


@pytest.fixture
def known(store: Store, take: Take) -> str:
    store.remember(take)
    return take.content_hash


def test_a_request_is_seen_by_those_who_may_answer(store: Store, known: str) -> None:
    one = ask(store, known, "anna", "bo", note="before the paper")
    anybody = ask(store, known, "anna", blinded=False)
    assert requests(store) == (one, anybody)
    assert requests(store, operator="bo") == (one, anybody)
    assert requests(store, operator="cleo") == (anybody,)
    assert requests(store, operator="anna") == ()
    assert requests(store, take="f" * 64) == ()
    assert (one.blinded, anybody.blinded, one.note) == (True, False, "before the paper")
    assert one.at.tzinfo is not None


def test_asking_twice_is_asking_once(store: Store, known: str) -> None:
    assert ask(store, known, "anna", "bo") == ask(store, known, "anna", "bo")
    assert len(requests(store)) == 1


def test_a_review_answers_it_once(store: Store, known: str, take: Take) -> None:
    request = ask(store, known, "anna", "bo")
    review = ReviewSession.open(store, take, "bo").record.id
    answer(store, request, review)
    assert requests(store) == ()
    (done,) = requests(store, ended=True)
    assert (done.ended_by, done.review) == ("bo", review)
    assert done.ended is not None
    with pytest.raises(StoreError, match="has been answered or taken back"):
        answer(store, request, review)
    assert ask(store, known, "anna", "bo").id != request.id


def test_only_the_one_who_asked_takes_it_back(store: Store, known: str) -> None:
    request = ask(store, known, "anna")
    with pytest.raises(BadInput, match="anna asked for this review"):
        take_back(store, request, "bo")
    take_back(store, request, "anna")
    assert requests(store) == ()
    assert requests(store, ended=True)[0].review is None


def test_what_is_no_request_is_refused(store: Store, known: str, take: Take) -> None:
    with pytest.raises(BadInput, match="needs somebody else"):
        ask(store, known, "anna", "anna")
    with pytest.raises(BadInput, match="at most 2000"):
        ask(store, known, "anna", note="x" * 2001)
    with pytest.raises(StoreError, match="does not know the take"):
        ask(store, "f" * 64, "anna")
    request = ask(store, known, "anna")
    with pytest.raises(BadInput, match="is none of this take"):
        answer(store, request, 99)
    with pytest.raises(BadInput, match="somebody else has to make it"):
        answer(store, request, ReviewSession.open(store, take, "anna").record.id)
