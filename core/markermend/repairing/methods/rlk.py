"""Regress on the neighbours in a local frame, krige the residual."""

from typing import Annotated

from markermend.errors import CannotRepair
from markermend.model import KINDS, FloatArray
from markermend.params import Within
from markermend.registry import method
from markermend.repairing.blend.fixed import (
    FRAME_MARKERS,
    LENGTH_S,
    NEIGHBOURS,
    RIDGE_MM2,
    regress_and_krige,
)
from markermend.repairing.blend.scene import scene
from markermend.repairing.problem import Problem

LEAST_ROWS = 10


@method(
    title="Regress locally, krige (RLK)",
    kinds=KINDS,
    source="MarkerMend: ridge regression in a Kabsch frame, residual by kriging (Matérn 3/2)",
)
def rlk(
    problem: Problem,
    *,
    neighbours: Annotated[int, Within(3, 60, "markers")] = NEIGHBOURS,
    frame_markers: Annotated[int, Within(3, 12, "markers")] = FRAME_MARKERS,
    ridge_mm2: Annotated[float, Within(0.001, 100, "mm²")] = RIDGE_MM2,
    length: Annotated[float, Within(0.02, 5, "s")] = LENGTH_S,
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
    together = int(around.rows.sum())
    if together < LEAST_ROWS:
        raise CannotRepair(
            f"{around.window.label} and its neighbours are seen together in {together} frames "
            "only; choose pchip."
        )
    return regress_and_krige(around, neighbours, frame_markers, ridge_mm2, length)
