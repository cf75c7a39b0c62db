"""Carry what is known at the edges of a gap into it: linear operators over time.

Each operator is a matrix W of shape (gap frames, boundary frames): the values inside the gap are
W times the values at the boundary.  Kriging is simple (the unknown mean is zero), ordinary (an
unknown constant) or with a linear drift.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.linalg import cho_factor, cho_solve

from markermend.model import FloatArray

NUGGET = 1e-4
"""Variance of the noise of measurement as a share of the residual's."""

Kernel = Callable[[FloatArray], FloatArray]


def matern32(lag: FloatArray) -> FloatArray:
    """Matérn correlation of smoothness 3/2; `lag` in units of its length."""
    x = np.sqrt(3.0) * np.abs(lag)
    return np.asarray((1 + x) * np.exp(-x))


def matern52(lag: FloatArray) -> FloatArray:
    """Matérn correlation of smoothness 5/2; `lag` in units of its length."""
    x = np.sqrt(5.0) * np.abs(lag)
    return np.asarray((1 + x + x * x / 3) * np.exp(-x))


@dataclass(frozen=True, eq=False)
class Operator:
    """One way into the gap.

    Attributes
    ----------
    name
        For the operator to read.
    weights
        (n_gap, n_boundary).
    """

    name: str
    weights: FloatArray


def krige(
    inside: FloatArray, boundary: FloatArray, kernel: Kernel, length: float, drift: int = -1
) -> FloatArray:
    """Give the weights of (universal) kriging in time.

    Parameters
    ----------
    inside, boundary
        (n_gap,) and (n_boundary,) s: the times wanted and the times known.
    kernel, length
        Correlation, and its length in s.
    drift
        Degree of the polynomial of unknown coefficients; -1 for none.

    Returns
    -------
    (n_gap, n_boundary): W = K_gb (K_bb + nugget I)⁻¹, corrected for the drift.
    """
    own = kernel((boundary[:, None] - boundary) / length) + NUGGET * np.eye(len(boundary))
    across = kernel((inside[:, None] - boundary) / length)
    factor = cho_factor(own, lower=True)
    weights = cho_solve(factor, across.T).T
    if drift >= 0:
        middle, half = _scale(inside, boundary)
        powers = np.arange(min(drift, len(boundary) - 1) + 1)
        at_boundary = ((boundary[:, None] - middle) / half) ** powers
        at_gap = ((inside[:, None] - middle) / half) ** powers
        solved = cho_solve(factor, at_boundary)
        mend = np.linalg.solve(at_boundary.T @ solved, solved.T)
        weights = weights + (at_gap - weights @ at_boundary) @ mend
    return np.asarray(weights)


def _scale(inside: FloatArray, boundary: FloatArray) -> tuple[float, float]:
    every = np.concatenate([inside, boundary])
    return float(every.mean()), float(max(np.ptp(every) / 2, 1e-9))


def hermite(inside: FloatArray, boundary: FloatArray, frames: int = 3) -> FloatArray:
    """Join value and slope at both edges by one cubic; with one edge only, hold its value.

    The slope is that of the straight line through `frames` frames.
    """
    before, after = _sides(inside, boundary)
    weights = np.zeros((len(inside), len(boundary)))
    if not (len(before) and len(after)):
        edge = before[-1] if len(before) else after[0]
        weights[:, edge] = 1.0
        return weights
    before, after = before[-frames:], after[:frames]
    start, stop = boundary[before[-1]], boundary[after[0]]
    width = stop - start
    u = (inside - start) / width
    weights[:, before[-1]] += (1 + 2 * u) * (1 - u) ** 2
    weights[:, after[0]] += u * u * (3 - 2 * u)
    for side, shape in ((before, u * (1 - u) ** 2), (after, u * u * (u - 1))):
        if len(side) > 1:
            times = boundary[side] - boundary[side].mean()
            weights[:, side] += np.outer(width * shape, times / np.square(times).sum())
    return weights


def ramp(inside: FloatArray, boundary: FloatArray) -> FloatArray:
    """Join the last value before and the first after by a line; with one edge, hold its value."""
    order = np.argsort(boundary)
    weights = np.zeros((len(inside), len(boundary)))
    for column in range(len(boundary)):
        unit = np.zeros(len(boundary))
        unit[column] = 1.0
        weights[:, column] = np.interp(inside, boundary[order], unit[order])
    return weights


def cubic(inside: FloatArray, boundary: FloatArray) -> FloatArray:
    """Run one natural cubic spline through all boundary frames and across the gap."""
    spline = CubicSpline(boundary, np.eye(len(boundary)), bc_type="natural")
    return np.asarray(spline(inside))


def _sides(inside: FloatArray, boundary: FloatArray) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    return (
        np.flatnonzero(boundary < inside[0]),
        np.flatnonzero(boundary > inside[-1]),
    )


LENGTHS_32 = (0.04, 0.12, 0.4, 1.2)
LENGTHS_52 = (0.04, 0.1, 0.25, 0.6, 2.0)


def operators(inside: FloatArray, boundary: FloatArray) -> tuple[Operator, ...]:
    """Give all ways into a gap that its boundary allows.

    Parameters
    ----------
    inside, boundary
        (n_gap,) and (n_boundary,) s, ascending; the boundary may lie on one side only.
    """
    found = [Operator("ramp", ramp(inside, boundary))]
    before, after = _sides(inside, boundary)
    if len(before) > 1 and len(after) > 1:
        found.append(Operator("Hermite", hermite(inside, boundary)))
        found.append(Operator("cubic spline", cubic(inside, boundary)))
    for kernel, name, lengths in (
        (matern32, "Matérn 3/2", LENGTHS_32),
        (matern52, "Matérn 5/2", LENGTHS_52),
    ):
        for length in lengths:
            text = f"{name} of {length:g} s"
            found.append(Operator(text, krige(inside, boundary, kernel, length)))
            if length >= 0.1:
                found.append(
                    Operator(f"{text} about a mean", krige(inside, boundary, kernel, length, 0))
                )
    return tuple(found)
