"""How long a cycle of a periodic motion lasts, and how periodic it is."""

from dataclasses import dataclass

import numpy as np

from markermend.errors import BadInput
from markermend.evaluate.hiding import complete_markers
from markermend.model import FloatArray, Take

SHORTEST_S, LONGEST_S = 0.5, 2.5
ALIKE = 0.9
"""Share of the highest correlation that a shorter lag must reach to be the cycle instead."""


RISE = 0.1
"""How much more alike the take must be a cycle later than at some time before."""


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


def cycle_of(take: Take, seconds: float | None = None) -> Cycle:
    """Estimate the cycle from the autocorrelation of all complete markers about their middle.

    Parameters
    ----------
    seconds
        Its length where it is known, or is to be taken as known.

    Raises
    ------
    BadInput
        If nothing repeats after 0.5 to 2.5 s, or the take is too short to tell.
    """
    whole = take.positions[:, complete_markers(take)]
    series = (whole - whole.mean(axis=1, keepdims=True)).reshape(take.n_frames, -1)
    if seconds is not None:
        lag = round(seconds * take.rate)
        if not 1 <= lag < take.n_frames // 2:
            raise BadInput(
                f"A cycle of {seconds:g} s does not fit twice into {take.duration_s:.2f} s; give "
                "the length of a cycle in seconds."
            )
        return Cycle(seconds, _likeness(series, lag))
    low, high = (round(s * take.rate) for s in (SHORTEST_S, LONGEST_S))
    lags = np.arange(1, min(high + 2, take.n_frames // 2))
    correlation = np.array([_likeness(series, int(lag)) for lag in lags])
    inner = correlation[1:-1]
    peaks = 1 + np.flatnonzero((inner > correlation[:-2]) & (inner >= correlation[2:]))
    trough = np.minimum.accumulate(correlation)
    peaks = peaks[(lags[peaks] >= low) & (correlation[peaks] > trough[peaks] + RISE)]
    if not len(peaks):
        raise BadInput(
            f"Nothing in the take repeats after {SHORTEST_S:g} to {LONGEST_S:g} s; say how long a "
            "cycle is to be."
        )
    first = peaks[correlation[peaks] >= ALIKE * correlation[peaks].max()][0]
    return Cycle(int(lags[first]) / take.rate, float(correlation[first]))


def _likeness(series: FloatArray, lag: int) -> float:
    one, other = series[lag:], series[:-lag]
    one, other = one - one.mean(axis=0), other - other.mean(axis=0)
    size = float(np.sqrt(np.square(one).sum() * np.square(other).sum()))
    return float((one * other).sum()) / size if size > 0.0 else 0.0
