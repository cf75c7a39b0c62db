"""Ridge regression of a marker's local coordinates on its neighbours'."""

from collections.abc import Callable

import numpy as np

from markermend.model import FloatArray
from markermend.repairing.blend.scene import Scene
from markermend.repairing.geometry import LocalFrames

SOFT_MM = 40.0
"""A neighbour whose distance varies by so much counts half."""


def features(around: Scene, frames: LocalFrames, neighbours: int) -> FloatArray:
    """Give the local coordinates of the first neighbours, the less rigid ones scaled down.

    Returns
    -------
    (n_frames, neighbours · n_dims) mm.
    """
    n = min(neighbours, len(around.order))
    local = frames.to_local(around.neighbours[:, :n])
    local *= (SOFT_MM / (SOFT_MM + around.spread[:n]))[:, None]
    return local.reshape(len(local), -1)


def ridge(z: FloatArray, y: FloatArray, penalty: float) -> Callable[[FloatArray], FloatArray]:
    """Fit y on z and an unpenalised constant.

    Parameters
    ----------
    z, y
        (n_rows, n_features) and (n_rows, n_dims) mm.
    penalty
        mm², added to the variance of every feature.

    Returns
    -------
    The function that predicts (n, n_dims) from (n, n_features).
    """
    centre, mean = z.mean(axis=0), y.mean(axis=0)
    zc = z - centre
    gram = zc.T @ zc
    gram[np.diag_indices_from(gram)] += penalty * len(z)
    slopes = np.linalg.solve(gram, zc.T @ (y - mean))
    constant = mean - centre @ slopes
    return lambda wanted: np.asarray(wanted @ slopes + constant)
