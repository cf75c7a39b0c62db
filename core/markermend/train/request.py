"""What somebody asks for when asking for an exercise."""

import secrets
from collections.abc import Sequence
from dataclasses import dataclass, replace

from markermend.model import Take
from markermend.review import Review
from markermend.train.exercise import Exercise, exercise_from_review, make_exercise
from markermend.train.learning import Result, next_exercise


@dataclass(frozen=True, eq=False)
class Request:
    """Arguments of `make_exercise`; what is None is chosen for the trainee.

    Attributes
    ----------
    take, level, seed, kinds, amplitude_mm, density, hidden
        As in `make_exercise`; without a level, level and kinds are what the trainee needs next,
        without a seed it is another exercise each time.
    expert
        A review of the take that is the truth, in place of artefacts that are put in.
    """

    take: Take | None = None
    level: int | None = None
    seed: int | None = None
    kinds: tuple[str, ...] | None = None
    amplitude_mm: float | None = None
    density: float | None = None
    hidden: bool = False
    expert: Review | None = None

    def another(self) -> "Request":
        """Ask for the next exercise of the same sort: chosen for the trainee, with another seed.

        After an expert's take there is no other truth on it, so a simulated person follows.
        """
        take = None if self.expert is not None else self.take
        return replace(
            self, take=take, level=None, seed=None, kinds=None, amplitude_mm=None, density=None,
            expert=None,
        )  # fmt: skip


def prepare(request: Request, done: Sequence[Result]) -> tuple[Exercise, str]:
    """Make what was asked for.

    Parameters
    ----------
    request
        What is wanted.
    done
        Earlier results of the trainee, oldest first.

    Returns
    -------
    The exercise, and why it was chosen where it was.

    Raises
    ------
    BadInput, BadParameter, UnknownName, CannotRepair
        As `make_exercise` and `exercise_from_review`.
    """
    if request.expert is not None and request.take is not None:
        return exercise_from_review(request.take, request.expert, hidden=request.hidden), ""
    level, kinds, why = request.level, request.kinds, ""
    if level is None:
        upcoming = next_exercise(done)
        level, why = upcoming.level, upcoming.why
        kinds = upcoming.kinds if kinds is None else kinds
    made = make_exercise(
        request.take,
        level,
        secrets.randbelow(2**32) if request.seed is None else request.seed,
        kinds=kinds,
        amplitude_mm=request.amplitude_mm,
        density=request.density,
        hidden=request.hidden,
    )
    return made, why
