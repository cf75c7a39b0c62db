"""Second reviews, blinded; how far operators agree; and what is made of where they do not."""

from dataclasses import replace
from typing import Any

import param

from markermend.comparing import adjudication, taken_over
from markermend.errors import MarkerMendError
from markermend.review import Adopt, Review
from markermend.review.decisions import Decisions
from markermend.review.session import ReviewSession
from markermend.review.triage import Triage
from markermend_app.state.compared import (
    PURPOSE,
    Compared,
    Material,
    Opinion,
    Opinions,
    in_store,
    others,
)
from markermend_app.state.desk import Asked
from markermend_app.state.exercise import Practising
from markermend_app.state.jobs import Ticket
from markermend_app.state.workspace import Opened


class Comparing(Practising):
    """The desk on which several people's reviews of one take come together."""

    second: tuple[str, ...] = param.Parameter(
        (), doc="Names of those whose review is hidden while a second one is made."
    )
    compared: Compared | None = param.Parameter(doc="The agreement that is shown.")
    adjudicating: tuple[str, ...] = param.Parameter((), doc="Whose reviews are adjudicated.")
    opinions: tuple[Opinion, ...] = param.Parameter((), doc="Those on the finding at hand.")

    def __init__(self, *given: Any, **values: Any) -> None:
        super().__init__(*given, **values)
        self._sides: Opinions | None = None
        self._blind = False
        self.param.watch(lambda *_: self._hear(), ["selected", "review", "adjudicating"])

    def _opened(self, result: tuple[Opened, Triage] | Asked | str) -> None:
        if isinstance(result, tuple) and self._how is None:
            self._sides = None
            self.param.update(second=(), compared=None, adjudicating=(), opinions=())
        super()._opened(result)
        if isinstance(result, tuple) and self._how is None and self._blind:
            self._blind = False
            self._hide_first()

    # a second review

    def ask_second(self) -> None:
        """Ask who reviews this take once more, without seeing the first review."""
        if self.opened is not None and not self._stays():
            self.show("second")

    def review_blind(self, operator: str) -> None:
        """Begin the second review of the take at hand, or go on with it."""
        opened = self.opened
        if opened is None or self._stays():
            return
        name = operator.strip()[:80]
        if not name or name == self.person.name:
            self.fail(f"A second review needs somebody else; {self.person.name} is at it already.")
            return
        if self.rename(name):
            self._enter(opened, lambda o: self.workspace.begin(o, name), self.triage)
            self._sides = None
            self.param.update(dialog="", compared=None, adjudicating=(), opinions=())
            self._hide_first()

    def open_blind(self) -> None:
        """Open the first take for a second review."""
        self._blind = True
        self.open(self.workspace.paths[0])

    def _hide_first(self) -> None:
        assert self.opened is not None
        if self.session is not None and self.session.record.status == "finished":
            return  # the page was loaded again: there is nothing to hide any more
        first = others(self.workspace.store, self.opened.take, self.person.name)
        self.second = tuple(record.operator for record in first)
        if not first:
            self.message = "Nobody else has reviewed this take yet; nothing is hidden from you."

    def finish_second(self) -> None:
        """Finish the second review: from now on both may be seen."""
        if self.second and self.session is not None:
            self.session.set_status("finished")
            self.second = ()
            self.compare()

    # agreement

    def compare(self, expert: str | None = None) -> None:
        """Show how far all reviews of the take at hand agree."""
        if self._stays():
            return
        if self.second:
            self.fail("A blinded review shows the others when it is finished (Ctrl+Enter).")
            return
        known = self.compared
        if known is not None and expert is not None:
            self.show_agreement(known.material, expert)
        elif self.opened is not None:
            try:
                self.show_agreement(in_store(self.workspace.store, self.opened.take))
            except MarkerMendError as refusal:
                self.fail(str(refusal))

    def show_agreement(self, material: Material, expert: str | None = None) -> None:
        """Compare reviews in the background and show the tables."""
        if expert is not None and expert not in material.reviews:
            return
        self.param.update(busy="Comparing reviews", playing=False)

        def work(ticket: Ticket) -> Compared:
            def moved(done: int, total: int) -> None:
                ticket.tell(lambda: self.param.update(busy=f"Repairing: {done} of {total} reviews"))

            return material.compare(expert, moved)

        def show(found: Compared) -> None:
            self.param.update(busy="", compared=found, dialog="agreement")

        self.jobs.run("agree", work, show)

    # adjudication

    def adjudicate(self) -> None:
        """Make a new review of those compared: what they agree on stands, the rest is open."""
        known = self.compared
        if known is None:
            return
        if not self.person.may("adjudicate"):
            self.fail("Only reviewers and teachers of the lab adjudicate; ask one of them.")
            return
        self.param.update(busy="Putting reviews side by side", dialog="")
        material, opened = known.material, self.opened

        def work(ticket: Ticket) -> tuple[Opinions, Opened]:
            sides = material.opinions()
            if opened is not None and opened.take.content_hash == sides.take.content_hash:
                return sides, self.workspace.search(opened)
            source = sides.take.source
            assert source is not None, "reviews of files are of takes from files"
            return sides, self.workspace.search(self.workspace.open(source.path))

        self.jobs.run("agree", work, lambda found: self._adjudicate(material, *found))

    def _adjudicate(self, material: Material, sides: Opinions, opened: Opened) -> None:
        judged = {finding.id: finding for finding in opened.findings if finding.id in sides.cases}
        shown = replace(opened, findings=tuple(judged.values()))

        def begin(_: Opened) -> tuple[ReviewSession, tuple[str, ...]]:
            store, take = self.workspace.store, opened.take
            session = ReviewSession.open(store, take, self.person.name, PURPOSE)
            if not session.history.steps:
                plain = [_plain(review) for review in material.reviews.values()]
                session.do(taken_over(adjudication(plain, sides.names, iou=material.iou)))
            return session, ()

        self._sides = sides
        try:
            self._enter(shown, begin)
        except MarkerMendError as refusal:
            self._sides = None
            self.fail(str(refusal))
            return
        self.adjudicating = sides.names

    def _hear(self) -> None:
        sides = self._sides
        self.opinions = () if sides is None else sides.of(self.selected, self.review)

    def follow(self, person: int) -> None:
        """Decide as one of them did, and go on."""
        sides, current = self._sides, self.current
        case = None if sides is None or current is None else sides.cases.get(current.id)
        if sides is None or current is None or case is None or person >= len(sides.names):
            return
        decision = case.decision(person)
        if decision.verdict is None:
            self.fail(f"{sides.names[person]} left it open; decide yourself, or follow another.")
            return
        said = replace(decision, note=f"as {sides.names[person]}")
        self._go_on(current, self.do, Adopt((current,), (said,), (False,)))


def _plain(given: Review | Decisions) -> Review:
    return given.review if isinstance(given, Decisions) else given
