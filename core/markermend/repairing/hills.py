"""Estimate a slow additive artefact beneath what the neighbours do not explain."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve, cholesky, solve_triangular

from markermend.errors import CannotRepair
from markermend.model import FloatArray
from markermend.repairing.blend.fixed import FRAME_MARKERS, NEIGHBOURS, RIDGE_MM2
from markermend.repairing.blend.ridge import features, ridge
from markermend.repairing.blend.scene import scene
from markermend.repairing.kriging import matern52
from markermend.repairing.problem import Problem
from markermend.repairing.window import Window

LENGTHS_S = (0.05, 0.1, 0.2, 0.4, 0.8)
NUGGETS = (1e-6, 1e-4, 1e-2, 1e-1)
SIDE = 120
"""Frames looked at on each side of the span."""
MOST = 400
"""Frames looked at in all; of longer spans every second, third ... frame is."""


@dataclass(frozen=True, eq=False)
class Unexplained:
    """What the neighbours leave of a marker, around and in the span.

    Attributes
    ----------
    frames
        (n,), counted in the window, ascending.
    inside
        (n,): whether each lies in the span.
    values
        (n, n_dims) mm.
    """

    frames: NDArray[np.intp]
    inside: NDArray[np.bool_]
    values: FloatArray


def unexplained(problem: Problem, cut: Window) -> Unexplained:
    """Take away what the neighbours predict, or the mean where there are too few neighbours."""
    around = cut.span.padded(SIDE, cut.n_frames)
    values = cut.own.copy()
    values[cut.span.frames] = problem.recorded[problem.span.frames]
    values -= _predicted(problem, cut)
    frames = np.arange(around.start, around.stop)
    frames = frames[np.isfinite(values[frames, 0])]
    frames = frames[:: -(-len(frames) // MOST)]
    inside = (frames >= cut.span.start) & (frames < cut.span.stop)
    return Unexplained(frames, inside, values[frames])


def _predicted(problem: Problem, cut: Window) -> FloatArray:
    try:
        around = scene(problem, least=cut.n_dims)
        frames = around.frames_of(FRAME_MARKERS)
    except CannotRepair:
        return np.full_like(cut.own, np.nanmean(cut.own, axis=0))
    rows = np.flatnonzero(around.rows)
    z, y = features(around, frames, NEIGHBOURS), frames.to_local(cut.own)
    found = np.full_like(cut.own, np.nan)
    found[around.there] = ridge(z[rows], y[rows], RIDGE_MM2)(z[around.there])
    return frames.to_world(found)


def covariance(rest: Unexplained, rate: float) -> FloatArray:
    """Choose how the unexplained part wanders, by its likelihood outside the span.

    Returns
    -------
    (n, n) mm²: covariance of one axis over all its frames, inside and out.
    """
    time = rest.frames / rate
    lag = np.abs(time[:, None] - time)
    out = ~rest.inside
    values = rest.values[out] - rest.values[out].mean(axis=0)
    best, likeliest = np.empty((0, 0)), -np.inf
    for length in LENGTHS_S:
        smooth = matern52(lag / length)
        for nugget in NUGGETS:
            whole = smooth + nugget * np.eye(len(time))
            factor = cho_factor(whole[np.ix_(out, out)], lower=True)
            power = float((values * cho_solve(factor, values)).sum()) / values.size
            likelihood = -0.5 * len(values) * np.log(max(power, 1e-12))
            likelihood -= float(np.log(np.diag(factor[0])).sum())
            if likelihood > likeliest:
                best, likeliest = max(power, 1e-12) * whole, likelihood
    return best


@dataclass(frozen=True, eq=False)
class Fit:
    """A shape under what is unexplained.

    Attributes
    ----------
    which
        Number of the shape.
    height, doubt
        (n_dims,) mm: its size, and the standard error of it.
    gain
        Twice the logarithm of how much likelier it is than no shape at all.
    """

    which: int
    height: FloatArray
    doubt: FloatArray
    gain: float


def fit(
    rest: Unexplained, wander: FloatArray, shapes: Sequence[FloatArray], prior: FloatArray
) -> Fit:
    """Fit the likeliest of some shapes by generalised least squares.

    Parameters
    ----------
    wander
        (n, n) mm²: covariance of what is unexplained.
    shapes
        (n,) each, over the same frames.
    prior
        (n_shapes,): twice the logarithm of how likely each is beforehand.
    """
    root = cholesky(wander, lower=True)
    columns = np.column_stack([np.ones(len(wander)), rest.values, *shapes])
    white = solve_triangular(root, columns, lower=True)
    # A constant offset is free: what is unexplained has a level of its own.
    level = white[:, :1] / np.linalg.norm(white[:, 0])
    white = white - level @ (level.T @ white)
    n_dims = rest.values.shape[1]
    signal, patterns = white[:, 1 : 1 + n_dims], white[:, 1 + n_dims :]
    power = np.square(patterns).sum(axis=0)
    heights = (patterns.T @ signal) / power[:, None]
    gains = np.square(heights).sum(axis=1) * power
    which = int((gains + prior).argmax())
    doubt = np.full(n_dims, 1.0 / np.sqrt(power[which]))
    return Fit(which, heights[which], doubt, float(gains[which]))
