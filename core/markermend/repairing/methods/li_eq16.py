"""Eigenspace of trajectories for frames in which nothing is seen."""

from typing import Annotated

import numpy as np

from markermend.model import FloatArray
from markermend.params import OneOf, Within
from markermend.registry import method
from markermend.repairing.eigenspace import piece, weighted_rows
from markermend.repairing.problem import Problem
from markermend.repairing.window import window

RANKS = (1, 2, 3, 4, 6, 8, 11, 16, 23, 32)
"""Numbers of eigenvectors that are tried where none is given."""


@method(
    title="Learnt blackouts (Li, Eq. 16)",
    kinds=("gap", "noise", "step", "slow"),
    source="Z. Li, H. Yu, H. D. Kieu, T. L. Vuong, J. J. Zhang, IEEE Access 8, 2020, Eq. 9 to 16",
)
def li_eq16(
    problem: Problem,
    *,
    context: Annotated[int, Within(5, 500, "frames")] = 50,
    rank: Annotated[int, Within(0, 300)] = 0,
    weighting: Annotated[str, OneOf("trained", "none")] = "trained",
) -> FloatArray:
    """Bridge a blackout by the least-squares fit of learnt trajectories to what is seen around it.

    No other marker need be seen in the span.

    Parameters
    ----------
    context
        Frames before and after the span that the piece holds.
    rank
        Eigenvectors kept; 0 lets the training set choose.
    weighting
        Whether frames near the blackout count more where the training set says so (Eq. 13), or
        all alike.

    Returns
    -------
    (len(span), n_dims) mm.

    Raises
    ------
    CannotRepair
        If the marker is not seen near the span, a take to learn from lacks a marker, or none is
        long enough.
    """
    around = piece(problem, window(problem), context)
    weights = around.weights if weighting == "trained" else around.weights[:1]
    ranks = (rank,) if rank else RANKS
    filled = weighted_rows(around.training, around.column, around.missing, ranks, weights)
    return np.asarray(filled[around.inside] + around.mean)
