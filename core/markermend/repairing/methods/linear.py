"""Straight line between the edges."""

import numpy as np

from markermend.errors import CannotRepair
from markermend.model import FloatArray
from markermend.registry import method
from markermend.repairing.problem import Problem


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
    seen = np.flatnonzero(problem.seen[:, problem.marker])
    span = problem.span
    if not (len(seen) and seen[0] < span.start and seen[-1] >= span.stop):
        raise CannotRepair(
            f"{problem.labels[problem.marker]} is not seen on both sides of the span; "
            "choose a method that uses its neighbours."
        )
    frames = np.arange(span.start, span.stop)
    return np.column_stack(
        [np.interp(frames, seen, problem.own[seen, d]) for d in range(problem.n_dims)]
    )
