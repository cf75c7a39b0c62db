"""Regression and kriging with settings known to be good, where nothing can be tested."""

import numpy as np

from markermend.errors import CannotRepair
from markermend.model import FloatArray
from markermend.repairing.blend.ridge import features, ridge
from markermend.repairing.blend.scene import Scene
from markermend.repairing.kriging import cubic, hermite, krige, matern32

NEIGHBOURS = 20
FRAME_MARKERS = 4
RIDGE_MM2 = 0.1
LENGTH_S = 0.4
BENT_S = 0.6
"""Gaps up to here are crossed by a spline that keeps the acceleration at its edges."""


def regress_and_krige(
    around: Scene,
    neighbours: int = NEIGHBOURS,
    frame_markers: int = FRAME_MARKERS,
    ridge_mm2: float = RIDGE_MM2,
    length_s: float = LENGTH_S,
) -> FloatArray:
    """Predict the marker from its neighbours in their frame, and krige the residual (RLK).

    Parameters
    ----------
    around
        The marker and its neighbours; at least as many as the space has dimensions.
    neighbours, frame_markers, ridge_mm2, length_s
        As in `markermend.repairing.methods.rlk`.

    Returns
    -------
    (length of the span, n_dims) mm.
    """
    cut = around.window
    frames = around.frames_of(frame_markers)
    rows, edge = np.flatnonzero(around.rows), around.boundary
    z = features(around, frames, neighbours)
    y = frames.to_local(cut.own)
    predict = ridge(z[rows], y[rows], ridge_mm2)
    inside = np.arange(cut.span.start, cut.span.stop)
    local = predict(z[inside])
    if len(edge):
        weights = krige(inside / cut.rate, edge / cut.rate, matern32, length_s)
        local = local + weights @ (y[edge] - predict(z[edge]))
    return frames.at(cut.span.frames).to_world(local)


def between_edges(around: Scene) -> FloatArray:
    """Join both edges by a cubic spline, or over longer gaps by the cubic of value and slope.

    Raises
    ------
    CannotRepair
        If the marker is not seen at both edges.
    """
    cut = around.window
    edge = around.boundary
    if not ((edge < cut.span.start).any() and (edge >= cut.span.stop).any()):
        raise CannotRepair(
            f"{cut.label} and its neighbours are not seen together on both sides of the span; "
            "choose pchip, or fill its neighbours first."
        )
    inside = np.arange(cut.span.start, cut.span.stop)
    way = cubic if len(cut.span) <= BENT_S * cut.rate else hermite
    return way(inside / cut.rate, edge / cut.rate) @ cut.own[edge]
