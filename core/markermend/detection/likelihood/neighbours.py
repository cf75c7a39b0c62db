"""Which markers keep their distances to which."""

import numpy as np
from numpy.typing import NDArray

from markermend.model import BoolArray, FloatArray

_MOST_FRAMES = 400


def steadiest(positions: FloatArray, seen: BoolArray, most: int) -> NDArray[np.intp]:
    """Order the other markers of each marker by how steady their distance is.

    The measure is the median absolute deviation of the distance plus 1 % of its median, so that of
    two equally steady markers the nearer one comes first, and artefacts of less than half of the
    take do not matter.

    Parameters
    ----------
    positions
        (n_frames, n_markers, 3) mm, without NaN.
    seen
        (n_frames, n_markers).
    most
        How many are wanted per marker.

    Returns
    -------
    NDArray[np.intp]
        (n_markers, min(most, n_markers - 1)): indices, steadiest first.
    """
    n_frames, n_markers, _ = positions.shape
    step = -(-n_frames // _MOST_FRAMES)
    some, valid = positions[::step], seen[::step]
    unsteady = np.full((n_markers, n_markers), np.inf)
    for m in range(n_markers):
        others = slice(m + 1, n_markers)
        distance = np.sqrt(((some[:, others] - some[:, m, None]) ** 2).sum(2))
        both = valid[:, others] & valid[:, m, None]
        if not both.all():
            distance = np.where(both, distance, np.nan)
            distance[:, ~both.any(0)] = np.inf  # never seen together
        median = _median(distance)
        # Infinite minus infinite is no number: where the median is infinite, so is the deviation.
        deviation = _median(np.abs(distance - np.where(np.isfinite(median), median, 0.0)))
        score = np.where(np.isfinite(median), deviation + 0.01 * median, np.inf)
        unsteady[m, others] = unsteady[others, m] = score
    return np.argsort(unsteady, axis=1, kind="stable")[:, : min(most, n_markers - 1)]


def _median(values: FloatArray) -> FloatArray:
    missing = np.isnan(values).any()
    result: FloatArray = np.nanmedian(values, axis=0) if missing else np.median(values, axis=0)
    return result
