"""Truncated nuclear norm."""

from functools import partial
from typing import Annotated

from markermend.params import Within
from markermend.registry import method
from markermend.repairing.lowrank import by_truncated_norm, fill_by_matrix
from markermend.repairing.problem import Outcome, Problem


@method(
    title="Truncated nuclear norm",
    kinds=("gap", "noise", "step", "slow"),
    source="W. Hu et al., IEEE Signal Process. Lett. 25:258, 2018; Y. Hu et al., IEEE TPAMI "
    "35:2117, 2013",
)
def tnn(
    problem: Problem,
    *,
    rank: Annotated[int, Within(1, 60)] = 3,
    markers: Annotated[int, Within(1, 300)] = 10,
    context: Annotated[int, Within(50, 3000, "frames")] = 600,
    rounds: Annotated[int, Within(1, 50)] = 6,
    iterations: Annotated[int, Within(10, 500)] = 50,
    tolerance: Annotated[float, Within(1e-8, 0.1)] = 1e-3,
) -> Outcome:
    """Complete the matrix of trajectories so that a few patterns explain nearly all of it.

    Parameters
    ----------
    rank
        Patterns that may be as large as they like.
    markers
        Other markers that the matrix holds, the most rigidly tied ones; with ten it is as large
        as the smaller set of Kamali et al.
    context
        Frames around the span that are looked at, or three times the span if that is more.
    rounds
        Times that these patterns are chosen anew.
    iterations
        Most steps of the alternating direction method in a round.
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
        partial(
            by_truncated_norm,
            rank=rank,
            rounds=rounds,
            iterations=iterations,
            tolerance=tolerance,
        ),
    )
