"""Reviews: what was acknowledged is there, whatever happens, and undo always tells the truth."""

import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from hypothesis import HealthCheck, Phase, settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    initialize,
    invariant,
    rule,
    run_state_machine_as_test,
)
from sqlalchemy import event
from tests.trust._frame import ROOT, Budget, Outcome, Tally, child_environment

from markermend.errors import BadInput, Conflict
from markermend.model import KINDS, Finding, Span, Take
from markermend.review import (
    COMMANDS,
    VERDICTS,
    Accept,
    AddFinding,
    Adopt,
    Annotate,
    Choose,
    Command,
    Decision,
    Defer,
    Merge,
    MoveEdges,
    Reclassify,
    Reject,
    RemoveAdded,
    Reopen,
    Review,
    Split,
    command_from_json,
)
from markermend.review.session import ReviewSession
from markermend.review.store import Store

MINUTES = 24.0
OPERATORS = ("anna", "bo")
FOUND = tuple(
    Finding(marker, Span(start, start + 5), kind, 0.5, amplitude=3.0)
    for marker in ("A", "B")
    for start, kind in ((0, "gap"), (3, "peak"), (12, "step"))
)


def run(budget: Budget) -> Iterator[Outcome]:
    """Yield a row for the state machine and one for each database that is killed."""
    yield _machine(budget.share(0.35))
    with tempfile.TemporaryDirectory() as folder:
        where = str(Path(folder) / "reviews.sqlite")
        yield _killed("SQLite", where, budget.share(0.5), budget.of(100, 1))
    if not budget.short:
        yield _on_a_server(budget)


def _commands(review: Review) -> st.SearchStrategy[Command]:
    there = review.live(FOUND) or FOUND
    one = st.sampled_from(there).map(lambda finding: (finding,))
    some = st.lists(st.sampled_from(there), min_size=1, max_size=3, unique_by=_id).map(tuple)
    edges = st.tuples(st.integers(0, 20), st.integers(1, 9)).map(lambda e: Span(e[0], sum(e)))
    fresh = st.builds(Finding, st.sampled_from("AB"), edges, st.sampled_from(KINDS))
    method = st.sampled_from(["", "linear", "leave"])
    ways = {
        Accept: st.builds(Accept, some, method, st.just({"context": 4})),
        Choose: st.builds(Choose, some, method),
        Reject: st.builds(Reject, some),
        Defer: st.builds(Defer, some),
        Reopen: st.builds(Reopen, some),
        Reclassify: st.builds(Reclassify, some, st.sampled_from(KINDS)),
        Adopt: some.flatmap(_adoptions),
        MoveEdges: st.builds(MoveEdges, one, edges),
        Annotate: st.builds(Annotate, some, st.text(max_size=8)),
        AddFinding: st.builds(AddFinding, fresh.map(lambda finding: (finding,))),
        RemoveAdded: st.builds(RemoveAdded, one),
        Split: st.builds(Split, one, st.integers(0, 25)),
        Merge: st.builds(Merge, some),
    }
    assert set(ways) == set(COMMANDS.values()), "a command is not tried"
    return st.one_of(*ways.values())


def _id(finding: Finding) -> str:
    return finding.id


def _adoptions(found: tuple[Finding, ...]) -> st.SearchStrategy[Command]:
    decision = st.builds(
        Decision,
        st.sampled_from([*VERDICTS, None]),
        st.sampled_from([*KINDS, None]),
        note=st.text(),
    )
    n = len(found)
    return st.builds(
        Adopt,
        st.just(found),
        st.lists(decision, min_size=n, max_size=n).map(tuple),
        st.lists(st.booleans(), min_size=n, max_size=n).map(tuple),
    )


class _Desk(RuleBasedStateMachine):
    """Two operators, each with a window on the review of both, and the journal replayed by hand."""

    store: Store
    tally: Tally
    budget: Budget
    takes = 0

    @initialize()
    def open(self) -> None:
        type(self).takes += 1
        self.take = Take(np.full((40, 2, 3), self.takes), 100.0, ("A", "B"))
        self.windows = {
            (who, whose): self._window(who, whose) for who in OPERATORS for whose in OPERATORS
        }

    def _window(self, who: str, whose: str) -> ReviewSession:
        record = ReviewSession.open(self.store, self.take, whose).record
        return ReviewSession(self.store, record, who)

    where = st.tuples(st.sampled_from(OPERATORS), st.sampled_from(OPERATORS))

    @rule(where=where, data=st.data())
    def do(self, where: tuple[str, str], data: st.DataObject) -> None:
        window = self.windows[where]
        command = data.draw(_commands(window.review))
        self._act(where, lambda: window.do(command))

    @rule(where=where)
    def undo(self, where: tuple[str, str]) -> None:
        self._act(where, self.windows[where].undo)

    @rule(where=where)
    def redo(self, where: tuple[str, str]) -> None:
        self._act(where, self.windows[where].redo)

    @rule(where=where, share=st.floats(0, 1))
    def walk(self, where: tuple[str, str], share: float) -> None:
        window = self.windows[where]
        self._act(where, lambda: window.go_to(round(share * len(window.history.steps))))

    @rule(where=where)
    def restart(self, where: tuple[str, str]) -> None:
        self.windows[where] = self._window(*where)

    @rule(where=where)
    def refresh(self, where: tuple[str, str]) -> None:
        self.windows[where].refresh()

    def _act(self, where: tuple[str, str], act) -> None:
        """Do it; a refusal must leave this window and the journal as they were."""
        window = self.windows[where]
        before = (window.review, window.history, self.store.entries(window.record.id))
        try:
            act()
        except (BadInput, Conflict):
            after = (window.review, window.history, self.store.entries(window.record.id))
            assert after == before, "a refusal changed something"
            window.refresh()

    @invariant()
    def every_window_is_its_replay(self) -> None:
        if not hasattr(self, "windows"):
            return
        for window in self.windows.values():
            entries = self.store.entries(window.record.id)
            known = entries[: window._seq]
            past, undone = _replayed(known)
            review = Review()
            for command in past:
                review = command.apply(review)
            steps = [step.command for step in window.history.steps]
            assert window.review == review, "the present is not that of a replay"
            assert steps == [*past, *reversed(undone)], "past or future is not that of a replay"
            assert window.history.position == len(past), "the position is not that of a replay"
        self.tally.case()


def _replayed(entries) -> tuple[list[Command], list[Command]]:
    """Replay a journal with nothing but two stacks: what is done, and what is undone."""
    past: list[Command] = []
    undone: list[Command] = []
    for entry in entries:
        if entry.action == "do":
            past.append(command_from_json(entry.command))
            undone = []
        elif entry.action == "undo":
            undone.append(past.pop())
        else:
            past.append(undone.pop())
    return past, undone


def _machine(budget: Budget) -> Outcome:
    tally = Tally("reviews: every command, undo, redo, restart, two operators")
    with tempfile.TemporaryDirectory() as folder, Store(Path(folder) / "r.sqlite") as store:
        # Thousands of commits: waiting for the disk is what the kills are for.
        event.listen(store._engine, "connect", lambda c, _: c.execute("PRAGMA synchronous = OFF"))
        store._engine.dispose()
        machine = type("Desk", (_Desk,), {"store": store, "tally": tally, "budget": budget})
        rounds = 0
        while rounds < budget.of(40, 1) and not budget.spent:
            rounds += 1
            try:
                run_state_machine_as_test(
                    machine,
                    settings=settings(
                        max_examples=budget.of(10, 3), stateful_step_count=budget.of(40, 12),
                        deadline=None, database=None, suppress_health_check=list(HealthCheck),
                        phases=[Phase.generate],
                    ),
                )  # fmt: skip
            except Exception as error:  # noqa: BLE001 - whatever is raised is a fault to report
                tally.case(f"{type(error).__name__}: {str(error)[:150]}", lost=True)
                break
    return tally.outcome("steps after which all was compared with a replay of the journal")


_CHILD = """
import json, random, sys
import numpy as np
from markermend.model import Finding, Span, Take
from markermend.review import Accept, Annotate, Reject
from markermend.review.session import ReviewSession
from markermend.review.store import Store
where, who, seed = sys.argv[1:]
rng = random.Random(int(seed))
take = Take(np.zeros((9, 1, 3)), 100.0, ("A",))
session = ReviewSession.open(Store(where), take, who)
print(json.dumps([len(session.store.entries(session.record.id)), "opened"]), flush=True)
n = 0
while True:
    n += 1
    found = (Finding("A", Span(n, n + rng.randint(1, 9)), "peak", amplitude=float(n)),)
    kind = rng.random()
    if kind < 0.2 and session.can_undo:
        session.undo()
    elif kind < 0.3 and session.can_redo:
        session.redo()
    elif kind < 0.5:
        session.do(Annotate(found, f"{seed} {n}"))
    else:
        session.do((Accept if kind < 0.8 else Reject)(found))
    last = session.store.entries(session.record.id)[-1]
    print(json.dumps([last.seq, last.action, last.command]), flush=True)
"""


@contextmanager
def _working(
    where: str, who: str, seed: int, said: int = subprocess.PIPE
) -> Iterator[subprocess.Popen[str]]:
    child = subprocess.Popen(
        [sys.executable, "-c", _CHILD, where, who, str(seed)],
        cwd=ROOT, env=child_environment(), stdout=said, text=True,
    )  # fmt: skip
    try:
        yield child
    finally:
        child.kill()
        child.communicate()


def _on_a_server(budget: Budget) -> Outcome:
    """Do the same on a PostgreSQL server of our own, where there is one."""
    with subprocess.Popen(
        [sys.executable, ROOT / "tests" / "postgres.py"],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, start_new_session=True,
    ) as server:  # fmt: skip
        assert server.stdin is not None
        assert server.stdout is not None
        try:
            said = json.loads(server.stdout.readline())
            if "why" in said:
                subject = "kill -9 at random moments under load (PostgreSQL)"
                return Outcome(subject, 0, note=f"not tried: {said['why']}")
            return _killed("PostgreSQL", said["address"], budget, 100)
        finally:
            server.stdin.close()
            server.wait(timeout=60)


def _killed(database: str, where: str, budget: Budget, kills: int) -> Outcome:
    """Kill a process that decides, at any moment, while another works on the same store."""
    tally = Tally(f"kill -9 at random moments under load ({database})", kills)
    rng = np.random.default_rng(budget.seed)
    acknowledged = 0
    Store(where).close()
    with _working(where, "bo", 0, subprocess.DEVNULL) as other:
        for i in range(kills):
            if budget.spent:
                break
            with _working(where, "anna", i + 1) as child:
                assert child.stdout is not None
                child.stdout.readline()
                time.sleep(float(rng.uniform(0.0, 0.3)))
                child.kill()
                said = [json.loads(line) for line in child.stdout if line.endswith("\n")]
            acknowledged += len(said)
            fault = _missing(where, said)
            tally.case(fault, lost=bool(fault))
            if other.poll() is not None:
                tally.case("the process that was not killed has ended")
                break
    return tally.outcome(f"{acknowledged} acknowledged decisions looked up again")


def _missing(where: str, said: list[list]) -> str:
    take = Take(np.zeros((9, 1, 3)), 100.0, ("A",))
    with Store(where) as store:
        session = ReviewSession.open(store, take, "anna")
        entries = {e.seq: [e.seq, e.action, e.command] for e in store.entries(session.record.id)}
        past, _ = _replayed(store.entries(session.record.id))
    for record in said:
        if entries.get(record[0]) != record:
            return f"entry {record[0]} of {len(entries)} is not what was acknowledged"
    if [step.command for step in session.history.steps[: session.history.position]] != past:
        return "the reopened review is not that of its journal"
    return ""
