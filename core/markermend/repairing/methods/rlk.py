"""Regress on the neighbours in a local frame, krige the residual."""

from typing import Annotated

import numpy as np

from markermend.errors import CannotRepair
from markermend.model import FloatArray
from markermend.params import Within
from markermend.registry import method
from markermend.repairing.blend.ridge import features, ridge
from markermend.repairing.blend.scene import scene
from markermend.repairing.kriging import krige, matern32
from markermend.repairing.problem import Problem


@method(
    title="Regress locally, krige (RLK)",
    kinds=("gap", "noise", "step", "slow", "peak"),
    source="MarkerMend: ridge regression in a Kabsch frame, residual by kriging (Matérn 3/2)",
)
def rlk(
    problem: Problem,
    *,
    neighbours: Annotated[int, Within(3, 60, "markers")] = 10,
    frame_markers: Annotated[int, Within(3, 12, "markers")] = 4,
    ridge_mm2: Annotated[float, Within(0.001, 100, "mm²")] = 1.0,
    length: Annotated[float, Within(0.02, 5, "s")] = 0.4,
) -> FloatArray:
    """Predict the marker from its neighbours' motion in their own frame, and meet both ends.

    The most rigid neighbours carry a frame of reference.  In it, the marker is regressed on the
    coordinates of its neighbours (ridge regression over the frames in which it is seen), and what
    the regression leaves over at the edges of the span is kriged into it, so that position and
    slope meet the recording.

    Parameters
    ----------
    problem
        The span.
    neighbours
        How many neighbours the marker is regressed on, the most rigid first.
    frame_markers
        How many of them carry the frame of reference.
    ridge_mm2
        Weight of the ridge: the motion of a neighbour that counts as noise, as a variance.
    length
        Length of the correlation of the residual.

    Returns
    -------
    (len(span), n_dims) mm.

    Raises
    ------
    CannotRepair
        If too few neighbours are seen throughout the span, or the marker itself is seen too
        rarely to learn from.
    """
    around = scene(problem, least=problem.n_dims)
    rows = np.flatnonzero(around.rows)
    if len(rows) < 10:
        raise CannotRepair(
            f"{around.window.label} and its neighbours are seen together in {len(rows)} frames "
            "only; choose pchip."
        )
    frames = around.frames_of(frame_markers)
    span = around.window.span
    z = features(around, frames, neighbours)
    y = frames.to_local(around.window.own)
    predicted = ridge(z[rows], y[rows], ridge_mm2)(z)
    inside = np.arange(span.start, span.stop)
    residual = np.zeros((len(span), problem.n_dims))
    edge = around.boundary
    if len(edge):
        weights = krige(inside / problem.rate, edge / problem.rate, matern32, length)
        residual = weights @ (y[edge] - predicted[edge])
    return frames.at(span.frames).to_world(predicted[span.frames] + residual)
