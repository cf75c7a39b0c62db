"""Undo, redo and restart: past, present and future are always those of a replay."""

import numpy as np
import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    initialize,
    invariant,
    rule,
    run_state_machine_as_test,
)
from sqlalchemy import event, update

from markermend.errors import BadInput, Conflict, StoreError
from markermend.model import KINDS, Finding, Span, Take
from markermend.review import (
    Accept,
    AddFinding,
    Annotate,
    Choose,
    Command,
    Defer,
    Merge,
    MoveEdges,
    Reclassify,
    Reject,
    RemoveAdded,
    Reopen,
    Review,
    Split,
)
from markermend.review import session as session_module
from markermend.review.schema import journal
from markermend.review.session import ReviewSession
from markermend.review.store import Store

DETECTED = tuple(
    Finding(marker, Span(start, start + 4), kind, 0.5, amplitude=3.0)
    for marker in ("A", "B")
    for start, kind in ((0, "gap"), (3, "peak"), (8, "noise"))
)
OPERATORS = ("anna", "bo")
spans = st.integers(0, 12).flatmap(lambda a: st.integers(a + 1, 14).map(lambda b: Span(a, b)))
parameters = st.dictionaries(
    st.sampled_from(["window", "order"]),
    st.one_of(st.integers(), st.floats(allow_nan=False, allow_infinity=False), st.booleans()),
    max_size=2,
)
methods = st.sampled_from(["", "linear", "rigid", "leave"])


def commands(review: Review) -> st.SearchStrategy[Command]:
    """Any command on what there is to look at; some make no sense, and must then do nothing."""
    one = st.sampled_from(review.live(DETECTED) or DETECTED).map(lambda finding: (finding,))
    some = st.lists(one.map(lambda found: found[0]), min_size=1, max_size=3).map(tuple)
    missed = st.builds(Finding, st.sampled_from("AB"), spans, st.sampled_from(KINDS))
    return st.one_of(
        st.builds(Accept, some, methods, parameters),
        st.builds(Choose, some, methods, parameters),
        st.sampled_from([Reject, Defer, Reopen]).flatmap(lambda kind: st.builds(kind, some)),
        st.builds(Reclassify, some, st.sampled_from(KINDS)),
        st.builds(MoveEdges, one, spans),
        st.builds(Annotate, some, st.text(max_size=5)),
        st.builds(AddFinding, missed.map(lambda finding: (finding,))),
        st.builds(RemoveAdded, one),
        st.builds(Split, one, st.integers(0, 14)),
        st.builds(Merge, some),
    )


class Desk(RuleBasedStateMachine):
    """Two operators on one take, beside a model that keeps every state there ever was."""

    store: Store
    takes = 0

    @initialize()
    def open(self) -> None:
        type(self).takes += 1
        self.take = Take(np.full((1, 1, 3), self.takes), 100.0, ("A",))
        self.sessions = {who: ReviewSession.open(self.store, self.take, who) for who in OPERATORS}
        self.states = {who: [Review()] for who in OPERATORS}  # all that redo can still reach
        self.at = dict.fromkeys(OPERATORS, 0)

    who = st.sampled_from(OPERATORS)

    @rule(who=who, data=st.data())
    def do(self, who: str, data: st.DataObject) -> None:
        session, before = self.sessions[who], self.present(who)
        command = data.draw(commands(before))
        try:
            after = command.apply(before)
        except BadInput:
            with pytest.raises(BadInput):
                session.do(command)
            return
        change = session.do(command)
        assert (change.before, change.after) == (before, after)
        assert set(change.ids) == set(before.changed(after))
        if after != before:
            self.at[who] += 1
            self.states[who][self.at[who] :] = [after]

    @rule(who=who)
    def undo(self, who: str) -> None:
        before = self.present(who)
        change = self.sessions[who].undo()
        if self.at[who] == 0:
            assert change is None
            return
        self.at[who] -= 1
        assert change is not None
        assert set(change.ids) == set(before.changed(self.present(who)))

    @rule(who=who)
    def redo(self, who: str) -> None:
        change = self.sessions[who].redo()
        if self.at[who] + 1 == len(self.states[who]):
            assert change is None
        else:
            self.at[who] += 1

    @rule(who=who, data=st.data())
    def walk(self, who: str, data: st.DataObject) -> None:
        self.at[who] = data.draw(st.integers(0, len(self.states[who]) - 1))
        self.sessions[who].go_to(self.at[who])

    @rule(who=who)
    def restart(self, who: str) -> None:
        history = self.sessions[who].history
        self.sessions[who] = ReviewSession.open(self.store, self.take, who)
        assert self.sessions[who].history == history

    @rule(who=who)
    def second_window(self, who: str) -> None:
        """Somebody else writes to the same review: seen as a conflict, never lost."""
        session = self.sessions[who]
        other = ReviewSession(self.store, session.record, "visitor")
        added = Finding("C", Span(self.at[who], self.at[who] + 1), "slow")
        if added.id in self.present(who).judgements:
            return
        other.do(AddFinding((added,)))
        with pytest.raises(Conflict):
            session.do(AddFinding((Finding("D", Span(0, 1), "slow"),)))
        assert session.review == self.present(who)
        assert session.refresh().after == other.review
        self.at[who] += 1
        self.states[who][self.at[who] :] = [other.review]

    @invariant()
    def the_present_is_the_models(self) -> None:
        for who, session in self.sessions.items():
            assert session.review == self.present(who)
            assert session.history.position == self.at[who]
            assert len(session.history.steps) == len(self.states[who]) - 1
            assert session.can_undo == (self.at[who] > 0)
            assert session.can_redo == (self.at[who] + 1 < len(self.states[who]))

    @invariant()
    def nothing_detected_vanishes(self) -> None:
        """Each detected finding is live, or chains of replacements end in live ones."""
        for who in self.sessions:
            review = self.present(who)
            live = {finding.id for finding in review.live(DETECTED)}
            for finding in DETECTED:
                reached, rim = set(), {finding.id}
                while rim:
                    reached |= rim
                    rim = {
                        r for i in rim if i in review.judgements
                        for r in review.judgements[i].replaced_by
                    } - reached  # fmt: skip
                assert reached & live

    def present(self, who: str) -> Review:
        return self.states[who][self.at[who]]

    def teardown(self) -> None:
        for who, session in self.sessions.items():
            replayed = ReviewSession.open(self.store, self.take, who)
            assert replayed.review == self.present(who)
            assert replayed.history == session.history


def test_past_present_and_future_are_those_of_a_replay(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(session_module, "_STRIDE", 3)  # so that undo meets kept states and gaps
    in_file = store._engine.dialect.name == "sqlite"
    if in_file:
        # Thousands of commits: waiting for the disk is not what is tested here.
        event.listen(store._engine, "connect", lambda c, _: c.execute("PRAGMA synchronous = OFF"))
        store._engine.dispose()
    machine = type("Desk", (Desk,), {"store": store})
    run_state_machine_as_test(
        machine,
        settings=settings(
            max_examples=25 if in_file else 10,
            stateful_step_count=25,
            deadline=None,
            derandomize=True,
        ),
    )


def peak(n: int) -> Finding:
    return Finding("A", Span(n, n + 3), "peak", amplitude=3.0)


def test_hundreds_of_steps_back_and_forth(store: Store, take: Take) -> None:
    session = ReviewSession.open(store, take, "anna")
    states = [
        session.review,
        *(session.do(Accept((peak(n),), "pchip", {"n": n})).after for n in range(131)),
    ]
    for position in (100, 63, 64, 65, 128, 0, 131, 7):
        session.go_to(position)
        assert session.review == states[position]
    session.do(Reject((peak(140),)))
    assert not session.can_redo
    assert session.undo().after == states[7]  # type: ignore[union-attr]


@pytest.mark.parametrize("position", [-1, 2])
def test_history_has_two_ends(store: Store, take: Take, position: int) -> None:
    session = ReviewSession.open(store, take, "anna")
    session.do(Accept((peak(1),)))
    with pytest.raises(IndexError, match=f"no position {position}"):
        session.go_to(position)
    assert session.go_to(1).ids == ()


def test_what_changes_nothing_is_not_written(store: Store, take: Take) -> None:
    session = ReviewSession.open(store, take, "anna")
    session.do(Accept((peak(1),)))
    assert session.do(Accept((peak(1),))).ids == ()
    assert len(store.entries(session.record.id)) == 1


def test_a_change_says_what_to_select(store: Store, take: Take) -> None:
    session = ReviewSession.open(store, take, "anna")
    whole = peak(10)
    assert session.do(Accept((peak(5), whole))).select == peak(5).id
    split = session.do(Split((whole,), 12))
    assert split.ids[0] == whole.id
    assert split.select == Finding("A", Span(10, 12), "peak").id
    assert session.undo().select == whole.id  # type: ignore[union-attr]
    added = Finding("B", Span(0, 5), "slow")
    assert session.do(AddFinding((added,))).select == added.id
    assert session.undo().select is None  # type: ignore[union-attr]


def test_it_is_known_who_decided_and_when(store: Store, take: Take) -> None:
    session = ReviewSession.open(store, take, "anna")
    session.do(Accept((peak(1), peak(9))))
    helper = ReviewSession(store, session.record, "bo")
    helper.do(Reject((peak(9),)))
    session.refresh()
    assert {id_: step.operator for id_, step in session.decided.items()} == {
        peak(1).id: "anna",
        peak(9).id: "bo",
    }
    first, second = session.history.steps
    assert first.at <= second.at
    assert first.at.tzinfo is not None


def test_a_refused_write_leaves_the_session_as_it_was(file_store: Store, take: Take) -> None:
    session = ReviewSession.open(file_store, take, "anna")
    session.do(Accept((peak(1),)))
    before = session.review
    with file_store._engine.connect() as connection:
        pages = connection.exec_driver_sql("PRAGMA page_count").scalar_one()
        connection.exec_driver_sql(f"PRAGMA max_page_count = {pages}")
    with pytest.raises(StoreError, match="no room left"):
        session.do(Annotate((peak(1),), "x" * 100_000))
    assert session.review == before
    with file_store._engine.connect() as connection:
        connection.exec_driver_sql("PRAGMA max_page_count = 1000000")
    session.do(Annotate((peak(1),), "x" * 100_000))
    assert ReviewSession(file_store, session.record).review == session.review


def test_a_journal_of_a_newer_version_is_refused(store: Store, take: Take) -> None:
    session = ReviewSession.open(store, take, "anna")
    store.append(session.record.id, 0, [("do", {"command": "teleport"})], "anna")
    with pytest.raises(StoreError, match=r"Line 1 of the journal.*'teleport'.*update markermend"):
        ReviewSession(store, session.record)


def test_a_damaged_journal_is_refused(store: Store, take: Take) -> None:
    session = ReviewSession.open(store, take, "anna")
    session.do(Accept((peak(1),)))
    with store.transaction() as connection:
        connection.execute(update(journal).values(command={"command": "accept"}))
    with pytest.raises(StoreError, match="cannot be replayed"):
        ReviewSession(store, session.record)
