"""Group-sparse and low rank."""

from typing import Annotated

from markermend.params import Within
from markermend.registry import method
from markermend.repairing.lowrank import fill_by_matrix, sparse_solver
from markermend.repairing.problem import Outcome, Problem


@method(
    title="Group-sparse and low rank (GS-LR)",
    kinds=("gap", "noise", "step", "slow"),
    source="K. Kamali et al., Sensors 20(16):4525, 2020, Eq. 4 to 10, 13 and 14",
)
def gslr(
    problem: Problem,
    *,
    weight: Annotated[float, Within(0, 100)] = 0.03,
    cutoff: Annotated[float, Within(0.1, 100, "Hz")] = 6.0,
    high: Annotated[float, Within(1, 10000)] = 100.0,
    markers: Annotated[int, Within(1, 300)] = 10,
    context: Annotated[int, Within(50, 3000, "frames")] = 600,
    iterations: Annotated[int, Within(10, 1000)] = 300,
    tolerance: Annotated[float, Within(1e-8, 0.1)] = 1e-3,
) -> Outcome:
    """Complete trajectories so that few patterns and the same few frequencies explain them.

    Made for periodic motion, such as walking on a treadmill; the window should hold a few cycles.

    Parameters
    ----------
    weight
        The paper's lambda: what a frequency costs beside a pattern. It has no unit, as both sums
        are in mm.
    cutoff
        Frequency from which on it costs more.
    high
        How many times more.
    markers
        Other markers that the matrix holds, the most rigidly tied ones; with ten it is as large
        as the smaller set of Kamali et al.
    context
        Frames around the span that are looked at, or three times the span if that is more.
    iterations
        Most steps of the alternating direction method.
    tolerance
        Residual, as a share of the data's norm, at which it stops.

    Returns
    -------
    (len(span), n_dims) mm, with a note where it did not converge.

    Raises
    ------
    CannotRepair
        If the marker, or every other one, is not seen around the span.
    """
    solve = sparse_solver(problem.rate, weight, cutoff, high, True, iterations, tolerance)
    return fill_by_matrix(problem, context, markers, solve)
