"""Fill a gap where little is seen: all gaps of a short window at once, then locally (SHORT)."""

import numpy as np

from markermend.model import FloatArray, Span
from markermend.repairing.blend.rehearsal import Rehearsed, rehearsed
from markermend.repairing.blend.scene import Scene
from markermend.repairing.blend.ways import doubting, usual_weights, ways
from markermend.repairing.shortwindow import fill_at_once
from markermend.repairing.window import Window

FRAMES = 480
"""Frames around the gap that are filled at once."""
MARKERS = 60
"""Markers, the most complete first, that are filled at once."""
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


def short(cut: Window) -> tuple[FloatArray, Rehearsed | None]:
    """Fill the span from all that is seen in a short window around it.

    All gaps of the window are filled at once by a matrix normal model.  Then the gaps of the
    marker's neighbours are filled again by regression in a local frame, and last its own in
    several ways, which are weighed by how they fill other gaps of the same length.

    Returns
    -------
    (length of the span, n_dims) mm, and what is known of its error, if anything is.
    """
    near = _nearer(cut)
    filled = fill_at_once(near.positions, near.rate)
    made = ways(near, filled)
    weights = usual_weights(len(near.span) / near.rate)
    tried = rehearsed(near, made, weights)
    if tried is not None:
        return tried.values, tried
    return np.tensordot(weights, made, axes=1), None


def with_filled_neighbours(cut: Window) -> Scene:
    """Give the scene around the span in which all gaps of the neighbours are filled."""
    near = _nearer(cut)
    return doubting(near, fill_at_once(near.positions, near.rate))


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
