"""Straight line between the edges."""

import numpy as np

from markermend.model import FloatArray
from markermend.registry import method
from markermend.repairing.problem import Problem
from markermend.repairing.window import both_sides


@method(title="Linear", kinds=("gap", "peak"), source="numpy.interp")
def linear(problem: Problem) -> FloatArray:
    """Join the last frame before the span and the first after it by a straight line.

    Returns
    -------
    (len(span), n_dims) mm.

    Raises
    ------
    CannotRepair
        If the marker is not seen on both sides of the span.
    """
    edges = both_sides(problem, 1)
    frames = np.arange(problem.span.start, problem.span.stop)
    return np.column_stack([np.interp(frames, edges, axis) for axis in problem.own[edges].T])
