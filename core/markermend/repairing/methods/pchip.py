"""Monotone cubic between the edges."""

from typing import Annotated

import numpy as np
from scipy.interpolate import PchipInterpolator

from markermend.model import FloatArray
from markermend.params import Within
from markermend.registry import method
from markermend.repairing.problem import Problem
from markermend.repairing.window import both_sides


@method(
    title="Monotone cubic",
    kinds=("peak", "gap"),
    source="F. N. Fritsch and R. E. Carlson, SIAM J. Numer. Anal. 17:238, 1980",
)
def pchip(problem: Problem, *, context: Annotated[int, Within(2, 60, "frames")] = 4) -> FloatArray:
    """Join both edges by a cubic that never overshoots, axis by axis.

    Parameters
    ----------
    context
        Seen frames on each side that shape the ends; from three on, more of them change nothing.

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
    return np.asarray(PchipInterpolator(knots, problem.own[knots])(frames))
