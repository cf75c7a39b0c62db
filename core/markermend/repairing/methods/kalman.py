"""Kalman smoother in a subspace."""

from typing import Annotated

from markermend.model import FloatArray
from markermend.params import Within
from markermend.registry import method
from markermend.repairing.problem import Problem
from markermend.repairing.subspace import fill_by_smoothing
from markermend.repairing.window import window


@method(
    title="Kalman smoother in a subspace",
    kinds=("gap", "noise", "step", "slow"),
    source="M. Burke and J. Lasenby, J. Biomech. 49:1854, 2016",
)
def kalman(
    problem: Problem,
    *,
    cumulative: Annotated[float, Within(0.5, 0.999999)] = 0.9999,
    context: Annotated[int, Within(100, 3000, "frames")] = 1000,
) -> FloatArray:
    """Follow the few patterns that explain all markers, and read this one off them.

    What is left at the edges is taken away linearly.

    Parameters
    ----------
    cumulative
        Share of the variance that the patterns must explain.
    context
        Frames around the span that the patterns are learnt from.

    Returns
    -------
    (len(span), n_dims) mm.

    Raises
    ------
    CannotRepair
        If no neighbour is seen nearly always, or too few frames show them together.
    """
    return fill_by_smoothing(window(problem, context), cumulative)
