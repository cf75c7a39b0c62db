"""An exercise: a take to work on, and the truth about it, which stays sealed until the end."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from markermend.detection.run import DEFAULT, detect
from markermend.errors import BadInput, BadParameter, CannotRepair, UnknownName
from markermend.model import KINDS, Finding, FloatArray, Kind, Span, Take
from markermend.repairing import Wish, apply, repair_all
from markermend.repairing.problem import Repair
from markermend.review import Review
from markermend.simulate import distort, simulate
from markermend.train.levels import level_of
from markermend.train.placing import plan
from markermend.truth import Truth

SCENARIO = "demo"
"""The movement that a trainee gets where no take is given."""


@dataclass(frozen=True, eq=False)
class Answer:
    """One artefact with what the marker really did there.

    Attributes
    ----------
    truth
        What was put in, or what an expert accepted.
    values
        (len(span), n_dims) mm; NaN where nobody knows.
    """

    truth: Truth
    values: FloatArray

    @property
    def marker(self) -> str:
        """Label of the marker."""
        return self.truth.marker

    @property
    def span(self) -> Span:
        """Where it is."""
        return self.truth.span

    @property
    def kind(self) -> Kind:
        """What it is."""
        return self.truth.kind

    def to_json(self) -> dict[str, Any]:
        """Give it as a record; what is not known is null."""
        rows = np.round(self.values, 4).tolist()
        known = [[None if v != v else v for v in row] for row in rows]
        return {**self.truth.to_json(), "values": known}

    @classmethod
    def from_json(cls, record: Mapping[str, Any]) -> "Answer":
        """Read it back."""
        values = np.array(record["values"], np.float64)
        return cls(Truth.from_json(dict(record)), values)


@dataclass(frozen=True)
class Place:
    """A span of a marker on which nothing is graded, for nobody knows what is right there."""

    marker: str
    span: Span


@dataclass(frozen=True, eq=False)
class Exercise:
    """What a trainee gets, and what he is held against.

    Attributes
    ----------
    take
        The take to work on. It has no source: it is no recording, and its hash is its own.
    level, seed
        How it was made; the level is 0 where an expert's review is the truth.
    kinds
        What may be in it.
    amplitude_mm
        Mean size of what was put in; 0 where an expert's review is the truth.
    hidden
        Whether the trainee has to find everything alone; else he judges what a detector shows.
    answers, neutral
        The truth, and where there is none. Not for the trainee before the end: they are left out
        of ``repr`` and of `to_json`.
    """

    take: Take = field(repr=False)
    level: int
    seed: int
    kinds: tuple[Kind, ...]
    amplitude_mm: float
    hidden: bool
    answers: tuple[Answer, ...] = field(repr=False)
    neutral: tuple[Place, ...] = field(default=(), repr=False)

    def to_json(self) -> dict[str, Any]:
        """Give what a trainee may know before the end."""
        return {
            "take": self.take.content_hash,
            "level": self.level,
            "seed": self.seed,
            "kinds": list(self.kinds),
            "amplitude_mm": self.amplitude_mm,
            "hidden": self.hidden,
        }

    @property
    def truths(self) -> tuple[Truth, ...]:
        """What is wrong with the take."""
        return tuple(answer.truth for answer in self.answers)

    @cached_property
    def clean(self) -> Take:
        """The take as it should be; as handed out where nobody knows."""
        positions = self.take.positions.copy()
        for answer in self.answers:
            part = positions[answer.span.frames, self.take.index(answer.marker)]
            known = np.isfinite(answer.values)
            part[known] = answer.values[known]
        return self.take.with_positions(positions)

    def shown(self, detector: str = DEFAULT) -> tuple[Finding, ...]:
        """Give what the trainee is shown to judge: a detector's findings, right and wrong ones.

        Nothing where the trainee has to find everything alone.
        """
        return () if self.hidden else detect(self.take, detector)

    def on(self, take: Take) -> "Exercise":
        """Give the same exercise on the same take as another program or a file gives it back."""
        return replace(self, take=take)


def make_exercise(
    take: Take | None = None,
    level: int = 1,
    seed: int = 0,
    *,
    kinds: Iterable[str] | None = None,
    amplitude_mm: float | None = None,
    density: float | None = None,
    hidden: bool = False,
) -> Exercise:
    """Put artefacts of known place, kind and size into a take.

    Parameters
    ----------
    take
        A take without artefacts, as good as; by default a simulated person, another with each
        seed. Gaps that it has already are not graded.
    level
        Row of `markermend.train.levels.LEVELS`.
    seed
        Of everything; the same seed gives the same exercise.
    kinds, amplitude_mm
        Other ones than the level's.
    density
        Artefacts per minute, in place of the level's number.
    hidden
        Whether the trainee has to find them alone.

    Raises
    ------
    BadParameter, UnknownName
        If level, kinds, amplitude or density cannot be used.
    BadInput
        If the take has no room.
    """
    row = level_of(level)
    wanted = row.kinds if kinds is None else _checked(kinds)
    size = row.amplitude_mm if amplitude_mm is None else amplitude_mm
    if not 0.0 < size <= 1000.0:
        raise BadParameter(f"amplitude_mm must be above 0 and at most 1000; got {size!r}.")
    if density is not None and not 0.0 < density <= 600.0:
        raise BadParameter(f"density must be above 0 and at most 600 a minute; got {density!r}.")
    clean = simulate(SCENARIO, seed, duration_s=row.duration_s) if take is None else take
    clean = replace(clean, source=None)
    count = row.artefacts if density is None else round(density * clean.duration_s / 60.0)
    rng = np.random.default_rng(np.random.SeedSequence([seed, 2]))
    planned = plan(clean, wanted, max(1, count), size, rng)
    dirty, truths = distort(clean, planned, rng)
    answers = tuple(
        Answer(truth, clean.positions[truth.span.frames, clean.index(truth.marker)])
        for truth in truths
    )
    neutral = [
        Place(clean.labels[m], span) for m in clean.measured for span, _ in clean.gaps(int(m))
    ]
    return Exercise(dirty, level, seed, wanted, float(size), hidden, answers, tuple(neutral))


def exercise_from_review(take: Take, review: Review, *, hidden: bool = False) -> Exercise:
    """Make an exercise of a real take that an expert has reviewed.

    What the expert accepted is the truth, with the expert's repairs as what the marker did; what
    was rejected is right as it is; what is open or set aside is not graded.

    Raises
    ------
    BadInput
        If the expert accepted nothing, or two accepted repairs overlap.
    CannotRepair
        If one of the accepted repairs cannot be done.
    """
    wishes = review.accepted()
    if not wishes:
        raise BadInput("The review accepts nothing, so there is nothing to find; give another.")
    repairs, refusals = repair_all(take, wishes)
    if refusals:
        refused = refusals[0]
        raise CannotRepair(
            f"{refused.wish.marker} {refused.wish.span.start}-{refused.wish.span.stop} cannot be "
            f"repaired as the review says ({refused.reason}); mend the review first."
        )
    apply(take, repairs)  # refuses repairs that overlap
    answers = [answer for w, done in zip(wishes, repairs, strict=True) for answer in _of(w, done)]
    neutral = [
        Place(judgement.finding.marker, judgement.span)
        for judgement in review
        if not judgement.decision.settled and not judgement.replaced_by
    ]
    taken = [(answer.marker, answer.span) for answer in answers]
    neutral += [
        Place(take.labels[m], span)
        for m in take.measured
        for span, _ in take.gaps(int(m))
        if not any(span.overlaps(other) for label, other in taken if label == take.labels[m])
    ]
    kinds = tuple(kind for kind in KINDS if any(answer.kind == kind for answer in answers))
    sourceless = replace(take, source=None)
    return Exercise(sourceless, 0, 0, kinds, 0.0, hidden, tuple(answers), tuple(neutral))


def _of(wish: Wish, done: Repair) -> Sequence[Answer]:
    one = Answer(Truth(wish.marker, wish.span, wish.kind, partner=wish.partner), done.values)
    return [
        one,
        *(
            Answer(Truth(label, wish.span, wish.kind, partner=wish.marker), values)
            for label, values in done.also
        ),
    ]


def _checked(kinds: Iterable[str]) -> tuple[Kind, ...]:
    given = tuple(kinds)
    for kind in given:
        if kind not in KINDS:
            raise UnknownName.among("kind", kind, KINDS)
    if not given:
        raise BadInput(f"kinds is empty; name at least one of {', '.join(KINDS)}.")
    return tuple(kind for kind in KINDS if kind in given)
