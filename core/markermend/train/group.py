"""A group of trainees at a glance, for the teacher."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from statistics import median
from typing import Any

from markermend.model import KINDS, Kind
from markermend.train.learning import WINDOW, Next, Result, Share, next_exercise, share


@dataclass(frozen=True)
class Standing:
    """Where one trainee stands.

    Attributes
    ----------
    trainee, exercises, last
        Who, how many exercises were graded, and when the last one.
    level
        Of the last exercise.
    found
        Per kind that was practised: artefacts found and named in the last `WINDOW` exercises that
        held it.
    invented
        Accepted findings of the last `WINDOW` exercises that were another kind or nothing.
    worse
        Exercises after which the take was worse than before, of all.
    seconds_per_finding
        Median over the last `WINDOW` exercises, or None.
    upcoming
        What to practise next.
    """

    trainee: str
    exercises: int
    last: datetime
    level: int
    found: Mapping[Kind, Share]
    invented: Share
    worse: Share
    seconds_per_finding: float | None
    upcoming: Next

    def to_json(self) -> dict[str, Any]:
        """Give it as a record."""
        return {
            "trainee": self.trainee,
            "exercises": self.exercises,
            "last": self.last.isoformat(),
            "level": self.level,
            "found": {kind: one.to_json() for kind, one in self.found.items()},
            "false_discovery": self.invented.to_json(),
            "left_worse": self.worse.to_json(),
            "seconds_per_finding": self.seconds_per_finding,
            "next": {
                "level": self.upcoming.level,
                "kinds": list(self.upcoming.kinds),
                "why": self.upcoming.why,
            },
        }


def standing(results: Sequence[Result]) -> Standing:
    """Say where a trainee stands; `results` are that trainee's, oldest first, at least one."""
    recent = results[-WINDOW:]
    tallies = [tally for result in recent for tally in result.tallies.values()]
    pace = [r.seconds_per_finding for r in recent if r.seconds_per_finding is not None]
    found = {}
    for kind in KINDS:
        held = [r.tallies[kind] for r in results if kind in r.tallies and r.tallies[kind].true]
        last = held[-WINDOW:]
        if last:
            found[kind] = share(sum(t.right for t in last), sum(t.true for t in last))
    return Standing(
        trainee=results[-1].trainee,
        exercises=len(results),
        last=results[-1].at,
        level=results[-1].level,
        found=found,
        invented=share(sum(t.wrong for t in tallies), sum(t.called for t in tallies)),
        worse=share(sum(r.worse for r in results), len(results)),
        seconds_per_finding=median(pace) if pace else None,
        upcoming=next_exercise(results),
    )


def group_table(results: Sequence[Result]) -> tuple[Standing, ...]:
    """Say where every trainee stands, by name."""
    by_trainee: dict[str, list[Result]] = {}
    for result in results:
        by_trainee.setdefault(result.trainee, []).append(result)
    return tuple(standing(by_trainee[name]) for name in sorted(by_trainee))
