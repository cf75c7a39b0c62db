"""Mathematical morphology along time, and the search for pairs of opposite jumps."""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d, minimum_filter1d

from markermend.model import FloatArray, Span


def erosion(x: FloatArray, size: int, as_printed: bool = False) -> FloatArray:
    """Take the least value of each window of `size` (Eq. 13, where max is printed for min)."""
    extreme = maximum_filter1d if as_printed else minimum_filter1d
    eroded: FloatArray = extreme(x, size, axis=0, mode="nearest")
    return eroded


def dilation(x: FloatArray, size: int, as_printed: bool = False) -> FloatArray:
    """Take the largest value of each window of `size` (Eq. 14, where min is printed for max)."""
    extreme = minimum_filter1d if as_printed else maximum_filter1d
    dilated: FloatArray = extreme(x, size, axis=0, mode="nearest")
    return dilated


def opening(x: FloatArray, size: int, as_printed: bool = False) -> FloatArray:
    """Remove hills narrower than `size` (Eq. 15)."""
    return dilation(erosion(x, size, as_printed), size, as_printed)


def closing(x: FloatArray, size: int, as_printed: bool = False) -> FloatArray:
    """Fill valleys narrower than `size` (Eq. 16)."""
    return erosion(dilation(x, size, as_printed), size, as_printed)


def top_hat(x: FloatArray, size: int, as_printed: bool = False) -> FloatArray:
    """Keep hills narrower than `size` (Eq. 17)."""
    return x - opening(x, size, as_printed)


def derivative_pairs(
    jumps: FloatArray, threshold: float, least: int, most: int, apart: int
) -> list[tuple[Span, float]]:
    """Find the stretches between a jump and the next jump back (``find_derivate_pairs``).

    Parameters
    ----------
    jumps
        (n_frames,): the high-passed differential; `jumps[n]` belongs to the step from n - 1 to n.
    threshold
        What both jumps have to exceed in absolute value.
    least, most
        Bounds of the distance of the two, in frames.
    apart
        Half the width of the filter: within it only the largest jump counts, since the filter
        echoes every jump with the opposite sign.

    Returns
    -------
    The spans, and the smaller of the two jumps of each.  A pair closer than `least` is passed over.
    """
    size = np.abs(jumps)
    largest = maximum_filter1d(size, 2 * apart + 1, mode="nearest")
    events: NDArray[np.intp] = np.flatnonzero((size > threshold) & (size == largest))
    found: list[tuple[Span, float]] = []
    at = 0
    while at < len(events) - 1:
        start = int(events[at])
        later = events[at + 1 :]
        back = np.flatnonzero(
            (jumps[later] * jumps[start] < 0) & (later - start <= most) & (later - start > 0)
        )
        if not len(back):
            at += 1
            continue
        stop = int(later[back[0]])
        if stop - start >= least:
            found.append((Span(start, stop), float(min(size[start], size[stop]))))
        at += int(back[0]) + 2
    return found
