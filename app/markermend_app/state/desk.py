"""The desk of one page: which take, which finding, which repair, and what was decided.

Views show these values and call these methods; nothing else changes them. The desk is made in
layers, each of which knows only those before it: what is held (`held`), where the operator looks
(`looking`), what is offered (`offering`), what is listed (`queueing`), what is decided
(`deciding`), and here how takes come in and go out.
"""

from dataclasses import dataclass
from pathlib import Path

import param

from markermend.detection import Reach
from markermend.errors import BadInput, Lacking, MarkerMendError
from markermend.review.session import ReviewSession
from markermend.review.triage import Triage
from markermend_app.state import exporting
from markermend_app.state.deciding import Deciding
from markermend_app.state.held import AS_DESIGNED
from markermend_app.state.jobs import Ticket
from markermend_app.state.looking import SIGNALS, VIEWS, ZOOMS
from markermend_app.state.places import Takes
from markermend_app.state.workspace import Opened

__all__ = ["SIGNALS", "VIEWS", "ZOOMS", "Asked", "Desk"]


@dataclass(frozen=True)
class Asked:
    """What a file does not say and the operator has to."""

    path: Path
    what: str
    sentence: str
    units: str | None = None
    rate: float | None = None


class Cancelled(Exception):
    """The operator gave the work up."""


class Desk(Deciding):
    """View-model of the page."""

    plan: exporting.Plan | None = param.Parameter(doc="What an export would change.")
    asked: Asked | None = param.Parameter(doc="What has to be said before the file opens.")
    takes: Takes | None = param.Parameter(doc="What can be opened, for the dialog.")
    slow_reach: tuple[Reach, ...] | None = param.Parameter(
        doc="How small a slow change may be and still be found, once it was asked for."
    )

    # opening

    def open(self, path: Path, units: str | None = None, rate: float | None = None) -> None:
        """Open a take in the background."""
        try:
            path = self.workspace.find(path)
        except BadInput as refusal:
            self.fail(str(refusal))
            return
        self.param.update(busy=f"Opening {path.name}", message="", dialog="", asked=None)

        def work(ticket: Ticket) -> tuple[Opened, Triage] | Asked | str:
            def report(step: str) -> None:
                ticket.tell(lambda: self.param.update(busy=f"{step}: {path.name}"))

            self.workspace.worker.warm_up()
            try:
                opened = self.workspace.open(path, units, rate, report)
                return opened, self.workspace.learnt(opened, self.person.name)
            except Lacking as lack:
                return Asked(path, lack.what, str(lack), units, rate)
            except MarkerMendError as refusal:
                return f"{path.name}: {refusal}"

        self.jobs.run("open", work, self._opened)

    def cancel(self) -> None:
        """Give up what is being done; the desk stays as it was."""
        for topic in ("open", "export", "report", "search", "slow_reach"):
            self.jobs.cancel(topic)
        if self.searching:
            self.message = "Only gaps are listed; open the take again to look for the rest."
        self.param.update(busy="", searching="")

    def _opened(self, result: tuple[Opened, Triage] | Asked | str) -> None:
        if isinstance(result, str):
            self.fail(result)
            return
        if isinstance(result, Asked):
            self.param.update(busy="", asked=result, dialog="ask")
            return
        opened, triage = result
        for topic in ("search", "slow_reach"):
            self.jobs.cancel(topic)
        self._forget()
        self.session, told = self._begin(opened)
        with param.parameterized.batch_call_watchers(self):
            self.select(None)
            self.param.update(
                busy="",
                opened=opened,
                found=opened.findings,
                searching="",
                triage=triage,
                frame=0,
                playing=False,
                text="",
                verdict="",
                by="",
                begun=None,
                adding=False,
                thresholds=AS_DESIGNED,
                slow_reach=None,
                message=" ".join((*told, *opened.take.warnings)),
            )
            self._show()
            self.select(self._first_open())
            if not self.selected and len(opened.take.measured):
                self.marker = opened.take.labels[int(opened.take.measured[0])]
                self._fit_window()
        if not opened.complete:
            self._search(opened)

    def _search(self, opened: Opened) -> None:
        """Look for everything else than gaps while the operator begins with those."""
        self.searching = "Looking for artefacts"
        self.jobs.run(
            "search", lambda ticket: self.workspace.search(opened, ticket.valid), self._searched
        )

    def show_slow_reach(self) -> None:
        """Show how small a slow change may be and still be found here, marker by marker."""
        opened = self.opened
        if opened is None:
            return
        if self.slow_reach is not None:
            self.show("slow_reach")
            return
        self.param.update(busy="Measuring how small a slow change would be found", message="")

        def measured(found: tuple[Reach, ...] | None) -> None:
            self.param.update(busy="", slow_reach=found)
            if self.dialog:  # what is being written there stays
                self.message = "How small a slow change would be found is measured; ask again."
            else:
                self.show("slow_reach")

        self.jobs.run(
            "slow_reach",
            lambda ticket: self.workspace.slow_reach(opened.take, ticket.valid),
            measured,
        )

    def _searched(self, opened: Opened) -> None:
        """Take in what was found; what the operator looks at stays at hand."""
        known = {finding.id for finding in self.findings}
        with param.parameterized.batch_call_watchers(self):
            self.param.update(found=opened.findings, searching="")
            self._show()
            self._arrived = {f.id for f in self.findings} - known
            if not self.selected:
                self.select(self._first_open())

    def _begin(self, opened: Opened) -> tuple[ReviewSession, tuple[str, ...]]:
        """Give the review that is worked on, and what the operator should know of it."""
        return self.workspace.begin(opened, self.person.name)

    def show_takes(self) -> None:
        """Open the list of takes: those given, those in the folder, those opened before."""
        here = self.opened.take.source if self.opened else None
        known = self.workspace.takes(here.path if here else None, self.person.name)
        self.param.update(takes=known, dialog="open")

    def receive(self, name: str, data: bytes) -> None:
        """Take in a file that was dropped on the page: it is kept beside the store, and opened."""
        try:
            self.open(self.workspace.keep(name, data))
        except MarkerMendError as refusal:
            self.fail(str(refusal))

    # leaving

    def plan_export(self) -> None:
        """Work out what an export would change, and ask."""
        if self.opened is None:
            return
        opened, review, findings = self.opened, self.review, self.findings
        known = {key: done.expected_mm for key, done in self.mended.items()}
        n_wishes = len(review.accepted())
        self.param.update(busy="Working out what will change", playing=False)

        def show(plan: exporting.Plan | None) -> None:
            self.param.update(busy="", plan=plan, dialog="export")

        def work(ticket: Ticket) -> exporting.Plan | None:
            def computed(n: int) -> None:
                if not ticket.valid():
                    raise Cancelled
                doing = f"Working out what will change: {n} of {n_wishes}"
                ticket.tell(lambda: self.param.update(busy=doing))

            try:
                return exporting.plan(opened, review, findings, known, computed)
            except Cancelled:
                return None

        self.jobs.run("export", work, show)

    def export(self, target: Path, *, overwrite: bool = False, report: bool = False) -> None:
        """Write the repaired take, its decision file and a report, and verify both."""
        if self.opened is None or self.plan is None or self.session is None:
            return
        try:
            target = self.workspace.find(target)
        except BadInput as refusal:
            self.fail(str(refusal))
            return
        opened, planned, session = self.opened, self.plan, self.session
        self.param.update(busy=f"Writing {target.name}")

        def show(done: exporting.Plan) -> None:
            self.param.update(busy="", plan=done, dialog="exported")

        self.jobs.run(
            "export",
            lambda _: exporting.write(
                opened, planned, session, target, overwrite=overwrite, report=report
            ),
            show,
        )

    def report(self) -> None:
        """Write a report of the take beside it, as it is decided now."""
        if self.opened is None or self.session is None:
            return
        opened, session, review, findings = self.opened, self.session, self.review, self.findings
        known = {key: done.expected_mm for key, done in self.mended.items()}
        self.param.update(busy="Writing the report", playing=False)

        def work(_: Ticket) -> Path:
            plan = exporting.plan(opened, review, findings, known)
            page = plan.target.with_suffix(".report.html")
            exporting.write_report(page, opened, plan, session, overwrite=True)
            return page

        def show(page: Path) -> None:
            self.param.update(busy="", message=f"The report is in {page}.")

        self.jobs.run("report", work, show)

    def close_dialog(self) -> None:
        """Close what is open, or dismiss the message."""
        if self.dialog:
            self.jobs.cancel("similar")
            self.param.update(dialog="", similar=())
        elif self.message:
            self.message = ""
        else:
            self.param.update(begun=None, adding=False)

    def show(self, dialog: str) -> None:
        """Open one of the dialogs."""
        self.param.update(dialog=dialog, playing=False)
