"""The ways to fill a gap of a short window whose other gaps are filled already."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from markermend.errors import CannotRepair
from markermend.model import FloatArray, runs
from markermend.repairing.blend.fixed import regress_and_krige
from markermend.repairing.blend.scene import BOUNDARY, Scene, survey
from markermend.repairing.kriging import cubic, hermite
from markermend.repairing.pca import Settings, fill_r2
from markermend.repairing.recovery import (
    Model,
    Recovery,
    by_components,
    interpolate_locally,
    recover,
    regress_by_kernel,
    regress_globally,
    regress_locally,
)
from markermend.repairing.window import Window

NEIGHBOURS = 10
RIDGE_MM2 = 10.0
CARRIERS = (3, 4, 6)
"""Numbers of neighbours that carry the frames of reference that are averaged over."""
DOUBT_MM = 10.0
"""A neighbour that was filled throughout the gap counts as less rigid by so much."""
ALL_AT_ONCE_S = (0.12, 0.4)
"""Gaps up to the first length are left as filled at once; from the second on, none of it is."""
LGRNN: tuple[Model, ...] = (regress_by_kernel,)
PMA: tuple[Model, ...] = (
    interpolate_locally,
    regress_locally,
    regress_by_kernel,
    regress_globally,
    by_components,
)
BESIDE = (0.4, 0.25)
"""Weights of LGRNN and PMA in long gaps beside the regression in local frames."""
WPCA, REACH = Settings(by_axis=False), 0.5
TURNING = Recovery(by_axis=False)
LEARNT = 5
"""The first so many ways learn from the neighbours; the last two know the marker alone."""


def ways(near: Window, filled: FloatArray) -> FloatArray:
    """Fill the span in every way.

    Parameters
    ----------
    near
        The window.
    filled
        (n_frames, n_markers, n_dims) mm: all its gaps filled at once.

    Returns
    -------
    (7, length, n_dims) mm: as filled at once, by regression in local frames, by LGRNN, PMA and
    WPCA on the filled neighbours, and by the marker's own cubic spline and its cubic of value and
    slope.  A way
    that does not apply is the same as the one before it.
    """
    own = filled[near.span.frames, near.marker]
    again = second_sweep(near, filled)
    by_frames = locally(near, again, CARRIERS)
    made = [own, own if by_frames is None else by_frames]
    known = again.copy()
    known[:, near.marker] = near.own
    closed = replace(near, positions=known)
    for way in (
        lambda: recover(closed, LGRNN, TURNING),
        lambda: recover(closed, PMA, TURNING),
        lambda: fill_r2(closed, WPCA, REACH),
    ):
        made.append(_or(way, made[-1]))
    return np.stack([*made, *_alone(near)])


def usual_weights(seconds: float) -> FloatArray:
    """Give the weights of `ways` that are known to be good for a gap of this length."""
    low, high = ALL_AT_ONCE_S
    once = float(np.clip((high - seconds) / (high - low), 0, 1))
    weights = np.zeros(7)
    weights[:2] = once, 1 - once
    if once == 0.0:
        weights[2:4] = BESIDE
    return np.asarray(weights / weights.sum())


def _or(way: Callable[[], FloatArray], other: FloatArray) -> FloatArray:
    try:
        made = way()
    except CannotRepair:
        return other
    return made if np.isfinite(made).all() else other


def _alone(near: Window) -> tuple[FloatArray, FloatArray]:
    """Carry the marker's own motion across: a cubic spline, and the cubic of value and slope."""
    inside = np.arange(near.span.start, near.span.stop)
    seen = np.flatnonzero(near.seen[:, near.marker])
    before, after = seen[seen < inside[0]][-BOUNDARY:], seen[seen > inside[-1]][:BOUNDARY]
    edges = np.concatenate([before, after])
    if min(len(before), len(after)) < 2:
        held = np.column_stack([np.interp(inside, seen, axis[seen]) for axis in near.own.T])
        return held, held
    when, known = (inside / near.rate, edges / near.rate), near.own[edges]
    return cubic(*when) @ known, hermite(*when) @ known


def second_sweep(near: Window, filled: FloatArray) -> FloatArray:
    """Fill the gaps of the closest neighbours again where they meet the span."""
    again = filled.copy()
    around = doubting(near, filled)
    for m in around.order[:NEIGHBOURS]:
        for gap in runs(~near.seen[:, m]):
            if not gap.overlaps(near.span):
                continue
            made = locally(replace(near, marker=int(m), span=gap), filled, (4,))
            if made is not None:
                again[gap.frames, m] = made
    return again


def locally(near: Window, filled: FloatArray, carriers: tuple[int, ...]) -> FloatArray | None:
    """Regress one gap on filled neighbours; None where they define no frame of reference."""
    around = doubting(near, filled)
    if len(around.order) < near.n_dims or around.rows.sum() < near.n_dims:
        return None
    try:
        found = [
            regress_and_krige(around, NEIGHBOURS, count, RIDGE_MM2)
            for count in sorted({min(count, len(around.order)) for count in carriers})
        ]
    except CannotRepair:
        return None
    return np.asarray(np.mean(found, axis=0))


def doubting(near: Window, filled: FloatArray) -> Scene:
    """Rank the filled neighbours, those last that were filled where the gap is."""
    positions = filled.copy()
    positions[:, near.marker] = near.own
    around = survey(replace(near, positions=positions))
    gone: FloatArray = 1 - near.seen[near.span.frames][:, around.order].mean(axis=0)
    spread = np.hypot(around.spread, DOUBT_MM * gone)
    order: NDArray[np.intp] = np.argsort(spread, kind="stable")
    return Scene(
        around.window,
        around.order[order],
        spread[order],
        around.neighbours[:, order],
        around.there,
    )
