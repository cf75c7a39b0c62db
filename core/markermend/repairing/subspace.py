"""Kalman smoothing of a few principal coordinates (Burke and Lasenby, 2016)."""

from dataclasses import dataclass

import numpy as np

from markermend.errors import CannotRepair
from markermend.model import BoolArray, FloatArray
from markermend.repairing.pca import centred
from markermend.repairing.window import Window

REACH = 30
"""Frames smoothed before and after the span; what is further away has no say any more."""

TAME = 0.9
"""Share of the window's frames in which a neighbour must be seen to take part."""


@dataclass(frozen=True, eq=False)
class Subspace:
    """A linear model of the posture.

    Attributes
    ----------
    mean
        (n_columns,) mm.
    basis
        (n_columns, n_patterns).
    noise
        (n_columns,) mm²: variance of what the patterns leave.
    spread, drift
        (n_patterns, n_patterns) mm²: covariance of the coordinates, and of their steps from one
        frame to the next.
    """

    mean: FloatArray
    basis: FloatArray
    noise: FloatArray
    spread: FloatArray
    drift: FloatArray


def learn(data: FloatArray, n_dims: int, cumulative: float) -> Subspace:
    """Fit the model to complete frames.

    Parameters
    ----------
    data
        (n_frames, n_columns) mm; frames with a NaN are left out.
    n_dims
        Columns of one marker; they share their noise.
    cumulative
        Share of the variance that the patterns must explain.

    Raises
    ------
    CannotRepair
        If fewer than ten frames are complete.
    """
    whole: BoolArray = np.asarray(np.isfinite(data).all(axis=1))
    known = data[whole]
    if len(known) < 10:
        raise CannotRepair(
            f"Only {len(known)} frames around the span show the marker with all its neighbours; "
            "choose a method that needs fewer, such as rigid."
        )
    mean = known.mean(axis=0)
    values, vectors = np.linalg.eigh(np.cov(known.T))
    share = values[::-1].cumsum() / max(values.sum(), np.finfo(float).tiny)
    basis = vectors[:, ::-1][:, : int(np.argmax(share >= cumulative - 1e-12)) + 1]
    scores = (data - mean) @ basis
    steps = np.diff(scores, axis=0)[whole[1:] & whole[:-1]]
    left = known - mean - scores[whole] @ basis.T
    floor = 1e-6 * max(float(values.sum()), 1e-6)
    noise = np.square(left).mean(axis=0).reshape(-1, n_dims).mean(axis=1).repeat(n_dims)
    tame = floor * np.eye(basis.shape[1])
    return Subspace(
        mean=mean,
        basis=basis,
        noise=noise + floor,
        spread=np.atleast_2d(np.cov(scores[whole].T)) + tame,
        drift=(steps.T @ steps) / max(len(steps), 1) + 1e-3 * tame,
    )


def smooth(model: Subspace, data: FloatArray) -> FloatArray:
    """Estimate every column in every frame from all that is seen before, then and after.

    Parameters
    ----------
    data
        (n_frames, n_columns) mm, NaN where not seen.

    Returns
    -------
    (n_frames, n_columns) mm.

    Notes
    -----
    Kalman filter in information form on a random walk of the coordinates, and the smoother of
    Rauch, Tung and Striebel.
    """
    n, size = len(data), model.basis.shape[1]
    seen = np.isfinite(data)
    scaled = np.where(seen, data - model.mean, 0.0) / model.noise
    pull = scaled @ model.basis
    state, cover = np.zeros((n, size)), np.zeros((n, size, size))
    ahead, ahead_cover = np.zeros((n, size)), np.zeros((n, size, size))
    gains: dict[bytes, FloatArray] = {}
    unit = np.eye(size)
    prior, prior_cover = np.zeros(size), model.spread
    for t in range(n):
        pattern = seen[t].tobytes()
        if pattern not in gains:
            part = model.basis[seen[t]]
            gains[pattern] = (part / model.noise[seen[t], None]).T @ part
        ahead[t], ahead_cover[t] = prior, prior_cover
        gain = gains[pattern]
        cover[t] = prior_cover @ np.linalg.inv(unit + gain @ prior_cover)
        state[t] = prior + cover[t] @ (pull[t] - gain @ prior)
        prior, prior_cover = state[t], cover[t] + model.drift
    for t in range(n - 2, -1, -1):
        gain = cover[t] @ np.linalg.inv(ahead_cover[t + 1])
        state[t] += gain @ (state[t + 1] - ahead[t + 1])
    return np.asarray(model.mean + state @ model.basis.T)


def fill_by_smoothing(cut: Window, cumulative: float) -> FloatArray:
    """Fill the span, and meet the edges.

    Returns
    -------
    (len(span), n_dims) mm.
    """
    steady = cut.seen.mean(axis=0) >= TAME
    steady[cut.marker] = True
    if steady.sum() < 2:
        raise CannotRepair(
            f"No other marker is seen nearly always around the span of {cut.label}; choose a "
            "method that needs none, such as pchip."
        )
    middle = centred(cut)
    data = (cut.positions[:, steady] - middle[:, None]).reshape(cut.n_frames, -1)
    model = learn(data, cut.n_dims, cumulative)
    near = cut.span.padded(REACH, cut.n_frames)
    first = int(steady[: cut.marker].sum()) * cut.n_dims
    predicted = np.full((cut.n_frames, cut.n_dims), np.nan)
    found = smooth(model, data[near.frames])[:, first : first + cut.n_dims]
    predicted[near.frames] = found + middle[near.frames]
    return _meeting(cut, predicted)


def _meeting(cut: Window, predicted: FloatArray) -> FloatArray:
    reached = [e for e in cut.edges if e is not None and np.isfinite(predicted[e, 0])]
    return cut.meeting(predicted) if reached else predicted[cut.span.frames]
