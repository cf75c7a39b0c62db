"""Smoothing that neither lags nor reaches across a gap."""

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.ndimage import correlate1d, median_filter

from markermend.model import FloatArray, runs

Filter = Callable[[FloatArray], FloatArray]


def odd_width(seconds: float, rate: float) -> int:
    """Give the odd number of frames that lasts about so long, at least 1.

    An even window has no middle and would shift the curve by half a frame.
    """
    return 2 * int(seconds * rate / 2.0) + 1


def smooth_runs(values: FloatArray, width: int, median: bool = True) -> FloatArray:
    """Smooth by a moving median and then a moving mean, both symmetric about every frame.

    Near the ends of each seen run the window shrinks with the distance to the end; the last two
    frames stay as they are.

    Parameters
    ----------
    values
        (n_frames, n_columns), NaN where not seen; a frame is seen in all columns or in none.
    width
        Odd number of frames; below 3 nothing is done.
    median
        Whether the median comes first, as in the paper. It is taken column by column, so that of
        coordinates it depends on how the room is turned.

    References
    ----------
    M. Tits, J. Tilmanne, T. Dutoit, PLoS ONE 13(7):e0199744, 2018.
    """
    smooth = values.copy()
    half = width // 2
    for run in runs(np.isfinite(values[:, 0])) if half else ():
        part = values[run.frames]
        if median:
            part = _shrinking(
                part,
                half,
                lambda x: median_filter(x, size=(width, 1), mode="nearest"),
                lambda x: np.median(x, axis=0),
            )
        smooth[run.frames] = _shrinking(
            part,
            half,
            # Not a running sum: its rounding would drown what is many powers of ten smaller.
            lambda x: correlate1d(x, np.full(width, 1.0 / width), axis=0, mode="nearest"),
            lambda x: x.mean(axis=0),
        )
    return smooth


def _shrinking(
    values: FloatArray, half: int, whole: Filter, single: Callable[[FloatArray], Any]
) -> FloatArray:
    n = len(values)
    smooth = values.copy()
    if n > 2 * half:
        smooth[half : n - half] = whole(values)[half : n - half]
    for reach in range(2, min(half, (n + 1) // 2)):
        for at in (reach, n - 1 - reach):
            smooth[at] = single(values[at - reach : at + reach + 1])
    return smooth
