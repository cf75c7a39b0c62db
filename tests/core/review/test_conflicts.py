"""Two on one review: a refusal that carries both sides, settled in one of three ways."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from markermend.errors import BadInput, Conflict, UnknownName
from markermend.model import Finding, Span, Take
from markermend.review import Accept, AddFinding, Annotate, Command, Reject, Review, Split
from markermend.review.conflicts import WAYS, mine, resolve, sides, theirs
from markermend.review.session import ReviewSession
from markermend.review.store import Store


def peak(n: int) -> Finding:
    return Finding("A", Span(n, n + 3), "peak")


def refused(session: ReviewSession, command: Command) -> Conflict:
    with pytest.raises(Conflict) as caught:
        session.do(command)
    return caught.value


@pytest.fixture
def pair(store: Store, take: Take) -> tuple[ReviewSession, ReviewSession]:
    """Two windows on one review, in which one decision has been made."""
    anna = ReviewSession.open(store, take, "anna")
    anna.do(Accept((peak(1),)))
    return anna, ReviewSession(store, anna.record, "bo")


def test_a_conflict_carries_both_sides(pair: tuple[ReviewSession, ReviewSession]) -> None:
    anna, bo = pair
    bo.do(Reject((peak(1),)))
    bo.undo()
    command = Annotate((peak(1),), "left heel")
    conflict = refused(anna, command)
    assert mine(conflict) == (command,)
    assert [entry.action for entry in theirs(conflict)] == ["do", "undo"]
    assert sides(conflict) == (
        ("Note on A peak 1-4",),
        ("bo: Reject A peak 1-4", "bo: One step back"),
    )
    assert anna.unsaved == ()


def test_mine_stands_where_both_decided(pair: tuple[ReviewSession, ReviewSession]) -> None:
    anna, bo = pair
    bo.do(Reject((peak(1), peak(9))))
    conflict = refused(anna, Accept((peak(1),), "pchip"))
    assert resolve(anna, conflict, "mine") is anna
    assert anna.review.decision(peak(1)).method == "pchip"
    assert anna.review.decision(peak(1)).verdict == "accepted"
    assert anna.review.decision(peak(9)).verdict == "rejected"
    assert bo.refresh().after == anna.review


def test_theirs_stands(pair: tuple[ReviewSession, ReviewSession]) -> None:
    anna, bo = pair
    bo.do(Reject((peak(1),)))
    assert resolve(anna, refused(anna, Accept((peak(9),))), "theirs") is anna
    assert anna.review == bo.review


def test_both_stand_apart(pair: tuple[ReviewSession, ReviewSession], store: Store) -> None:
    anna, bo = pair
    before = store.entries(anna.record.id)
    for number in (1, 2):
        bo.do(Reject((peak(10 * number),)))
        conflict = refused(anna, Accept((peak(9),)))
        apart = resolve(anna, conflict, "both")
        assert apart.record.purpose == f"review apart {number}"
        assert apart.record.operator == "anna"
        assert anna.review == bo.review
        assert apart.review.decision(peak(9)).verdict == "accepted"
        assert not apart.review.decision(peak(10 * number)).verdict
    first = store.reviews()[1]
    assert store.entries(first.id)[: len(before)] == before  # who and when are kept too


def test_what_makes_no_sense_any_more_is_refused_whole(
    pair: tuple[ReviewSession, ReviewSession],
) -> None:
    anna, bo = pair
    bo.do(Split((peak(1),), 2))
    conflict = refused(anna, Reject((peak(1),)))
    with pytest.raises(BadInput, match="was split or merged"):
        resolve(anna, conflict, "mine")
    assert anna.review == bo.review
    assert resolve(anna, conflict, "both").review.decision(peak(1)).verdict == "rejected"


def test_there_are_three_ways(pair: tuple[ReviewSession, ReviewSession]) -> None:
    anna, bo = pair
    bo.do(Reject((peak(1),)))
    with pytest.raises(UnknownName, match="known are mine, theirs, both"):
        resolve(anna, refused(anna, Accept((peak(9),))), "ours")  # type: ignore[arg-type]


decisions = st.lists(
    st.builds(
        lambda kind, n: kind((peak(n),)),
        st.sampled_from([Accept, Reject, AddFinding]),
        st.integers(0, 5),
    ),
    min_size=1,
    max_size=5,
)


@settings(max_examples=15, deadline=None, derandomize=True)
@given(base=decisions, others=decisions, own=decisions, way=st.sampled_from(WAYS))
def test_no_decision_is_lost_in_any_way(
    tmp_path_factory: pytest.TempPathFactory,
    base: list[Command],
    others: list[Command],
    own: list[Command],
    way: str,
) -> None:
    """Every line ever written stays; what was refused is in one review or was given up."""
    take = Take([[[0.0, 0.0, 0.0]]], 100.0, ("A",))
    with Store(tmp_path_factory.mktemp("conflict") / "reviews.sqlite") as store:
        anna = ReviewSession.open(store, take, "anna")
        _do_all(anna, base)
        bo = ReviewSession(store, anna.record, "bo")
        _do_all(bo, others)
        written = store.entries(anna.record.id)
        for command in own:
            try:
                anna.do(command)
            except BadInput:
                continue
            except Conflict as conflict:
                try:
                    after = resolve(anna, conflict, way)  # type: ignore[arg-type]
                except BadInput:
                    assert way == "mine"
                    break
                assert way == "theirs" or _in_force(command, after.review)
                break
        assert store.entries(anna.record.id)[: len(written)] == written
        for record in store.reviews():
            ReviewSession(store, record)


def _do_all(session: ReviewSession, commands: list[Command]) -> None:
    for command in commands:
        try:
            session.do(command)
        except BadInput:
            continue


def _in_force(command: Command, review: Review) -> bool:
    return all(finding.id in review.judgements for finding in command.findings)
