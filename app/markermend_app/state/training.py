"""What a trainee works on and gets back; the truth stays in here until the exercise is finished."""

import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime

import numpy as np

from markermend import body, detection
from markermend.errors import CannotRepair
from markermend.model import Finding, FloatArray, Kind, Span, Take
from markermend.repairing import repair
from markermend.review import Review
from markermend.review.mending import mend
from markermend.review.session import ReviewSession
from markermend.review.store import Store
from markermend.train import (
    FAST,
    Curve,
    Exercise,
    Grade,
    Mark,
    Next,
    Request,
    archive,
    curves,
    grade,
    next_exercise,
    prepare,
    report,
)
from markermend.train.levels import LEVELS
from markermend_app.state.sights import Sight, around, sight
from markermend_app.state.workspace import Opened

PURPOSE = "exercise"
SIGHTS = ("recorded", "truth", "best", "yours")
"""Names of the lines in the pictures of a feedback, those drawn last on top."""


@dataclass(frozen=True, eq=False)
class OpenedExercise(Opened):
    """The take of an exercise, as ready for the desk as any other."""

    number: int = 0

    @property
    def name(self) -> str:
        """What the page calls it; it says nothing of how it was made."""
        return f"Exercise {self.number}"


@dataclass(frozen=True)
class Practice:
    """What a page may say of an exercise before its end.

    Attributes
    ----------
    number, level, title, kinds, hidden
        Which exercise, how hard, what may be in it, and whether findings are shown.
    trainee, why
        Who practises, and why it is this one.
    begun
        When.
    helped
        Whether feedback came after each decision, so that it does not count.
    finished
        Whether it is graded.
    """

    number: int
    level: int
    title: str
    kinds: tuple[Kind, ...]
    hidden: bool
    trainee: str
    why: str
    begun: datetime
    helped: bool = False
    finished: bool = False


@dataclass(frozen=True, eq=False)
class Feedback:
    """What the trainee gets at the end.

    Attributes
    ----------
    practice, grade
        The exercise and its grade.
    sights
        One for each mark of the grade, or None where nothing is known of the truth there.
    curves
        Learning curves, this exercise included where it counts.
    n_done
        Exercises that count so far.
    upcoming
        What to practise next.
    """

    practice: Practice
    grade: Grade
    sights: tuple[Sight | None, ...]
    curves: Mapping[Kind, Curve]
    n_done: int
    upcoming: Next


@dataclass(eq=False)
class _Running:
    """An exercise under way, with what must not be shown."""

    sealed: Exercise
    opened: OpenedExercise
    practice: Practice
    purpose: str
    feedback: Feedback | None = None


class Trainer:
    """Gives exercises and grades them; pages that are loaded again go on where they were.

    Parameters
    ----------
    store
        Where exercises, reviews and grades are kept.
    request
        What the first exercise is to be.
    made
        The first exercise where it was made already, and why it was chosen.
    methods
        Names of the repairs that the trainee's are compared with.
    """

    def __init__(
        self,
        store: Store,
        request: Request | None = None,
        made: tuple[Exercise, str] | None = None,
        methods: Sequence[str] = FAST,
    ) -> None:
        self.store, self.methods = store, methods
        self.request = Request() if request is None else request
        self._made = made
        self._lock = threading.Lock()
        self._running: dict[str, _Running] = {}

    def running(self, trainee: str) -> Practice | None:
        """Give the exercise that a trainee is in, if there is one."""
        now = self._running.get(trainee)
        return None if now is None else now.practice

    def begin(
        self, trainee: str, request: Request | None, progress: Callable[[str], None]
    ) -> tuple[OpenedExercise, Practice]:
        """Make an exercise and keep it, or give the one that the trainee is in.

        Parameters
        ----------
        trainee
            Who practises.
        request
            What is wanted, or None to go on, or for what was asked for at the start.
        progress
            Called with what is being done.

        Raises
        ------
        MarkerMendError
            As `markermend.train.prepare`, and where the store cannot be used.
        """
        with self._lock:
            now = self._running.get(trainee)
            if request is None and now is not None:
                return now.opened, now.practice
            progress("Making an exercise")
            done = archive.results(self.store, trainee)
            first, self._made = self._made, None
            if request is None and first is not None:
                exercise, why = first
            else:
                exercise, why = prepare(request or self.request, done)
            number = archive.known(self.store, exercise.take.content_hash)
            if number is None:
                number = archive.keep(self.store, exercise)
            findings: tuple[Finding, ...] = ()
            if not exercise.hidden:
                progress("Looking for artefacts")
                findings = detection.scan(exercise.take, detection.DEFAULT)
            progress("Finding the body")
            opened = OpenedExercise(exercise.take, findings, body.infer(exercise.take), number)
            title = LEVELS[exercise.level - 1].title if exercise.level else "A real take"
            practice = Practice(
                number, exercise.level, title, exercise.kinds, exercise.hidden, trainee, why,
                datetime.now(UTC),
            )  # fmt: skip
            purpose = self._purpose(exercise.take, trainee)
            self._running[trainee] = _Running(exercise, opened, practice, purpose)
            return opened, practice

    def session(self, trainee: str) -> ReviewSession:
        """Give the trainee's review of the exercise."""
        now = self._running[trainee]
        return ReviewSession.open(self.store, now.sealed.take, trainee, now.purpose)

    def _purpose(self, take: Take, trainee: str) -> str:
        """Go on with a review that was not finished; each further attempt is one of its own."""
        done = {
            record.purpose
            for record in self.store.reviews(take.content_hash)
            if record.operator == trainee and record.status == "finished"
        }
        names = (PURPOSE, *(f"{PURPOSE} {attempt}" for attempt in range(2, len(done) + 2)))
        return next(name for name in names if name not in done)

    def leave(self, trainee: str) -> None:
        """Give an exercise up; what was decided stays in the store."""
        self._running.pop(trainee, None)

    def help(self, trainee: str, review: Review, ids: Sequence[str]) -> tuple[Mark, ...]:
        """Say what single decisions are worth; the exercise does not count any more."""
        now = self._running[trainee]
        now.practice = replace(now.practice, helped=True)
        judged = {key: review.judgements[key] for key in ids if key in review.judgements}
        marks = grade(now.sealed, Review(judged), methods=()).marks
        return tuple(mark for mark in marks if mark.finding in judged)

    def feedback(self, trainee: str) -> Feedback | None:
        """Give what the trainee got at the end of the exercise that is shown."""
        now = self._running.get(trainee)
        return None if now is None else now.feedback

    def finish(
        self, trainee: str, session: ReviewSession, progress: Callable[[int, int], None]
    ) -> Feedback:
        """Grade the exercise, keep the grade, and break the seal."""
        now = self._running[trainee]
        review = session.review
        result = grade(
            now.sealed, review, decided=session.decided, methods=self.methods, progress=progress
        )
        helped = now.practice.helped
        archive.record(self.store, now.practice.number, result, trainee, helped=helped)
        session.set_status("finished")
        now.practice = replace(now.practice, finished=True)
        done = archive.results(self.store, trainee)
        now.feedback = Feedback(
            now.practice,
            result,
            _sights(now.sealed, review, result),
            curves(done),
            len(done),
            next_exercise(done),
        )
        return now.feedback

    def report(self, trainee: str) -> str | None:
        """Give the trainee's report as a page of its own, or None before the first exercise."""
        done = archive.results(self.store, trainee)
        return report(done) if done else None


def _sights(exercise: Exercise, review: Review, result: Grade) -> tuple[Sight | None, ...]:
    repaired = mend(exercise.take, review.accepted()).repaired
    return tuple(_sight(exercise, repaired, mark) for mark in result.marks)


def _sight(exercise: Exercise, repaired: Take, mark: Mark) -> Sight | None:
    """Show how far off the truth everything was."""
    take, m = exercise.take, exercise.take.index(mark.marker)
    frames = around(take, mark.span).frames
    truth = exercise.clean.positions[frames, m]
    if not np.isfinite(truth).any():
        return None
    versions = {"recorded": take.positions[frames, m], "truth": truth}
    best = _best(exercise, mark)
    if best is not None:
        versions["best"] = best
    if mark.repaired is not None:
        versions["yours"] = repaired.positions[frames, m]
    elif mark.kind == "gap":  # nothing is there that could be off the truth: show the truth itself
        return sight(take, mark.kind, mark.span, {"truth": truth, **versions})
    return sight(take, mark.kind, mark.span, versions, against=truth)


def _best(exercise: Exercise, mark: Mark) -> FloatArray | None:
    """Compute the best method's repair again, for the eye."""
    take = exercise.take
    if (
        mark.repaired is None
        or not mark.repaired.best
        or mark.outcome not in ("right", "misclassified")
    ):
        return None
    answer = next(a for a in exercise.answers if (a.marker, a.span) == (mark.marker, mark.span))
    masked = [(other.marker, other.span) for other in exercise.answers if other is not answer]
    try:
        done = repair(
            take, mark.marker, mark.span, mark.repaired.best, kind=mark.kind,
            partner=answer.truth.partner, masked=masked,
        )  # fmt: skip
    except CannotRepair:  # it was possible when it was graded
        return None
    shown = around(take, mark.span)
    values = np.full((len(shown), take.n_dims), np.nan)
    inside = Span(mark.span.start - shown.start, mark.span.stop - shown.start)
    values[inside.frames] = done.values
    return values
