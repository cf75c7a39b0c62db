"""The desk of one page: which take, which finding, which repair, and what was decided.

Views show these values and call these methods; nothing else changes them.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

import param

from markermend.errors import Conflict, Lacking, MarkerMendError
from markermend.model import KINDS, Finding, Kind, Span
from markermend.repairing import Repair
from markermend.review import Accept, Choose, Command, Defer, Judgement, Reclassify, Reject, Review
from markermend.review.queue import damage, worst_first
from markermend.review.session import Change, ReviewSession
from markermend_app.state import exporting
from markermend_app.state.jobs import Jobs, Schedule, Ticket
from markermend_app.state.previews import Preview, compute, recommended
from markermend_app.state.values import OverviewValues, SpanMark
from markermend_app.state.workspace import Opened, Workspace

ZOOMS = ("span", "5 s", "take")
REFRESH_S = 0.4
"""How often the table of repairs is drawn anew while it fills."""
VIEWS = ("oblique", "front", "side", "top")


@dataclass(frozen=True)
class Asked:
    """What a file does not say and the operator has to."""

    path: Path
    what: str
    sentence: str
    units: str | None = None
    rate: float | None = None


class Desk(param.Parameterized):  # type: ignore[misc]  # param has no types
    """View-model of the page."""

    opened: Opened | None = param.Parameter(doc="The take at hand with its findings and body.")
    review: Review = param.Parameter(Review(), doc="All decisions; replaced whole.")
    findings: tuple[Finding, ...] = param.Parameter((), doc="What there is to look at now.")
    selected: str = param.String("", doc="Id of the finding at hand.")
    kinds: frozenset[Kind] = param.Parameter(frozenset(KINDS), doc="Kinds that the queue lists.")
    previews: tuple[Preview, ...] = param.Parameter((), doc="Repairs of the selected.")
    chosen: str = param.String("", doc="Name of the repair chosen for the selected finding.")
    repair: Repair | None = param.Parameter(doc="The chosen repair, once it is computed.")
    best: str = param.String("", doc="Name of the repair that is recommended here.")
    frame: int = param.Integer(0, bounds=(0, None))
    window: tuple[float, float] = param.Parameter((0.0, 1.0), doc="Seconds that the lanes show.")
    zoom: str = param.Selector(default="span", objects=list(ZOOMS))
    playing: bool = param.Boolean(False)
    looping: bool = param.Boolean(True)
    speed: float = param.Number(1.0, bounds=(0.1, 4.0))
    view: str = param.Selector(default="oblique", objects=[*VIEWS, "free"])
    following: bool = param.Boolean(True)
    raw_only: bool = param.Boolean(False)
    theme: str = param.Selector(default="light", objects=["light", "dark"])
    dialog: str = param.String("", doc="Name of the dialog that is open, or empty.")
    plan: exporting.Plan | None = param.Parameter(doc="What an export would change.")
    asked: Asked | None = param.Parameter(doc="What has to be said before the file opens.")
    message: str = param.String("", doc="A failure or warning, until dismissed.")
    busy: str = param.String("", doc="What is being done, or empty.")
    saved: str = param.String("", doc="When the last decision reached the disk, local time.")

    def __init__(self, workspace: Workspace, schedule: Schedule, **values: Any) -> None:
        super().__init__(**values)
        self.workspace = workspace
        self.jobs = Jobs(schedule, self.fail)
        self.session: ReviewSession | None = None
        self._accepting = ""  # the finding to be accepted once its repair is there

    # opening

    def open(self, path: Path, units: str | None = None, rate: float | None = None) -> None:
        """Open a take in the background."""
        self.param.update(busy=f"Opening {path.name}", message="", dialog="", asked=None)

        def work(ticket: Ticket) -> Opened | Asked | str:
            def report(step: str) -> None:
                ticket.tell(lambda: self.param.update(busy=f"{step}: {path.name}"))

            try:
                return self.workspace.open(path, units, rate, report)
            except Lacking as lack:
                return Asked(path, lack.what, str(lack), units, rate)
            except MarkerMendError as refusal:
                return f"{path.name}: {refusal}"

        self.jobs.run("open", work, self._opened)

    def _opened(self, result: Opened | Asked | str) -> None:
        if isinstance(result, str):
            self.fail(result)
            return
        if isinstance(result, Asked):
            self.param.update(busy="", asked=result, dialog="ask")
            return
        self.session, told = self.workspace.begin(result)
        self.param.update(
            busy="",
            opened=result,
            frame=0,
            playing=False,
            chosen="",
            previews=(),
            selected="",
            message=" ".join((*told, *result.take.warnings)),
        )
        self._show()
        self.select(self._first_open())

    # the queue

    @property
    def queue(self) -> tuple[Finding, ...]:
        """Open findings of the kinds listed, worst first; those set aside come last."""
        if self.opened is None:
            return ()
        take = self.opened.take
        order = worst_first(self.review, self.findings, take.rate, n_frames=take.n_frames)
        listed = [
            f
            for f in order
            if self.judged(f).kind in self.kinds and not self.review.decision(f).settled
        ]
        return tuple(sorted(listed, key=lambda f: self.review.decision(f).verdict == "deferred"))

    @property
    def settled(self) -> tuple[Finding, ...]:
        """Findings that were accepted or rejected, in the order of decision."""
        order = {key: i for i, key in enumerate(self.review.judgements)}
        done = [f for f in self.findings if self.review.decision(f).settled]
        return tuple(sorted(done, key=lambda f: order[f.id]))

    def judged(self, finding: Finding) -> Judgement:
        """Give a finding with its decision."""
        return self.review.judgement(finding)

    def damage(self, finding: Finding) -> float:
        """Expected damage in mm s, the order of the queue."""
        assert self.opened is not None
        return damage(self.judged(finding).as_judged, self.opened.take.rate)

    @property
    def current(self) -> Finding | None:
        """The finding at hand, as it was found."""
        return next((f for f in self.findings if f.id == self.selected), None)

    @property
    def span(self) -> Span | None:
        """The span of the finding at hand, as judged."""
        return None if self.current is None else self.judged(self.current).span

    def select(self, finding: Finding | str | None) -> None:
        """Put a finding at hand: centred, zoomed, its repairs computed."""
        wanted = finding.id if isinstance(finding, Finding) else finding or ""
        found = next((f for f in self.findings if f.id == wanted), None)
        if found is None or self.opened is None:
            self.param.update(selected="", previews=(), chosen="", best="", repair=None)
            return
        span = self.judged(found).span
        self._accepting = ""
        self.param.update(
            selected=found.id,
            zoom="span",
            frame=span.start + len(span) // 2,
            previews=(),
            best="",
            repair=None,
            chosen=self.judged(found).decision.method,
        )
        self._fit_window()
        self._preview()

    def select_marker(self, marker: int) -> None:
        """Put the finding of a marker at hand that is nearest to the playhead."""
        if self.opened is None or not 0 <= marker < self.opened.take.n_markers:
            return
        label = self.opened.take.labels[marker]
        own = [f for f in self.findings if f.marker == label]
        if own:
            self.select(min(own, key=lambda f: abs(f.span.start - self.frame)))

    def next(self) -> None:
        """Go to the next open finding."""
        self._step(1)

    def previous(self) -> None:
        """Go to the previous open finding."""
        self._step(-1)

    def _step(self, by: int) -> None:
        queue = self.queue
        if not queue:
            return
        ids = [f.id for f in queue]
        at = ids.index(self.selected) + by if self.selected in ids else 0
        self.select(queue[at % len(queue)])

    def _first_open(self) -> Finding | None:
        queue = self.queue
        return queue[0] if queue else None

    def toggle_kind(self, kind: Kind) -> None:
        """List only this kind, or all again."""
        only = frozenset({kind})
        self.kinds = frozenset(KINDS) if self.kinds == only else only

    # decisions

    def accept(self) -> None:
        """Accept the chosen repair and go on, as soon as it is computed."""
        repair = self.repair
        if repair is None:
            self._accepting = self.selected
            return
        self._decide(lambda f: Accept((f,), repair.method, repair.parameters))

    def leave(self) -> None:
        """Leave the span as a gap and go on."""
        self._decide(lambda f: Accept((f,), "leave"))

    def reject(self) -> None:
        """Say that it is a false alarm and go on."""
        self._decide(lambda f: Reject((f,)))

    def defer(self) -> None:
        """Set it aside and go on."""
        self._decide(lambda f: Defer((f,)))

    def reclassify(self, kind: Kind) -> None:
        """Say that it is of another kind and stay."""
        if self.current is not None:
            self._do(Reclassify((self.current,), kind))
            self.select(self.selected)

    def choose(self, method: str) -> None:
        """Choose a repair for the finding at hand; the choice is kept."""
        if self.current is None or not any(p.name == method and p.repair for p in self.previews):
            return
        self.chosen = method
        self._pick_repair()
        self._do(Choose((self.current,), method))

    def choose_by(self, step: int) -> None:
        """Choose the next or previous repair that is ready."""
        ready = [p.name for p in self.previews if p.repair is not None]
        if ready:
            at = ready.index(self.chosen) + step if self.chosen in ready else 0
            self.choose(ready[at % len(ready)])

    def choose_recommended(self) -> None:
        """Choose the repair that is recommended here."""
        if self.best:
            self.choose(self.best)

    def _decide(self, command: Callable[[Finding], Command]) -> None:
        current = self.current
        if current is None:
            return
        queue = [f.id for f in self.queue]
        at = queue.index(current.id) if current.id in queue else 0
        self._accepting = ""
        self._do(command(current))
        left = self.queue
        after = [f for f in left if f.id not in (current.id, *queue[:at])]
        self.select(after[0] if after else (left[0] if left else current))

    def _do(self, command: Command) -> None:
        session = self.session
        if session is not None:
            self._commit(lambda: session.do(command))

    def undo(self) -> None:
        """Take the last decision back and show what it was about."""
        if self.session is not None:
            self._travel(self.session.undo)

    def redo(self) -> None:
        """Make the decision again that was taken back last."""
        if self.session is not None:
            self._travel(self.session.redo)

    @property
    def steps(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """What can be undone, the latest last, and what can be redone, the next first."""
        if self.session is None:
            return (), ()
        history = self.session.history
        said = tuple(step.command.describe() for step in history.steps)
        return said[: history.position], said[history.position :]

    def _travel(self, move: Callable[[], Change | None]) -> None:
        change = self._commit(move)
        if change is not None:
            self.select(change.select or self.selected or self._first_open())

    def _commit(self, move: Callable[[], Change | None]) -> Change | None:
        """Let the review change; what is shown afterwards is on disk."""
        assert self.session is not None
        try:
            change = move()
            if change is not None:
                self.saved = f"{datetime.now().astimezone():%H:%M:%S}"
        except Conflict as conflict:
            change = None
            self.session.refresh()
            self.fail(f"{conflict} It is up to date now; decide again.")
        except MarkerMendError as refusal:
            change = None
            self.fail(str(refusal))
        self._show()
        return change

    def _show(self) -> None:
        assert self.opened is not None
        assert self.session is not None
        detected = tuple(f for f in self.opened.findings if f.strength >= 1.0)
        review = self.session.review
        self.param.update(review=review, findings=review.live(detected))

    # what is seen

    def seek(self, frame: float) -> None:
        """Put the playhead on a frame."""
        if self.opened is not None:
            self.frame = min(max(0, round(frame)), self.opened.take.n_frames - 1)

    def step_frame(self, by: int) -> None:
        """Stop playing and move the playhead by some frames."""
        self.playing = False
        self.seek(self.frame + by)

    def seek_s(self, time_s: float) -> None:
        """Put the playhead at a time."""
        if self.opened is not None:
            self.seek(time_s * self.opened.take.rate)

    def zoom_next(self) -> None:
        """Show the span, five seconds, or the whole take."""
        self.zoom = ZOOMS[(ZOOMS.index(self.zoom) + 1) % len(ZOOMS)]
        self._fit_window()

    def _fit_window(self) -> None:
        if self.opened is None:
            return
        take, span = self.opened.take, self.span
        if self.zoom == "take" or span is None:
            self.window = (0.0, take.duration_s)
            return
        middle = (span.start + span.stop) / 2 / take.rate
        length = len(span) / take.rate
        half = max(2.5, length * 0.6) if self.zoom == "5 s" else max(0.35, length * 1.2)
        self.window = (max(0.0, middle - half), min(take.duration_s, middle + half))

    def jump(self, time_s: float, row: float, shown: OverviewValues | None) -> None:
        """Select the finding of the overview nearest to a place, or go there if there is none."""
        if self.opened is None or shown is None:
            return
        near = 0.02 * shown.duration_s

        def distance(entry: tuple[str, SpanMark]) -> float:
            label, mark = entry
            away_s = max(mark.start_s - time_s, time_s - mark.stop_s, 0.0)
            return away_s / near + abs(shown.rows[label] + 0.5 - row) / 2

        nearest = min(shown.marks, key=distance, default=None)
        if nearest is not None and distance(nearest) <= 1.0:
            self.select(nearest[1].id)
            return
        low, high = self.window
        half = (high - low) / 2
        middle = min(max(time_s, half), max(half, shown.duration_s - half))
        self.window = (middle - half, middle + half)
        self.seek_s(time_s)

    @property
    def loop(self) -> Span | None:
        """The frames that playback repeats: the span and a second on both sides."""
        if self.opened is None or self.span is None or not self.looping:
            return None
        take = self.opened.take
        return self.span.padded(round(take.rate), take.n_frames)

    # repairs

    def _preview(self) -> None:
        opened, current = self.opened, self.current
        if opened is None or current is None:
            return
        finding, masked = self.judged(current), self._masked(current.id)

        def work(ticket: Ticket) -> None:
            shown = 0.0
            for rows in compute(opened.take, finding, masked):
                if not ticket.valid:
                    return
                last = not any(p.pending for p in rows)
                first = recommended(rows, finding.kind) and not shown
                if first or last or (shown and time.monotonic() - shown > REFRESH_S):
                    shown = time.monotonic()
                    ticket.tell(lambda rows=rows: self._previewed(rows))  # type: ignore[misc]

        self.jobs.run("previews", work, lambda _: None)

    def _previewed(self, rows: tuple[Preview, ...]) -> None:
        if self.current is None:
            return
        judged = self.judged(self.current)
        ready = {p.name for p in rows if p.repair is not None}
        best = recommended(rows, judged.kind)
        mine = judged.decision.method
        self.param.update(
            previews=rows, best=best, chosen=mine if mine in ready else best or self.chosen
        )
        self._pick_repair()
        if self._accepting == self.selected and self.repair is not None:
            self.accept()

    def _masked(self, but: str) -> tuple[tuple[str, Span], ...]:
        return tuple(
            (judgement.finding.marker, judgement.span)
            for key, judgement in self.review.judgements.items()
            if key != but and judgement.decision.verdict == "accepted" and not judgement.replaced_by
        )

    def _pick_repair(self) -> None:
        """Say which repair is shown, only where that changes."""
        chosen = next((p.repair for p in self.previews if p.name == self.chosen), None)
        if chosen is not self.repair:
            self.repair = chosen

    # leaving

    def plan_export(self) -> None:
        """Work out what an export would change, and ask."""
        if self.opened is None:
            return
        opened, review = self.opened, self.review
        self.param.update(busy="Working out what will change", playing=False)

        def show(plan: exporting.Plan) -> None:
            self.param.update(busy="", plan=plan, dialog="export")

        self.jobs.run("export", lambda _: exporting.plan(opened, review, self.findings), show)

    def export(self, target: Path, *, overwrite: bool = False) -> None:
        """Write the repaired take and its decision file, and verify both."""
        if self.opened is None or self.plan is None or self.session is None:
            return
        opened, planned, session = self.opened, self.plan, self.session
        self.param.update(busy=f"Writing {target.name}")

        def show(done: exporting.Plan) -> None:
            self.param.update(busy="", plan=done, dialog="exported")

        self.jobs.run(
            "export",
            lambda _: exporting.write(opened, planned, session, target, overwrite=overwrite),
            show,
        )

    def close_dialog(self) -> None:
        """Close what is open, or dismiss the message."""
        if self.dialog:
            self.dialog = ""
        else:
            self.message = ""

    def show_help(self) -> None:
        """Open the list of keys."""
        self.dialog = "help"

    def dismiss(self) -> None:
        """Take the message away."""
        self.message = ""

    def fail(self, sentence: str) -> None:
        """Say in a line under the header what went wrong."""
        self.param.update(busy="", message=sentence)

    def close(self) -> None:
        """Stop work under way; nothing is lost, every decision is on disk."""
        self.jobs.close()
