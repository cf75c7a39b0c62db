"""Practising on the desk: the same intentions, and an end at which the truth is told."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import param

from markermend.errors import MarkerMendError
from markermend.model import Finding
from markermend.review.session import Change, ReviewSession
from markermend.review.triage import NOTHING_LEARNT, Triage
from markermend.train import LEVELS, Mark, Request
from markermend_app.state.desk import Asked, Desk
from markermend_app.state.jobs import Ticket
from markermend_app.state.training import Feedback, OpenedExercise, Practice, Trainer
from markermend_app.state.workspace import Opened

Session = tuple[ReviewSession, tuple[str, ...]]
Begin = Callable[[Opened], Session]
FIND_IT = (
    "Nothing is shown: find what is wrong. Choose a marker in the overview or in 3D; press I where "
    "it begins and O where it ends, or drag over a lane after Add span."
)


class Practising(Desk):
    """The desk with exercises."""

    practice: Practice | None = param.Parameter(doc="The exercise at hand, without its truth.")
    feedback: Feedback | None = param.Parameter(doc="What the trainee got, once finished.")
    helping: bool = param.Boolean(False, doc="Whether each decision is answered at once.")
    hints: tuple[Mark, ...] = param.Parameter((), doc="The answers to the last decision.")

    def __init__(self, *given: Any, trainer: Trainer | None = None, **values: Any) -> None:
        super().__init__(*given, **values)
        self.trainer = Trainer(self.workspace.store) if trainer is None else trainer
        self._how: Begin | None = None

    # beginning

    @property
    def locked(self) -> bool:
        """Whether an exercise is under way, from which nothing leads to its truth."""
        return self.practice is not None and not self.practice.finished

    def practise(self, request: Request | None = None) -> None:
        """Begin an exercise, or go on with the one that this trainee is in."""
        trainee = self.person.name
        self.param.update(busy="Preparing an exercise", message="", dialog="", asked=None)

        def work(ticket: Ticket) -> tuple[OpenedExercise, Practice] | str:
            def tell(step: str) -> None:
                ticket.tell(lambda: self.param.update(busy=step))

            try:
                return self.trainer.begin(trainee, request, tell)
            except MarkerMendError as refusal:
                return str(refusal)

        self.jobs.run("open", work, self._prepared)

    def _prepared(self, result: tuple[OpenedExercise, Practice] | str) -> None:
        if isinstance(result, str):
            self.fail(result)
            return
        opened, practice = result
        trainee = practice.trainee
        self._forget()  # at once: what was repaired on another take is none of the next one's
        with param.parameterized.batch_call_watchers(self):
            self.param.update(
                practice=practice,
                feedback=None,
                hints=(),
                helping=practice.helped,
                empty=FIND_IT if practice.hidden else "",
            )
            self._enter(opened, lambda _: (self.trainer.session(trainee), ()))
        told = self.trainer.feedback(trainee)
        if told is not None:  # the page was loaded again after the end
            self.param.update(feedback=told, dialog="feedback")

    def _enter(self, opened: Opened, begin: Begin, triage: Triage = NOTHING_LEARNT) -> None:
        """Put a take on the desk that is ready, with a review of one's own choosing."""
        self._how = begin
        try:
            self._opened((opened, triage))
        finally:
            self._how = None

    def _begin(self, opened: Opened) -> Session:
        return super()._begin(opened) if self._how is None else self._how(opened)

    def _opened(self, result: tuple[Opened, Triage] | Asked | str) -> None:
        if isinstance(result, tuple) and self._how is None:
            self.param.update(practice=None, feedback=None, hints=(), empty="")
        super()._opened(result)

    def ask_practice(self) -> None:
        """Ask which exercise it shall be."""
        if self._stays():
            return
        self.show("practise")

    def choose_exercise(self, level: str, trainee: str, *, hidden: bool) -> None:
        """Begin the exercise that was asked for, of a simulated person.

        A take that is open here is none to practise on: the page knows it as it should be.
        """
        number = int(level) if level.isdigit() and 1 <= int(level) <= len(LEVELS) else None
        if not self._stays() and self.rename(trainee):
            self.practise(Request(level=number, hidden=hidden))

    def rename(self, name: str) -> bool:
        """Let somebody else go on at this page; not where people have signed in."""
        wanted = name.strip()[:80] or self.person.name
        if wanted == self.person.name:
            return True
        if self.workspace.reach is not None:
            self.fail(f"You are signed in as {self.person.name}; sign in as {wanted} first.")
            return False
        self.person = type(self.person)(wanted, self.person.role)
        return True

    # working

    def open(self, path: Path, units: str | None = None, rate: float | None = None) -> None:
        """Open a take, unless an exercise is under way: it may be the one that tells the truth."""
        if not self._stays():
            super().open(path, units, rate)

    def show_takes(self) -> None:
        """List what can be opened, unless an exercise is under way."""
        if not self._stays():
            super().show_takes()

    def plan_export(self) -> None:
        """Plan an export; an exercise is finished instead."""
        if self.practice is None:
            super().plan_export()
        elif not self.practice.finished:
            self.ask_finish()

    def report(self) -> None:
        """Write a report of the take; of an exercise there is the feedback."""
        if self.practice is None:
            super().report()
        else:
            self.show_feedback()

    def _stays(self) -> bool:
        if self.locked:
            self.fail("An exercise is under way: finish it, or leave it by the commands (P).")
        return self.locked

    def toggle_help(self) -> None:
        """Answer each decision from now on, or no longer."""
        if self.locked:
            self.param.update(helping=not self.helping, hints=())

    def _commit(self, move: Callable[[], Change | None]) -> Change | None:
        if self.practice is not None and self.practice.finished:
            self.fail("The exercise is finished; take the next one to practise on.")
            return None
        change = super()._commit(move)
        if change is not None and self.helping and self.locked:
            self._answer(change)
        return change

    def _answer(self, change: Change) -> None:
        ids = [i for i in change.ids if change.after.decision(i).settled]
        if not ids or self.practice is None:
            self.hints = ()
            return
        trainee, review = self.practice.trainee, change.after

        def show(marks: tuple[Mark, ...]) -> None:
            self.param.update(hints=marks, practice=self.trainer.running(trainee))

        self.jobs.run("answer", lambda _: self.trainer.help(trainee, review, ids), show)

    # ending

    def ask_finish(self) -> None:
        """Finish at once, or ask where findings are still open."""
        if not self.locked or self.session is None:
            return
        if self.review.counts(self.findings).open:
            self.show("finish")
        else:
            self.finish()

    def finish(self) -> None:
        """Grade the exercise and show what became of it."""
        session, practice = self.session, self.practice
        if session is None or practice is None or practice.finished:
            return
        trainee = practice.trainee
        self.param.update(busy="Grading", dialog="", playing=False, message="")

        def work(ticket: Ticket) -> Feedback:
            def graded(done: int, total: int) -> None:
                ticket.tell(lambda: self.param.update(busy=f"Grading: {done} of {total} repairs"))

            return self.trainer.finish(trainee, session, graded)

        def show(told: Feedback) -> None:
            self.param.update(
                busy="", practice=told.practice, feedback=told, hints=(), dialog="feedback"
            )

        self.jobs.run("grade", work, show)

    def show_feedback(self) -> None:
        """Show once more what the trainee got."""
        if self.feedback is not None:
            self.show("feedback")

    def look(self, number: int) -> None:
        """Show one mark of the feedback on the desk."""
        told, opened = self.feedback, self.opened
        if told is None or opened is None or not 0 <= number < len(told.grade.marks):
            return
        mark = told.grade.marks[number]
        with param.parameterized.batch_call_watchers(self):
            self.dialog = ""
            here = (f for f in self.findings if f.marker == mark.marker)
            there = (f for f in here if self.judged(f).span.overlaps(mark.span))
            found: Finding | None = self.find(mark.finding) or next(there, None)
            if found is not None:
                self.select(found)
                return
            self.select(None)
            self.param.update(marker=mark.marker, zoom="5 s", frame=mark.span.start)
            self._fit_window()

    def next_exercise(self) -> None:
        """Take the exercise that is chosen for the weakest kind."""
        if self.practice is None or not self.practice.finished:
            return
        hidden = self.practice.hidden
        request = self.trainer.request.another()
        self.practise(Request(request.take, hidden=hidden))

    def leave_exercise(self) -> None:
        """Give the exercise up; it is not graded."""
        if self.practice is None:
            return
        self.trainer.leave(self.practice.trainee)
        self.jobs.cancel("grade")
        self.param.update(practice=None, feedback=None, hints=(), helping=False)
        self.message = "The exercise is left ungraded; open a take (Ctrl+O), or practise again."
