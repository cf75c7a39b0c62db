"""Eigenspace of postures, learnt from a training set."""

from typing import Annotated

import numpy as np

from markermend.errors import CannotRepair
from markermend.model import FloatArray
from markermend.params import Within
from markermend.registry import method
from markermend.repairing.eigenspace import map_rows, sources, whole_rows
from markermend.repairing.problem import Problem
from markermend.repairing.window import window

STEADY = 0.9
"""Share of the window's frames in which a neighbour must be seen to take part."""


@method(
    title="Learnt postures (Li, Eq. 4)",
    kinds=("gap", "noise", "step", "slow"),
    source="Z. Li, H. Yu, H. D. Kieu, T. L. Vuong, J. J. Zhang, IEEE Access 8, 2020, Eq. 1 to 4",
)
def li_eq4(
    problem: Problem, *, cumulative: Annotated[float, Within(0.5, 1)] = 0.99999
) -> FloatArray:
    """Map incomplete postures to complete ones, as learnt from other takes or the rest of this one.

    Postures are counted from the mean of the markers that are seen throughout the span.

    Parameters
    ----------
    cumulative
        Share of the energy that the eigenvectors kept must hold.

    Returns
    -------
    (len(span), n_dims) mm.

    Raises
    ------
    CannotRepair
        If a take to learn from lacks a marker, or too few frames show them all.
    """
    cut = window(problem)
    others = [m for m in cut.others if cut.seen[:, m].mean() >= STEADY]
    if not others:
        raise CannotRepair(
            f"No other marker is seen nearly always around the span of {cut.label}; choose a "
            "method that needs none, such as pchip."
        )
    labels = [cut.labels[m] for m in (cut.marker, *others)]
    learnt = whole_rows(sources(problem, cut, labels))
    if len(learnt) < 10:
        raise CannotRepair(
            f"Only {len(learnt)} frames show all {len(labels)} markers that would be learnt from; "
            "give more takes to learn from."
        )
    n = cut.n_dims
    middle = cut.positions[cut.span.frames][:, others].mean(axis=1)
    here = np.concatenate([middle[:, None], cut.positions[cut.span.frames][:, others]], axis=1)
    postures = (learnt - learnt[:, 1:].mean(axis=1, keepdims=True)).reshape(len(learnt), -1)
    mean = postures.mean(axis=0)
    rows = (here - middle[:, None]).reshape(len(here), -1) - mean
    filled = map_rows(postures - mean, rows, np.arange(rows.shape[1]) < n, cumulative) + mean
    return np.asarray(filled[:, :n] + middle)
