"""Cubic spline between the edges."""

from typing import Annotated

import numpy as np
from scipy.interpolate import CubicSpline

from markermend.model import FloatArray
from markermend.params import Within
from markermend.registry import method
from markermend.repairing.problem import Problem
from markermend.repairing.window import both_sides


@method(
    title="Cubic spline",
    kinds=("gap", "peak"),
    source="C. de Boor, A Practical Guide to Splines, 1978; scipy.interpolate.CubicSpline",
)
def spline(
    problem: Problem, *, context: Annotated[int, Within(2, 200, "frames")] = 40
) -> FloatArray:
    """Join both edges by a cubic spline, smooth in position, velocity and acceleration.

    Parameters
    ----------
    context
        Seen frames on each side that the spline passes through.

    Returns
    -------
    (len(span), n_dims) mm.

    Raises
    ------
    CannotRepair
        If the marker is not seen on both sides of the span.
    """
    knots = both_sides(problem, context)
    frames = np.arange(problem.span.start, problem.span.stop)
    return np.asarray(CubicSpline(knots, problem.own[knots])(frames))
