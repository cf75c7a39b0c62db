"""Fill all gaps of a short window at once: a matrix normal model of time and markers (SHORT).

With little to learn from, every sample counts: also those of markers that have gaps themselves.
The positions X (frames × markers, for each axis) are taken as one draw from a normal distribution
whose covariance is K ⊗ C: K over time is known up to its nugget, C over markers is learnt by
expectation and maximisation.  The axes share the weights between markers, so that the model turns
with the room.
"""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline
from scipy.linalg import cho_factor, cho_solve, cholesky, solve_triangular
from scipy.linalg.lapack import dpotri

from markermend.model import FloatArray
from markermend.repairing.kriging import matern52

LENGTH_S = 0.3
NUGGETS = tuple(10.0 ** np.arange(-8.0, -3.4, 0.5))
STEPS = 5
SHRINKAGE = 0.05
REACH_MM = 300.0
FLOOR = 0.02
MEMBERS = ((10.0, 0.4), (1000.0, 0.6))
NUGGET_BOUNDS = (1e-7, 1e-3)


def prefilled(positions: FloatArray) -> FloatArray:
    """Bridge all gaps by cubics that do not overshoot; hold the first and last seen positions."""
    filled = positions.copy()
    frames = np.arange(len(positions))
    seen = np.isfinite(positions[:, :, 0])
    for m in np.flatnonzero(~seen.all(axis=0)):
        known = np.flatnonzero(seen[:, m])
        if len(known) < 2:
            filled[:, m] = positions[known[0], m] if len(known) else 0.0
            continue
        inside = np.clip(frames, known[0], known[-1])
        filled[:, m] = CubicHermiteSpline(known, positions[known, m], _slopes(known, filled[:, m]))(
            inside
        )
    return filled


def _slopes(known: NDArray[np.intp], values: FloatArray) -> FloatArray:
    """Give slopes that make no cubic overshoot.

    On a straight path they are those of Fritsch and Butland (SIAM J. Sci. Stat. Comput. 5:300,
    1984), as in pchip; the harmonic mean is taken of vectors, so that they turn with the room.
    """
    step = np.diff(known)[:, None].astype(float)
    chord = np.diff(values[known], axis=0) / step
    before, after = chord[:-1], chord[1:]
    near, far = 2 * step[1:] + step[:-1], step[1:] + 2 * step[:-1]
    along = near * after + far * before
    square = np.square(along).sum(axis=1, keepdims=True)
    alike = np.maximum((before * after).sum(axis=1, keepdims=True), 0.0)
    share = np.divide((near + far) * alike, square, out=np.zeros_like(square), where=square > 0)
    return np.concatenate([chord[:1], share * along, chord[-1:]])


def nugget_by_evidence(positions: FloatArray, rate: float) -> float:
    """Choose the share of white noise under which complete trajectories are most probable.

    The axes of a marker have their variance in common.

    Parameters
    ----------
    positions
        (n_frames, n_markers, n_dims) mm, without gaps.
    rate
        Hz.
    """
    n, n_markers, n_dims = positions.shape
    lag = (np.arange(n)[:, None] - np.arange(n)) / (rate * LENGTH_S)
    kernel = matern52(lag)
    centred = (positions - positions.mean(axis=0)).reshape(n, -1)
    evidence = []
    for nugget in NUGGETS:
        factor = cholesky(kernel + nugget * np.eye(n), lower=True)
        white = solve_triangular(factor, centred, lower=True)
        power = np.square(white).reshape(n, n_markers, n_dims).mean(axis=(0, 2)) + 1e-12
        size = 0.5 * n * np.log(power).sum() + n_markers * np.log(np.diag(factor)).sum()
        evidence.append(-n_dims * size)
    return float(NUGGETS[int(np.argmax(evidence))])


def matrix_normal(
    positions: FloatArray, start: FloatArray, rate: float, nugget: float
) -> FloatArray:
    """Fill all gaps by expectation and maximisation.

    Parameters
    ----------
    positions
        (n_frames, n_markers, n_dims) mm, NaN where missing, about a common centre.
    start
        The same, prefilled.
    rate
        Hz.
    nugget
        Share of white noise in time.

    Returns
    -------
    (n_frames, n_markers, n_dims) mm, without gaps.
    """
    n_frames, n_markers, n_dims = positions.shape
    lag = (np.arange(n_frames)[:, None] - np.arange(n_frames)) / (rate * LENGTH_S)
    over_time = cho_solve(
        cho_factor(matern52(lag) + nugget * np.eye(n_frames), lower=True), np.eye(n_frames)
    )
    missing = np.argwhere(~np.isfinite(positions[:, :, 0]).T)[:, ::-1]
    t, m = missing[:, 0], missing[:, 1]
    member = np.zeros((len(missing), n_markers))
    member[np.arange(len(missing)), m] = 1.0
    time_part = over_time[np.ix_(t, t)]
    filled = start.copy()
    near = _nearness(filled)
    uncertain = np.zeros((n_markers, n_markers))
    for _ in range(STEPS):
        scatter = sum(filled[:, :, d].T @ over_time @ filled[:, :, d] for d in range(n_dims))
        covariance = (scatter + n_dims * uncertain) / (n_dims * n_frames)
        spread = np.sqrt(np.diag(covariance)) + 1e-3
        covariance = (1 - SHRINKAGE) * covariance + SHRINKAGE * np.outer(spread, spread) * near
        weights = cho_solve(cho_factor(covariance, lower=True), np.eye(n_markers))
        precision = weights[np.ix_(m, m)] * time_part
        factor = cho_factor(precision, lower=True)
        pull = np.stack(
            [(over_time @ filled[:, :, d] @ weights)[t, m] for d in range(n_dims)], axis=1
        )
        filled[t, m] -= cho_solve(factor, pull)
        posterior = _inverse(factor[0])
        uncertain = member.T @ (posterior * time_part) @ member
    return filled


def _inverse(lower: FloatArray) -> FloatArray:
    """Invert a matrix of which the lower Cholesky factor is given."""
    half, _ = dpotri(lower, lower=1)
    return np.asarray(np.tril(half) + np.tril(half, -1).T)


def _nearness(filled: FloatArray) -> FloatArray:
    between = np.linalg.norm(filled[:, :, None] - filled[:, None], axis=3).mean(axis=0)
    values, vectors = np.linalg.eigh(np.exp(-np.square(between) / (2 * REACH_MM**2)))
    near = (vectors * np.maximum(values, 0.0)) @ vectors.T
    return np.asarray(near + FLOOR * np.eye(len(near)))


def fill_at_once(positions: FloatArray, rate: float) -> FloatArray:
    """Fill all gaps of a window by two matrix normal models of different nuggets.

    The last few windows are remembered, since every gap of a window asks for the same.

    Parameters
    ----------
    positions
        (n_frames, n_markers, n_dims) mm, NaN where missing.
    rate
        Hz.

    Returns
    -------
    (n_frames, n_markers, n_dims) mm, without gaps, read-only.
    """
    return _fill_at_once(np.ascontiguousarray(positions).tobytes(), positions.shape, rate)


@lru_cache(maxsize=8)
def _fill_at_once(content: bytes, shape: tuple[int, ...], rate: float) -> FloatArray:
    positions = np.frombuffer(content).reshape(shape)
    complete = np.flatnonzero(np.isfinite(positions[:, :, 0]).all(axis=0))
    chosen = complete if len(complete) else np.arange(positions.shape[1])
    start = prefilled(positions)
    centre = start[:, chosen].mean(axis=1)[:, None]
    known = (start - centre)[:, chosen]
    nugget = nugget_by_evidence(known, rate)
    filled = np.zeros_like(start)
    for factor, weight in MEMBERS:
        used = float(np.clip(nugget * factor, *NUGGET_BOUNDS))
        filled += weight * matrix_normal(positions - centre, start - centre, rate, used)
    filled += centre
    filled.flags.writeable = False
    return filled
