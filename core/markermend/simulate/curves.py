"""Smooth functions of time that all movement is made of."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.signal import fftconvolve
from scipy.spatial.transform import Rotation

from markermend.model import FloatArray

Keys = Sequence[tuple[float, float]]
"""Pairs of a time in s and the value that is reached then."""


def rise(time: FloatArray, start_s: float, stop_s: float) -> FloatArray:
    """Go from 0 to 1 with the least jerk (Flash and Hogan, J. Neurosci. 5, 1985, eq. 4)."""
    s = np.clip((time - start_s) / (stop_s - start_s), 0.0, 1.0)
    eased: FloatArray = s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
    return eased


def keyed(time: FloatArray, keys: Keys) -> FloatArray:
    """Go from key to key with the least jerk, and rest at each; a constant beyond the ends."""
    value = np.full_like(time, keys[0][1])
    for (t0, before), (t1, after) in pairwise(keys):
        if after != before:
            value += (after - before) * rise(time, t0, t1)
    return value


def smooth(values: FloatArray, sigma_s: float, rate: float) -> FloatArray:
    """Smooth along frames with a Gaussian; the ends are continued as they are."""
    smoothed: FloatArray = gaussian_filter1d(values, sigma_s * rate, axis=0, mode="nearest")
    return smoothed


def wander(
    rng: np.random.Generator, n_frames: int, n_channels: int, sigma_s: float, rate: float
) -> FloatArray:
    """Wander smoothly about zero with unit variance.

    Returns
    -------
    (n_frames, n_channels), channels independent of one another; `sigma_s` is the width of the
    Gaussian that smooths white noise, so that it turns about every 4.4 `sigma_s`.
    """
    half = int(np.ceil(4.0 * sigma_s * rate))
    kernel = np.exp(-0.5 * (np.arange(-half, half + 1) / (sigma_s * rate)) ** 2)
    white = rng.standard_normal((n_frames + 2 * half, n_channels))
    unit = kernel / np.linalg.norm(kernel)
    wandering: FloatArray = fftconvolve(white, unit[:, None], mode="valid", axes=0)
    return wandering


def turned(axis: str, angle: FloatArray) -> FloatArray:
    """Rotation matrices, (n, 3, 3), about one axis ``x``, ``y`` or ``z`` by `angle`, in radians."""
    matrices: FloatArray = Rotation.from_euler(axis, angle[:, None]).as_matrix()
    return matrices


def placed(rotation: FloatArray, offset: FloatArray) -> FloatArray:
    """Turn a fixed offset, (3,), by rotations, (n, 3, 3)."""
    points: FloatArray = rotation @ offset
    return points


def ahead_by(values: FloatArray, by_s: float, rate: float) -> FloatArray:
    """Take the values from `by_s` later (from before, where negative)."""
    frames = np.clip(np.arange(len(values)) + round(by_s * rate), 0, len(values) - 1)
    return values[frames]
