"""Fill a gap where little is seen: all gaps of a short window at once, then locally (SHORT)."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from markermend.errors import CannotRepair
from markermend.model import FloatArray, Span, runs
from markermend.repairing.blend.fixed import regress_and_krige
from markermend.repairing.blend.scene import Scene, survey
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
from markermend.repairing.shortwindow import fill_at_once
from markermend.repairing.window import Window

FRAMES = 480
"""Frames around the gap that are filled at once."""
MARKERS = 60
"""Markers, the most complete first, that are filled at once."""
NEIGHBOURS = 10
RIDGE_MM2 = 10.0
CARRIERS = (3, 4, 6)
"""Numbers of neighbours that carry the frames of reference that are averaged over."""
DOUBT_MM = 10.0
"""A neighbour that was filled throughout the gap counts as less rigid by so much."""
ALL_AT_ONCE_S = (0.12, 0.4)
"""Gaps up to the first length are left as filled at once; from the second on, none of it is."""
EXPERTS: tuple[tuple[tuple[Model, ...], float], ...] = (
    ((regress_by_kernel,), 0.4),
    (
        (interpolate_locally, regress_locally, regress_by_kernel, regress_globally, by_components),
        0.25,
    ),
)
"""LGRNN and PMA, and their weights in long gaps beside the regression in local frames."""
ENOUGH_S = (0.9, 3.0)
"""Durations in which the marker is seen: up to the first SHORT has all the weight, from the
second on none."""


def share_of_tested(seen: int, length: int, rate: float) -> float:
    """Give the weight, 0 to 1, of a mix tested on pseudo-gaps against SHORT.

    Parameters
    ----------
    seen
        Frames in which the marker is seen.
    length
        Frames of the gap.
    rate
        Hz.
    """
    low, high = ENOUGH_S
    if not seen:
        return 0.0
    learnt = np.clip(np.log(seen / (low * rate)) / np.log(high / low), 0, 1)
    return float(learnt * np.clip((seen / length - 1) / 2, 0, 1))


def short(cut: Window) -> FloatArray:
    """Fill the span from all that is seen in a short window around it.

    All gaps of the window are filled at once by a matrix normal model.  Then the gaps of the
    marker's neighbours, and last its own, are filled again by regression in a local frame.

    Returns
    -------
    (length of the span, n_dims) mm.
    """
    near = _nearer(cut)
    filled = fill_at_once(near.positions, near.rate)
    own = filled[near.span.frames, near.marker]
    low, high = ALL_AT_ONCE_S
    weight = float(np.clip((high - len(near.span) / near.rate) / (high - low), 0, 1))
    if weight == 1.0:
        return own
    filled = _second_sweep(near, filled)
    locally = _locally(near, filled, CARRIERS)
    if locally is None:
        return own
    if weight == 0.0:
        locally = _averaged(near, filled, locally)
    return np.asarray(weight * own + (1 - weight) * locally)


def with_filled_neighbours(cut: Window) -> Scene:
    """Give the scene around the span in which all gaps of the neighbours are filled."""
    near = _nearer(cut)
    return _doubting(near, fill_at_once(near.positions, near.rate))


def _nearer(cut: Window) -> Window:
    """Keep the frames around the span, and the markers that are seen there most."""
    size = min(max(FRAMES, 3 * len(cut.span)), cut.n_frames)
    start = cut.span.start - (size - len(cut.span)) // 2
    start = min(max(start, 0), cut.n_frames - size)
    positions = cut.positions[start : start + size]
    seen = np.isfinite(positions[:, :, 0]).sum(axis=0)
    seen[cut.marker] = size + 1
    chosen = np.sort(np.argsort(-seen, kind="stable")[:MARKERS])
    chosen = chosen[seen[chosen] > 0]
    return Window(
        positions=positions[:, chosen],
        marker=int(np.flatnonzero(chosen == cut.marker)[0]),
        span=Span(cut.span.start - start, cut.span.stop - start),
        start=cut.start + start,
        rate=cut.rate,
        labels=tuple(cut.labels[i] for i in chosen),
    )


def _second_sweep(near: Window, filled: FloatArray) -> FloatArray:
    """Fill the gaps of the closest neighbours again where they meet the span."""
    again = filled.copy()
    around = _doubting(near, filled)
    for m in around.order[:NEIGHBOURS]:
        for gap in runs(~near.seen[:, m]):
            if not gap.overlaps(near.span):
                continue
            locally = _locally(replace(near, marker=int(m), span=gap), filled, (4,))
            if locally is not None:
                again[gap.frames, m] = locally
    return again


def _locally(near: Window, filled: FloatArray, carriers: tuple[int, ...]) -> FloatArray | None:
    """Regress one gap on filled neighbours; None where they define no frame of reference."""
    around = _doubting(near, filled)
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


def _averaged(near: Window, filled: FloatArray, locally: FloatArray) -> FloatArray:
    """Average a long gap with two models that keep the distances seen (Tits et al. 2018)."""
    positions = filled.copy()
    positions[:, near.marker] = near.own
    again = replace(near, positions=positions)
    total, weights = locally, 1.0
    for models, weight in EXPERTS:
        try:
            total = total + weight * recover(again, models, Recovery())
        except CannotRepair:
            continue
        weights += weight
    return total / weights


def _doubting(near: Window, filled: FloatArray) -> Scene:
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
