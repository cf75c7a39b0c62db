"""How long a cycle of a periodic motion lasts, and how periodic it is."""

from dataclasses import dataclass

import numpy as np

from markermend.errors import BadInput
from markermend.evaluate.hiding import complete_markers
from markermend.model import Take

SHORTEST_S, LONGEST_S = 0.5, 2.5
ALIKE = 0.9
"""Share of the highest correlation that a shorter lag must reach to be the cycle instead."""


@dataclass(frozen=True)
class Cycle:
    """The period of a take.

    Attributes
    ----------
    seconds
        Its length.
    likeness
        Correlation of the take with itself one cycle later, 1 where it repeats exactly.
    """

    seconds: float
    likeness: float


def cycle_of(take: Take) -> Cycle:
    """Estimate the cycle from the autocorrelation of all complete markers about their middle.

    Raises
    ------
    BadInput
        If nothing repeats after 0.5 to 2.5 s, or the take is too short to tell.
    """
    whole = take.positions[:, complete_markers(take)]
    middle = whole.mean(axis=1, keepdims=True)
    series = (whole - middle).reshape(take.n_frames, -1)
    low, high = (round(s * take.rate) for s in (SHORTEST_S, LONGEST_S))
    correlation = np.full(high + 2, -1.0)
    for lag in range(low - 1, min(high + 2, take.n_frames // 2)):
        one, other = series[lag:], series[: len(series) - lag]
        one, other = one - one.mean(axis=0), other - other.mean(axis=0)
        size = np.sqrt(np.square(one).sum() * np.square(other).sum())
        correlation[lag] = float((one * other).sum() / size) if size else -1.0
    inner = correlation[1:-1]
    peaks = 1 + np.flatnonzero((inner > correlation[:-2]) & (inner >= correlation[2:]))
    peaks = peaks[(peaks >= low) & (correlation[peaks] > 0.0)]
    if not len(peaks):
        raise BadInput(
            f"Nothing in the take repeats after {SHORTEST_S:g} to {LONGEST_S:g} s; say how long a "
            "cycle is to be."
        )
    best = correlation[peaks].max()
    lag = int(peaks[correlation[peaks] >= ALIKE * best][0])
    return Cycle(lag / take.rate, float(correlation[lag]))
