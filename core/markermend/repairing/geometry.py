"""Frames of reference that move with the body, and how rigidly two markers go together."""

from dataclasses import dataclass

import numpy as np

from markermend.model import FloatArray

FLAT = 1e-3
"""Share of a shape's size below which it counts as a line, and defines no frame."""


@dataclass(frozen=True, eq=False)
class LocalFrames:
    """One frame of reference per frame of the take.

    Attributes
    ----------
    rotation
        (n_frames, n_dims, n_dims): its columns are the axes of the local frame.
    origin
        (n_frames, n_dims) mm.
    """

    rotation: FloatArray
    origin: FloatArray

    def to_local(self, points: FloatArray) -> FloatArray:
        """Turn (n_frames, n_dims) or (n_frames, n_markers, n_dims) into local coordinates."""
        if points.ndim == 2:
            return np.asarray(np.einsum("tij,ti->tj", self.rotation, points - self.origin))
        return np.asarray((points - self.origin[:, None]) @ self.rotation)

    def to_world(self, points: FloatArray) -> FloatArray:
        """Turn local coordinates of either shape back."""
        if points.ndim == 2:
            return np.asarray(np.einsum("tij,tj->ti", self.rotation, points) + self.origin)
        return np.asarray(points @ self.rotation.transpose(0, 2, 1) + self.origin[:, None])

    def at(self, frames: slice) -> "LocalFrames":
        """Return those of some frames only."""
        return LocalFrames(self.rotation[frames], self.origin[frames])


def kabsch(shape: FloatArray, points: FloatArray, weights: FloatArray) -> LocalFrames:
    """Fit a rigid shape to its points in every frame by weighted least squares.

    The origin is the weighted mean of the points, and the shape is taken about its own weighted
    mean, so that ``to_local(points)`` is near ``shape - mean``.

    Parameters
    ----------
    shape
        (n_points, n_dims) mm.
    points
        (n_frames, n_points, n_dims) mm; a point that is NaN in a frame is left out there, and a
        frame without any point becomes NaN.
    weights
        (n_points,), not negative.

    References
    ----------
    W. Kabsch, Acta Cryst. A32:922, 1976; proper rotations by the sign of the determinant.
    """
    seen = np.isfinite(points[:, :, 0])
    if seen.all():
        return _fit(shape, points, np.broadcast_to(weights, seen.shape))
    weight = np.where(seen, weights, 0.0)
    frames = _fit(shape, np.where(seen[:, :, None], points, 0.0), weight)
    void = weight.sum(axis=1) <= 0
    frames.rotation[void] = np.nan
    frames.origin[void] = np.nan
    return frames


def _fit(shape: FloatArray, points: FloatArray, weight: FloatArray) -> LocalFrames:
    share = weight / np.maximum(weight.sum(axis=1, keepdims=True), np.finfo(float).tiny)
    origin = np.einsum("tp,tpd->td", share, points)
    centred = points - origin[:, None]
    model = shape - np.einsum("tp,pd->td", share, shape)[:, None]
    covariance = np.einsum("tp,tpi,tpj->tij", share, centred, model)
    u, _, vt = np.linalg.svd(covariance)
    u[:, :, -1] *= np.sign(np.linalg.det(u) * np.linalg.det(vt))[:, None]
    return LocalFrames(u @ vt, origin)


def defines_frame(shape: FloatArray) -> bool:
    """Tell whether points fix a frame: enough of them, and in 3D not all on one line."""
    n_points, n_dims = shape.shape
    if n_points < n_dims:
        return False
    size = np.linalg.svd(shape - shape.mean(axis=0), compute_uv=False)
    return bool(size[n_dims - 2] > FLAT * size[0] and size[0] > 0)


def distance_spread(
    own: FloatArray, others: FloatArray, least: int = 2
) -> tuple[FloatArray, FloatArray]:
    """Measure how rigidly each other trajectory goes with one.

    Parameters
    ----------
    own
        (n_frames, n_dims) mm, NaN where not seen.
    others
        (n_frames, n_others, n_dims) mm, likewise.
    least
        Frames in which both must be seen.

    Returns
    -------
    The standard deviation over time of the distance, and its mean; (n_others,) mm each, infinite
    where too few frames are seen in common.
    """
    mine = np.isfinite(own[:, 0])
    distance = np.sqrt(np.square(others[mine] - own[mine, None]).sum(axis=2))
    both = np.isfinite(distance)
    count = both.sum(axis=0)
    known = np.where(both, distance, 0.0)
    mean = known.sum(axis=0) / np.maximum(count, 1)
    variance = np.where(both, distance - mean, 0.0)
    spread = np.sqrt(np.square(variance).sum(axis=0) / np.maximum(count, 1))
    enough = count >= least
    return np.where(enough, spread, np.inf), np.where(enough, mean, np.inf)


def closeness(spread: FloatArray, floor: float = 2.0) -> FloatArray:
    """Turn spreads in mm into the weights 1 / (spread² + floor²) of a fit."""
    return np.asarray(1.0 / (np.square(spread) + floor**2))


def mean_shape(points: FloatArray, weights: FloatArray) -> FloatArray:
    """Average a few postures of the same points after aligning them to the first.

    With two postures the result is the same, up to a rotation, in whichever order they come.

    Parameters
    ----------
    points
        (n_postures, n_points, n_dims) mm, all seen.
    """
    first = points[0] - np.average(points[0], axis=0, weights=weights)
    local = kabsch(first, points, weights).to_local(points)
    return np.asarray(local.mean(axis=0))
