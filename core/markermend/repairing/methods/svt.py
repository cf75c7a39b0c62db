"""Singular value thresholding."""

from functools import partial
from typing import Annotated

from markermend.params import Within
from markermend.registry import method
from markermend.repairing.lowrank import by_truncated_norm, fill_by_matrix
from markermend.repairing.problem import Outcome, Problem


@method(
    title="Singular value thresholding",
    kinds=("gap", "noise", "step", "slow"),
    source="J.-F. Cai, E. Candès, Z. Shen, SIAM J. Optim. 20:1956, 2010; on markers: R. Lai, "
    "P. Yuen, K. Lee, Eurographics 2011",
)
def svt(
    problem: Problem,
    *,
    markers: Annotated[int, Within(1, 300)] = 10,
    context: Annotated[int, Within(50, 3000, "frames")] = 600,
    iterations: Annotated[int, Within(10, 1000)] = 100,
    tolerance: Annotated[float, Within(1e-8, 0.1)] = 1e-3,
) -> Outcome:
    """Complete the matrix of trajectories by the smallest sum of singular values.

    Parameters
    ----------
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
    return fill_by_matrix(
        problem,
        context,
        markers,
        partial(by_truncated_norm, rank=0, rounds=1, iterations=iterations, tolerance=tolerance),
    )
