"""Eigenspace of trajectories, learnt from a training set."""

from typing import Annotated

import numpy as np

from markermend.model import FloatArray
from markermend.params import Within
from markermend.registry import method
from markermend.repairing.eigenspace import map_rows, piece
from markermend.repairing.problem import Problem
from markermend.repairing.window import window


@method(
    title="Learnt trajectories (Li, Eq. 8)",
    kinds=("gap", "noise", "step", "slow"),
    source="Z. Li, H. Yu, H. D. Kieu, T. L. Vuong, J. J. Zhang, IEEE Access 8, 2020, Eq. 5 to 8",
)
def li_eq8(
    problem: Problem,
    *,
    context: Annotated[int, Within(5, 500, "frames")] = 50,
    cumulative: Annotated[float, Within(0.5, 1)] = 0.9999,
) -> FloatArray:
    """Go on as other pieces of trajectories have gone on, in other takes or the rest of this one.

    No other marker need be seen in the span.

    Parameters
    ----------
    context
        Frames before and after the span that the piece holds.
    cumulative
        Share of the energy that the eigenvectors kept must hold.

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
    filled = map_rows(around.training.T, around.column.T, around.missing, cumulative).T
    return np.asarray(filled[around.inside] + around.mean)
