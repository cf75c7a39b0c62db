"""Exact likelihood ratios of templates on whitened series, from cumulative sums.

For a template T and noise spectrum P the statistic is ``N^2 / q`` with ``N = sum T g``,
``g = F^-1[F(r) / P]`` and ``q = mean |F(T)|^2 / P``; ``N / q`` is the best amplitude.
"""

import numpy as np

from markermend.detection.likelihood.whitening import Whitened
from markermend.model import FloatArray


def sums(whitened: Whitened) -> FloatArray:
    """(n_series, n_frames + 1): cumulative sums that begin with 0."""
    return np.pad(np.cumsum(whitened.g, axis=1), ((0, 0), (1, 0)))


def boxes(total: FloatArray, length: int) -> FloatArray:
    """N of a box of ones that *starts* at each frame: (n_series, n_frames - length + 1)."""
    return total[:, length:] - total[:, :-length]


def jumps(total: FloatArray, half: int) -> FloatArray:
    """N of a jump by 1 between frames t - 1 and t, seen over `half` frames on each side.

    (n_series, n_frames). Beyond the ends of the series g counts as 0: almost all of a jump's g lies
    within two frames of it.
    """
    n = total.shape[1] - 1
    t = np.arange(n)
    after, before = np.minimum(t + half, n), np.maximum(t - half, 0)
    out: FloatArray = 0.5 * (total[:, after] - 2.0 * total[:, t] + total[:, before])
    out[:, :2] = 0.0
    out[:, n - 1 :] = 0.0
    return out


def jump_template(half: int) -> FloatArray:
    """The template of `jumps`."""
    return np.repeat([-0.5, 0.5], half)


def triangle_template(length: int) -> FloatArray:
    """A triangle of peak 1 over `length` frames."""
    arm = (length + 1) // 2
    return np.convolve(np.ones(arm), np.ones(arm)) / arm


def triangles(total: FloatArray, length: int) -> FloatArray:
    """N of a triangle that *starts* at each frame: (n_series, n_frames - length + 1), odd length.

    A triangle is a box convolved with a box, hence two cumulative sums.
    """
    arm = (length + 1) // 2
    inner = (total[:, arm:] - total[:, :-arm]) / arm
    again = np.pad(np.cumsum(inner, axis=1), ((0, 0), (1, 0)))
    return again[:, arm:] - again[:, :-arm]


def score(N: FloatArray, q: FloatArray) -> FloatArray:
    """Join the three axes of every marker: sqrt(sum N^2 / q), (n_markers, n)."""
    z2 = N * N / q[:, None]
    joined: FloatArray = np.sqrt(z2.reshape(-1, 3, N.shape[1]).sum(1))
    return joined
