"""What the operator decides: verdicts, kinds, edges, notes, spans added, split and merged."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import param

from markermend.model import Finding, Kind, Span
from markermend.repairing import Wish
from markermend.review import (
    Accept,
    AddFinding,
    Annotate,
    Command,
    Defer,
    Merge,
    MoveEdges,
    Reclassify,
    Reject,
    RemoveAdded,
    Reopen,
    Split,
)
from markermend.review.session import Change
from markermend_app.state import computing
from markermend_app.state.jobs import Ticket
from markermend_app.state.queueing import Queueing

LIKE = 2.0
"""Findings are similar whose sizes differ by less than this factor."""


class Deciding(Queueing):
    """The operator's intentions on findings; each is one command."""

    adding: bool = param.Boolean(False, doc="Whether dragging in the lanes adds a span.")
    begun: int | None = param.Integer(default=None, allow_None=True, doc="Where I was pressed.")
    similar: tuple[Finding, ...] = param.Parameter((), doc="What a decision on all would touch.")
    expected: dict[str, float] = param.Parameter({}, doc="Finding id -> expected error in mm.")

    def __init__(self, *given: Any, **values: Any) -> None:
        super().__init__(*given, **values)
        self._unmeasured: dict[
            tuple[str, Span, str], tuple[Wish, tuple[tuple[str, Span], ...]]
        ] = {}
        self._accepting = ""  # the finding to be accepted once its repair is there

    def _forget(self) -> None:
        super()._forget()
        self._unmeasured.clear()

    # verdicts

    def accept(self) -> None:
        """Accept the chosen repair and go on, as soon as it is computed."""
        repair = self.repair
        if repair is None:
            self._accepting = self.selected
            return
        current, masked = self.current, self._masked(self.selected)
        # It is shown as accepted without being computed again.
        self.mended = self.mended | {(repair.marker, repair.span, repair.method): repair}
        self._decide(lambda f: Accept((f,), repair.method, repair.parameters))
        if current is not None and repair.expected_mm is None and repair.method != "leave":
            self._measure(self.judged(current).wish, masked)

    def _measure(self, wish: Wish, masked: tuple[tuple[str, Span], ...]) -> None:
        """Find out the error to be expected of what was accepted before it was compared."""
        opened = self.opened
        assert opened is not None
        self._unmeasured[(wish.marker, wish.span, wish.method)] = (wish, masked)

        def work(ticket: Ticket) -> None:
            worker = self.workspace.worker
            for key, (wish, masked) in list(self._unmeasured.items()):
                error = worker.call(
                    computing.expected, worker.lend(opened.take), wish, masked, wish.method
                )
                if not ticket.valid():
                    return  # whoever took over measures it
                ticket.tell(lambda k=key, e=error: self._measured(k, e))  # type: ignore[misc]

        self.jobs.run("measure", work, lambda _: None)

    def _measured(self, key: tuple[str, Span, str], error: float) -> None:
        self._unmeasured.pop(key, None)
        done = self.mended.get(key)
        if done is not None and np.isfinite(error):
            self.mended = self.mended | {key: replace(done, expected_mm=error)}

    def leave(self) -> None:
        """Leave the span as a gap and go on."""
        self._decide(lambda f: Accept((f,), "leave"))

    def reject(self) -> None:
        """Say that it is a false alarm and go on."""
        self._decide(lambda f: Reject((f,)))

    def defer(self) -> None:
        """Set it aside and go on."""
        self._decide(lambda f: Defer((f,)))

    def reopen(self) -> None:
        """Take the verdict back and stay."""
        if self.current is not None and self.judged(self.current).decision.verdict:
            self.do(Reopen((self.current,)))
            self.select(self.selected)

    def _decide(self, command: Callable[[Finding], Command]) -> None:
        current = self.current
        if current is None:
            return
        self._go_on(current, self.do, command(current))

    def _go_on(
        self, current: Finding, do: Callable[[Command], Change | None], command: Command
    ) -> None:
        """Let the command happen and go to the finding that came after in the queue."""
        queue = [f.id for f in self.queue]
        at = queue.index(current.id) if current.id in queue else 0
        self._accepting = ""
        with param.parameterized.batch_call_watchers(self):
            do(command)
            left = self.queue
            # What was found only after the operator had come here was not passed.
            passed = {current.id, *queue[:at]} - self._arrived
            after = next((f for f in left if f.id not in passed), None)
            self.select(after or (left[0] if left else current))

    def _offered(self, offer: Any) -> None:
        super()._offered(offer)
        if self._accepting and self._accepting == self.selected and self.repair is not None:
            self.accept()

    def select(self, finding: Finding | str | None) -> None:
        """Put a finding at hand; an acceptance that still waits for its repair is given up."""
        self._accepting = ""
        super().select(finding)

    # what it is and where

    def reclassify(self, kind: Kind) -> None:
        """Say that it is of another kind and stay."""
        if self.current is not None:
            self.do(Reclassify((self.current,), kind))
            self.select(self.selected)

    def annotate(self, note: str) -> None:
        """Leave a note, or remove it."""
        if self.current is not None:
            self.do(Annotate((self.current,), note.strip()[:2000]))
        self.dialog = ""

    def move_edges(self, start: int, stop: int) -> None:
        """Say where the finding at hand starts and stops."""
        current = self.current
        if current is None or self.opened is None:
            return
        start, stop = max(0, start), min(self.opened.take.n_frames, stop)
        if start >= stop:
            self.fail("A span starts before it stops; move the playhead to the other side.")
            return
        if Span(start, stop) != self.span:
            self.do(MoveEdges((current,), Span(start, stop)))
            frame, window, zoom = self.frame, self.window, self.zoom
            with param.parameterized.batch_call_watchers(self):
                self.select(self.selected)
                self.param.update(frame=frame, window=window, zoom=zoom)

    def start_here(self) -> None:
        """Let the span start at the playhead."""
        if self.span is not None:
            self.move_edges(self.frame, self.span.stop)

    def stop_here(self) -> None:
        """Let the span end with the frame under the playhead."""
        if self.span is not None:
            self.move_edges(self.span.start, self.frame + 1)

    def split(self) -> None:
        """Make two findings of one, before and from the playhead."""
        if self.current is not None:
            self._keep_looking(self.do(Split((self.current,), self.frame)))

    def merge(self) -> None:
        """Make one finding of this one and the next of the same marker."""
        current = self.current
        if current is None:
            return
        later = [
            f
            for f in self.findings
            if f.marker == current.marker
            and f.id != current.id
            and self.judged(f).span.start >= self.judged(current).span.start
        ]
        if not later:
            self.fail(f"{current.marker} has no later finding to merge with.")
            return
        after = min(later, key=lambda f: self.judged(f).span)
        self._keep_looking(self.do(Merge((current, after))))

    def _keep_looking(self, change: Change | None) -> None:
        if change is not None:
            self.select(change.select or self._first_open())

    # spans that were missed

    def begin_span(self) -> None:
        """Let a missed span begin at the playhead."""
        if self.marker:
            self.begun = self.frame

    def end_span(self) -> None:
        """Let the missed span end with the frame under the playhead, and add it."""
        if self.begun is None:
            self.fail("Press I where the span begins, then O where it ends.")
            return
        first, last = sorted((self.begun, self.frame))
        self.add_span(first, last + 1)

    def add_span(self, start: int, stop: int) -> None:
        """Add a finding on the marker at hand; its kind is a guess that one key changes."""
        if self.opened is None or not self.marker:
            return
        take = self.opened.take
        span = Span(max(0, start), max(1, min(stop, take.n_frames)))
        seen = take.seen[span.frames, take.index(self.marker)]
        kind: Kind = "gap" if not seen.any() else "peak" if len(span) <= 3 else "noise"
        self.param.update(begun=None, adding=False)
        change = self.do(AddFinding((Finding(self.marker, span, kind, axes=("x", "y", "z")),)))
        if change is not None and change.select:
            self.select(change.select)

    def remove_added(self) -> None:
        """Take back a span that was added by hand."""
        current = self.current
        if current is not None:
            self._go_on(current, self.do, RemoveAdded((current,)))

    # several at once

    def show_similar(self) -> None:
        """Open the list of open findings like the one at hand, and measure what to expect."""
        opened, current = self.opened, self.current
        if opened is None or current is None:
            return
        found = self.alike(current)
        if len(found) < 2:
            self.fail("No other open finding is similar: same kind, half to twice the size.")
            return
        self.param.update(similar=found, expected={}, dialog="similar", playing=False)
        method = self.chosen
        if method in ("", "leave"):
            return
        wishes = [self.judged(f).wish for f in found]
        masked = tuple({*self.accepted, *((w.marker, w.span) for w in wishes)})

        def work(ticket: Ticket) -> None:
            for finding, wish in zip(found, wishes, strict=True):
                if not ticket.valid():
                    return
                worker = self.workspace.worker
                error = worker.call(
                    computing.expected, worker.lend(opened.take), wish, masked, method
                )
                ticket.tell(lambda f=finding, e=error: self._expects(f.id, e))  # type: ignore[misc]

        self.jobs.run("similar", work, lambda _: None)

    def _expects(self, key: str, error: float) -> None:
        self.expected = self.expected | {key: error}

    def alike(self, finding: Finding) -> tuple[Finding, ...]:
        """Give the open findings of the same kind and about the same size, this one first."""
        mine = self.judged(finding)
        size = self._size(finding)
        rest = [
            f
            for f in self.queue
            if f.id != finding.id
            and self.judged(f).kind == mine.kind
            and self.judged(f).decision.verdict is None
            and 1 / LIKE <= (self._size(f) + 1e-9) / (size + 1e-9) <= LIKE
        ]
        return (finding, *rest)

    def _size(self, finding: Finding) -> float:
        judged = self.judged(finding)
        if judged.kind == "gap" or finding.amplitude is None:
            return float(len(judged.span))
        return abs(finding.amplitude)

    def decide_similar(self, verdict: str) -> None:
        """Decide all that are listed at once, as one step to undo."""
        current, found = self.current, tuple(f for f in self.similar if self.find(f.id))
        self.jobs.cancel("similar")
        self.param.update(dialog="", similar=())
        if current is None or not found:
            return
        commands: dict[str, Callable[[], Command]] = {
            "accept": lambda: Accept(found, self.chosen),
            "reject": lambda: Reject(found),
            "defer": lambda: Defer(found),
        }
        if verdict in commands:
            self._go_on(current, self.do, commands[verdict]())

    # history

    def undo(self) -> None:
        """Take the last decision back and show what it was about."""
        if self.session is not None:
            self._travel(self.session.undo)

    def redo(self) -> None:
        """Make the decision again that was taken back last."""
        if self.session is not None:
            self._travel(self.session.redo)

    def go_to(self, position: int) -> None:
        """Walk to a place in the history."""
        session = self.session
        if session is not None and 0 <= position <= len(session.history.steps):
            self._travel(lambda: session.go_to(position))

    def _travel(self, move: Callable[[], Change | None]) -> None:
        with param.parameterized.batch_call_watchers(self):
            change = self._commit(move)
            if change is not None:
                self.select(change.select or self.selected or self._first_open())
