"""How hard an exercise is: from one obvious peak to a mixed take at 5 mm."""

from dataclasses import dataclass

from markermend.errors import BadParameter
from markermend.model import Kind

MIXED: tuple[Kind, ...] = ("gap", "peak", "noise", "step", "slow")


@dataclass(frozen=True)
class Level:
    """One row of the table of levels.

    Attributes
    ----------
    number, title
        Its number, from 1, and what a trainee reads.
    kinds
        What is put in.
    amplitude_mm
        Mean size; for heavy noise the standard deviation on each axis.
    artefacts
        How many are put in.
    duration_s
        Length of the simulated take.
    """

    number: int
    title: str
    kinds: tuple[Kind, ...]
    amplitude_mm: float
    artefacts: int
    duration_s: float


LEVELS: tuple[Level, ...] = (
    Level(1, "One obvious peak", ("peak",), 60.0, 1, 8.0),
    Level(2, "Peaks", ("peak",), 25.0, 4, 10.0),
    Level(3, "Gaps and peaks", ("gap", "peak"), 20.0, 6, 12.0),
    Level(4, "Heavy noise and peaks", ("peak", "noise"), 15.0, 6, 12.0),
    Level(5, "Steps and peaks", ("peak", "step"), 25.0, 6, 14.0),
    Level(6, "Slow changes and steps", ("step", "slow"), 25.0, 6, 16.0),
    Level(7, "Everything, 15 mm", MIXED, 15.0, 12, 20.0),
    Level(8, "Everything, 10 mm", MIXED, 10.0, 16, 24.0),
    Level(9, "Everything, 5 mm", MIXED, 5.0, 20, 29.0),
)


def level_of(number: int) -> Level:
    """Give a level by its number.

    Raises
    ------
    BadParameter
        If there is no such level.
    """
    if not 1 <= number <= len(LEVELS):
        raise BadParameter(f"level must be a whole number in 1 to {len(LEVELS)}; got {number!r}.")
    return LEVELS[number - 1]
