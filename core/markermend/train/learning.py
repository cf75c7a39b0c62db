"""What becomes of a trainee over time, and what to practise next.

Every share comes with its 95 % interval (Wilson 1927).  A curve joins pooled shares of `WINDOW`
exercises that follow one another, so there is none before the third exercise of a kind.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from markermend.model import KINDS, Kind
from markermend.train.levels import LEVELS, MIXED, level_of

WINDOW = 3
"""Exercises that are pooled for a point of a curve, and for what comes next."""
CONFIDENCE = 0.95
UP, DOWN = 0.8, 0.5
"""Shares found from which the next exercise is harder, and under which it is easier."""


@dataclass(frozen=True)
class Share:
    """A number of successes with its interval.

    Attributes
    ----------
    right, of
        Successes and trials.
    low, high
        Wilson interval of 95 %; 0 to 1 without trials.
    """

    right: int
    of: int
    low: float
    high: float

    @property
    def value(self) -> float | None:
        """The share, or None without trials."""
        return self.right / self.of if self.of else None

    def to_json(self) -> dict[str, Any]:
        """Give it as a record."""
        return {"value": self.value, **vars(self)}


def share(right: int, of: int) -> Share:
    """Give a share with its Wilson interval."""
    if of == 0:
        return Share(0, 0, 0.0, 1.0)
    from scipy.stats import binomtest  # slow to import, and not always needed

    interval = binomtest(right, of).proportion_ci(CONFIDENCE, "wilson")
    return Share(right, of, float(interval.low), float(interval.high))


@dataclass(frozen=True)
class Tally:
    """What one exercise says of one kind; the numbers are those of `KindScore`."""

    true: int
    right: int
    called: int
    wrong: int


@dataclass(frozen=True)
class Result:
    """What is kept of a grade for curves and tables.

    Attributes
    ----------
    trainee, exercise, at, level
        Who, which exercise, when, how hard.
    tallies
        Per kind that was in the take or was named.
    before_mm, after_mm, worse, seconds_per_finding
        As in `Grade`.
    """

    trainee: str
    exercise: int
    at: datetime
    level: int
    tallies: Mapping[Kind, Tally]
    before_mm: float | None
    after_mm: float | None
    worse: bool
    seconds_per_finding: float | None

    @classmethod
    def from_grade(
        cls, trainee: str, exercise: int, at: datetime, grade: Mapping[str, Any]
    ) -> "Result":
        """Take it from a grade as `Grade.to_json` gives it."""
        fields = ("true", "right", "called", "wrong")
        kinds = grade["kinds"]
        return cls(
            trainee,
            exercise,
            at,
            grade["level"],
            {k: Tally(*(kinds[k][f] for f in fields)) for k in KINDS if k in kinds},
            grade["rmse_before_mm"],
            grade["rmse_after_mm"],
            grade["worse"],
            grade["seconds_per_finding"],
        )


@dataclass(frozen=True)
class Point:
    """One exercise on a learning curve.

    Attributes
    ----------
    exercise, at, level
        Which one.
    share
        Artefacts of the kind that were found and named in it.
    """

    exercise: int
    at: datetime
    level: int
    share: Share


@dataclass(frozen=True)
class Curve:
    """How one trainee does with one kind.

    Attributes
    ----------
    points
        Exercises that held the kind, oldest first.
    line
        The pooled share of each `WINDOW` of them that follow one another, as many as there are
        points less `WINDOW` - 1: none with two points.
    """

    kind: Kind
    points: tuple[Point, ...]
    line: tuple[Share, ...]

    def to_json(self) -> dict[str, Any]:
        """Give it as a record."""
        return {
            "kind": self.kind,
            "points": [
                {
                    "exercise": p.exercise,
                    "at": p.at.isoformat(),
                    "level": p.level,
                    **p.share.to_json(),
                }
                for p in self.points
            ],
            "line": [one.to_json() for one in self.line],
        }


def curves(results: Sequence[Result]) -> dict[Kind, Curve]:
    """Give the learning curves of one trainee, for every kind that was practised."""
    found = {}
    for kind in KINDS:
        held = [r for r in results if kind in r.tallies and r.tallies[kind].true]
        tallies = [r.tallies[kind] for r in held]
        points = tuple(
            Point(r.exercise, r.at, r.level, share(t.right, t.true))
            for r, t in zip(held, tallies, strict=True)
        )
        line = tuple(
            _pooled(tallies[i : i + WINDOW]) for i in range(max(0, len(tallies) - WINDOW + 1))
        )
        if points:
            found[kind] = Curve(kind, points, line)
    return found


def _pooled(tallies: Sequence[Tally]) -> Share:
    return share(sum(t.right for t in tallies), sum(t.true for t in tallies))


@dataclass(frozen=True)
class Next:
    """What to practise next: arguments of `make_exercise`, and why."""

    level: int
    kinds: tuple[Kind, ...]
    why: str


def next_exercise(results: Sequence[Result]) -> Next:
    """Choose the next exercise for the weakest kind.

    The weakest kind is the one whose share found and named, pooled over its last three exercises,
    has the lowest lower end of its 95 % interval; a kind that was never met has 0, and of equals
    the one met first on the way up the levels comes first.  The level is one up if at least 80 % of
    everything in the last exercise was found and named and the take was not left worse, one down
    under 50 %, else the same; a kind is never asked for below the first level that has it.  On the
    levels that hold everything, an exercise of one kind is followed by one of all.
    """
    graded = [r for r in results if r.level > 0]
    if not graded:
        return Next(1, LEVELS[0].kinds, "The first exercise: one obvious peak.")
    last = graded[-1]
    right = sum(t.right for t in last.tallies.values())
    true = sum(t.true for t in last.tallies.values())
    level = last.level + _step(right, true, last.worse)
    level = min(max(level, 1), len(LEVELS))
    allowed = _kinds_up_to(level)
    found = {kind: _recent(graded, kind) for kind in allowed}
    weakest = min(allowed, key=lambda kind: (found[kind].low, allowed.index(kind)))
    only = {kind for kind, tally in last.tallies.items() if tally.true}
    if level_of(level).kinds == MIXED and len(only) == 1:
        return Next(level, MIXED, f"{right} of {true} last time; now everything together.")
    seen = found[weakest]
    state = f"{seen.right} of {seen.of} found" if seen.of else "never practised"
    return Next(level, (weakest,), f"Your weakest kind is {weakest}: {state}.")


def _step(right: int, true: int, worse: bool) -> int:
    if not true:
        return 0
    if right / true >= UP:
        return 0 if worse else 1
    return -1 if right / true < DOWN else 0


def _kinds_up_to(level: int) -> tuple[Kind, ...]:
    return tuple(dict.fromkeys(kind for row in LEVELS[:level] for kind in row.kinds))


def _recent(results: Sequence[Result], kind: Kind) -> Share:
    held = [r.tallies[kind] for r in results if kind in r.tallies and r.tallies[kind].true]
    return _pooled(held[-WINDOW:])
