"""What one page holds: the take, the decisions on it, and which finding is at hand."""

from collections.abc import Callable, Mapping
from datetime import datetime
from typing import Any

import param

from markermend.errors import Conflict, MarkerMendError
from markermend.model import KINDS, Finding, Kind, Span
from markermend.review import Command, Judgement, Review
from markermend.review.session import Change, ReviewSession
from markermend_app.state.jobs import Jobs, Schedule
from markermend_app.state.people import Person, alone
from markermend_app.state.workspace import Opened, Workspace

AS_DESIGNED: dict[Kind, float] = dict.fromkeys(KINDS, 1.0)


class Held(param.Parameterized):  # type: ignore[misc]  # param has no types
    """The first layer of the desk: everything that is kept, and how it changes."""

    opened: Opened | None = param.Parameter(doc="The take at hand with its findings and body.")
    review: Review = param.Parameter(Review(), doc="All decisions; replaced whole.")
    found: tuple[Finding, ...] = param.Parameter((), doc="All that was found, whatever strength.")
    searching: str = param.String("", doc="What is still being looked for, or empty.")
    findings: tuple[Finding, ...] = param.Parameter((), doc="What there is to look at now.")
    selected: str = param.String("", doc="Id of the finding at hand.")
    marker: str = param.String("", doc="Label of the marker that the lanes show.")
    thresholds: dict[Kind, float] = param.Parameter(
        AS_DESIGNED, doc="Factor on the detector's thresholds, by kind; replaced whole."
    )
    empty: str = param.String("", doc="What the queue says while it lists nothing on purpose.")
    dialog: str = param.String("", doc="Name of the dialog that is open, or empty.")
    message: str = param.String("", doc="A failure or warning, until dismissed.")
    busy: str = param.String("", doc="What is being done, or empty.")
    saved: str = param.String("", doc="When the last decision reached the disk, local time.")

    def __init__(
        self,
        workspace: Workspace,
        schedule: Schedule,
        person: Person | None = None,
        **values: Any,
    ) -> None:
        super().__init__(**values)
        self.workspace = workspace
        self.person = alone() if person is None else person
        self.jobs = Jobs(schedule, self.fail)
        self.session: ReviewSession | None = None
        self._of: tuple[Finding, ...] = ()
        self._by_id: dict[str, Finding] = {}
        self._undecided: dict[str, Judgement] = {}
        self._decided: Mapping[str, Judgement] = {}

    def judged(self, finding: Finding) -> Judgement:
        """Give a finding with its decision."""
        # Asked for each of some thousand findings after each decision: this must be fast.
        key = finding.id
        known = self._decided.get(key) or self._undecided.get(key)
        if known is None:
            known = self._undecided[key] = self.review.judgement(finding)
        return known

    @property
    def current(self) -> Finding | None:
        """The finding at hand, as it was found."""
        return self.find(self.selected)

    def find(self, key: str) -> Finding | None:
        """Give the finding of an id, if there is one to look at."""
        if self._of is not self.findings:
            self._of, self._by_id = self.findings, {f.id: f for f in self.findings}
        return self._by_id.get(key)

    @property
    def span(self) -> Span | None:
        """The span of the finding at hand, as judged."""
        return None if self.current is None else self.judged(self.current).span

    @property
    def accepted(self) -> tuple[tuple[str, Span], ...]:
        """Every marker and span that is to be repaired."""
        return tuple((wish.marker, wish.span) for wish in self.review.accepted())

    @property
    def steps(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """What can be undone, the latest last, and what can be redone, the next first."""
        if self.session is None:
            return (), ()
        history = self.session.history
        said = tuple(step.command.describe() for step in history.steps)
        return said[: history.position], said[history.position :]

    def set_threshold(self, kind: Kind, factor: float) -> None:
        """Ask more (above 1) or less (below 1) of findings of a kind."""
        self.thresholds = self.thresholds | {kind: factor}
        if self.opened is not None:
            self._show()

    def candidates(self, kind: Kind, factor: float | None = None) -> int:
        """Count what the detector finds of a kind at a threshold, by default the one set."""
        least = self.thresholds[kind] if factor is None else factor
        return sum(f.kind == kind and f.strength >= least for f in self.found)

    def do(self, command: Command) -> Change | None:
        """Let a command happen; what cannot be done is said in the message."""
        session = self.session
        return None if session is None else self._commit(lambda: session.do(command))

    def _commit(self, move: Callable[[], Change | None]) -> Change | None:
        """Let the review change; what is shown afterwards is on disk."""
        assert self.session is not None
        change = None
        try:
            change = move()
            if change is not None:
                self.saved = f"{datetime.now().astimezone():%H:%M:%S}"
        except Conflict as conflict:
            self.session.refresh()
            self.fail(f"{conflict} It is up to date now; decide again.")
        except MarkerMendError as refusal:
            self.fail(str(refusal))
        self._show()
        return change

    def _show(self) -> None:
        assert self.opened is not None
        assert self.session is not None
        detected = [f for f in self.found if f.strength >= self.thresholds[f.kind]]
        review = self.session.review
        findings = review.live(detected)
        same = findings == self.findings
        self._decided = review.judgements
        self.param.update(review=review, findings=self.findings if same else findings)

    def dismiss(self) -> None:
        """Take the message away."""
        self.message = ""

    def fail(self, sentence: str) -> None:
        """Say in a line under the header what went wrong."""
        self.param.update(busy="", message=sentence)

    def close(self) -> None:
        """Stop work under way; nothing is lost, every decision is on disk."""
        self.jobs.close()
