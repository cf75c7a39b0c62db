"""A review being worked on: what was done, undone and redone, each step on disk before it shows."""

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from threading import RLock
from typing import Literal

from markermend.errors import Conflict, MarkerMendError, StoreError, Unreachable
from markermend.model import Take
from markermend.review.commands import Command, command_from_json
from markermend.review.state import Review
from markermend.review.store import Action, Entry, ReviewRecord, Store, new_token

_STRIDE = 64
"""A review is kept for every so many steps; those between are replayed when undo needs them."""


@dataclass(frozen=True)
class Step:
    """One command as it was done: when, and by whom."""

    command: Command
    at: datetime
    operator: str


@dataclass(frozen=True)
class _Unsaved:
    """Lines that the store did not acknowledge; it knows them by their token if it has them."""

    lines: tuple[tuple[Action, Command | None], ...]
    token: str

    @property
    def commands(self) -> tuple[Command, ...]:
        return tuple(command for _, command in self.lines if command is not None)


@dataclass(frozen=True)
class History:
    """All steps that can be undone or redone, oldest first.

    The first ``position`` of ``steps`` are in force, the others are undone.
    """

    steps: tuple[Step, ...]
    position: int


@dataclass(frozen=True)
class Change:
    """What one call changed, for a screen to select.

    Attributes
    ----------
    before, after
        The review then and now.
    ids
        Findings whose judgement differs, those of the commands first.
    commands
        What was done, undone or redone, in that order.
    """

    before: Review
    after: Review
    ids: tuple[str, ...]
    commands: tuple[Command, ...]

    @property
    def select(self) -> str | None:
        """The first changed finding that there is to look at afterwards, or None."""
        gone = {j.finding.id for j in self.before if j.added} - set(self.after.judgements)
        there = (i for i in self.ids if i not in gone and not self.after.is_replaced(i))
        return next(there, None)


class ReviewSession:
    """Past, present and future of one review, and the journal that keeps them.

    Every call writes to the journal first and shows its change after: what was acknowledged is on
    disk.  A new session on the same store replays the journal and has the same past, present and
    future.  Calls may come from several threads.

    Parameters
    ----------
    store
        Where the journal is kept.
    record
        Which review; see `ReviewSession.open`.
    operator
        Who works on it; by default the one whose review it is.

    Raises
    ------
    StoreError
        If the journal cannot be read.
    """

    def __init__(self, store: Store, record: ReviewRecord, operator: str | None = None) -> None:
        self.store = store
        self.record = record
        self.operator = operator or record.operator
        self._lock = RLock()
        self._past: list[Step] = []
        self._undone: list[Step] = []
        self._kept: dict[int, Review] = {0: Review()}
        self._present = Review()
        self._seq = 0
        self._unsaved: list[_Unsaved] = []
        self._follow(store.entries(record.id))

    @classmethod
    def open(
        cls, store: Store, take: Take, operator: str | None = None, purpose: str = "review"
    ) -> "ReviewSession":
        """Go on with the operator's review of a take, or begin it."""
        store.remember(take)
        return cls(store, store.review(take.content_hash, operator, purpose))

    @property
    def review(self) -> Review:
        """The present."""
        return self._present

    @property
    def history(self) -> History:
        """Everything that can be undone or redone."""
        with self._lock:
            return History((*self._past, *reversed(self._undone)), len(self._past))

    @property
    def unsaved(self) -> tuple[Command, ...]:
        """What was decided while the store did not answer; see `save`."""
        with self._lock:
            return tuple(command for one in self._unsaved for command in one.commands)

    @property
    def can_undo(self) -> bool:
        """Whether there is a past."""
        return bool(self._past)

    @property
    def can_redo(self) -> bool:
        """Whether there is a future."""
        return bool(self._undone)

    @property
    def decided(self) -> Mapping[str, Step]:
        """Finding id -> the last step that touched it: when it was decided, and by whom."""
        with self._lock:
            return {f.id: step for step in self._past for f in step.command.findings}

    def do(self, command: Command) -> Change:
        """Apply a command and write it down; one that changes nothing is not written.

        Raises
        ------
        BadInput
            If the command makes no sense on this review; nothing is written then.
        Conflict
            If the review was changed elsewhere; see `markermend.review.conflicts`.
        Taken
            If somebody else has taken the review over.
        Unreachable
            If the store does not answer; the command is kept in `unsaved` until it does.
        StoreError
            If it could not be written; the review is as before.
        """
        with self._lock:
            if self._unsaved:
                self._keep(command)
                return self.save()
            if command.apply(self._present) == self._present:
                return Change(self._present, self._present, (), (command,))
            return self._write([("do", command)])

    def save(self) -> Change:
        """Write what is still unsaved, in its order, each once.

        Raises
        ------
        Unreachable
            If the store still does not answer.
        Conflict
            If the review was changed elsewhere meanwhile; the error carries what was unsaved.
        Taken
            If somebody else has taken the review over meanwhile; it stays unsaved.
        """
        with self._lock:
            before, commands = self._present, list[Command]()
            while self._unsaved:
                commands += self._send(self._unsaved[0]).commands
            ids = tuple(before.changed(self._present))
            return Change(before, self._present, ids, tuple(commands))

    def drop_unsaved(self) -> None:
        """Give up what is unsaved."""
        with self._lock:
            self._unsaved.clear()

    def undo(self) -> Change | None:
        """Go one command back; None if there is no past."""
        with self._lock:
            self.save()
            return self.go_to(len(self._past) - 1) if self._past else None

    def redo(self) -> Change | None:
        """Go one command on; None if nothing was undone."""
        with self._lock:
            self.save()
            return self.go_to(len(self._past) + 1) if self._undone else None

    def go_to(self, position: int) -> Change:
        """Walk through the history: undo or redo until `position` commands are in force.

        Raises
        ------
        IndexError
            If the history is shorter than that.
        """
        with self._lock:
            distance = position - len(self._past)
            if position < 0 or distance > len(self._undone):
                raise IndexError(f"The history has no position {position}.")
            action: Action = "undo" if distance < 0 else "redo"
            return self._write([(action, None)] * abs(distance))

    def refresh(self) -> Change:
        """Take over what was done elsewhere since the last call."""
        with self._lock:
            return self._follow(self.store.entries(self.record.id, self._seq))

    def set_status(self, status: Literal["open", "finished"]) -> None:
        """Say that the review is finished, or open again."""
        self.store.set_status(self.record.id, status)

    def _write(self, lines: list[tuple[Action, Command | None]]) -> Change:
        if not lines:
            return self._follow(())
        fresh = _Unsaved(tuple(lines), new_token())
        self._unsaved.append(fresh)
        try:
            return self._send(fresh)
        except Unreachable:
            raise
        except StoreError:
            self._unsaved = [one for one in self._unsaved if one is not fresh]
            raise

    def _keep(self, command: Command) -> None:
        """Put a command after those that are unsaved, if it makes sense there."""
        review = self._present
        for one in self._unsaved:
            if len(one.commands) < len(one.lines):  # steps back and forth are not foreseen
                self.save()
                break
            for earlier in one.commands:
                review = earlier.apply(review)
        if command.apply(review) != review:
            self._unsaved.append(_Unsaved((("do", command),), new_token()))

    def _send(self, one: _Unsaved) -> Change:
        """Write the first of what is unsaved; it stays unsaved only where nobody answers."""
        records = [(act, None if said is None else said.to_json()) for act, said in one.lines]
        try:
            entries = self.store.append(
                self.record.id, self._seq, records, self.operator, one.token
            )
        except Unreachable as error:
            n = len(self.unsaved)
            kept = f" {n} decision{'s are' if n > 1 else ' is'} kept here, not saved yet."
            raise Unreachable(f"{error}{kept if n else ''}") from error
        except Conflict as conflict:
            mine = self.unsaved
            self._unsaved.clear()
            raise Conflict(str(conflict), mine, conflict.theirs) from conflict
        return self._follow(entries)

    def _follow(self, entries: tuple[Entry, ...]) -> Change:
        """Let the entries of the journal happen: live and in a replay this is the only way."""
        before = self._present
        commands = tuple(self._happen(entry) for entry in entries)
        there = {entry.token for entry in entries}
        self._unsaved = [one for one in self._unsaved if one.token not in there]
        touched = dict.fromkeys(f.id for command in commands for f in command.findings)
        differ = before.changed(self._present)
        first = [id_ for id_ in touched if id_ in set(differ)]
        return Change(before, self._present, tuple(dict.fromkeys((*first, *differ))), commands)

    def _happen(self, entry: Entry) -> Command:
        try:
            if entry.action == "do":
                step = Step(command_from_json(entry.command or {}), entry.at, entry.operator)
                present = step.command.apply(self._present)
                self._past.append(step)
                self._undone.clear()
                # What an abandoned future left further on is overwritten before it is reached.
                if len(self._past) % _STRIDE == 0:
                    self._kept[len(self._past)] = present
            elif entry.action == "undo":
                step = self._past.pop()
                self._undone.append(step)
                present = self._at(len(self._past))
            else:
                step = self._undone.pop()
                present = step.command.apply(self._present)
                self._past.append(step)
        except (MarkerMendError, LookupError, TypeError, ValueError) as error:
            raise StoreError(
                f"Line {entry.seq} of the journal of review {self.record.id} in "
                f"{self.store.where} cannot be replayed ({error}); update markermend, "
                "or go back to a backup."
            ) from error
        self._present, self._seq = present, entry.seq
        return step.command

    def _at(self, position: int) -> Review:
        start = max(n for n in self._kept if n <= position)
        review = self._kept[start]
        for step in self._past[start:position]:
            review = step.command.apply(review)
        return review
