"""Robust local scales of a statistic."""

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from markermend.model import BoolArray, FloatArray

MEDIAN_OF_CHI3 = 1.538  # median norm of a standard normal vector of three dimensions
QUARTILE_OF_CHI3 = 1.101


def rolling_quantile(
    values: FloatArray, valid: BoolArray, half: int, stride: int, quantile: float
) -> FloatArray:
    """Quantile of the valid values around each frame, on every `stride`-th one, interpolated.

    Where no value is valid within the window, that of the whole series is taken.

    Parameters
    ----------
    values, valid
        (n_series, n_frames).

    Returns
    -------
    FloatArray
        (n_series, n_frames).
    """
    n = values.shape[1]
    half = min(half, (n - 1) // 2)
    width = 2 * half + 1
    usable = np.where(valid, values, np.inf)
    windows = np.sort(sliding_window_view(usable, width, axis=1)[:, ::stride], axis=2)
    count = np.isfinite(windows).sum(2)
    place = np.maximum(np.ceil(quantile * count).astype(int) - 1, 0)
    local = np.take_along_axis(windows, place[..., None], axis=2)[..., 0]
    everywhere = np.sort(usable, axis=1)
    whole_count = valid.sum(1)
    whole_place = np.maximum(np.ceil(quantile * whole_count).astype(int) - 1, 0)
    whole = np.take_along_axis(everywhere, whole_place[:, None], axis=1)
    whole = np.where(whole_count[:, None] > 0, whole, 0.0)
    local = np.where(count >= max(3, width // 8), local, whole)
    centres = half + np.arange(local.shape[1]) * stride
    frames = np.arange(n)
    return np.array([np.interp(frames, centres, row) for row in local])
