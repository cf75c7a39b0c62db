"""Weighted principal components, strategy R1."""

from typing import Annotated

from markermend.model import FloatArray
from markermend.params import Within
from markermend.registry import method
from markermend.repairing.pca import Settings, fill_r1
from markermend.repairing.problem import Problem
from markermend.repairing.window import window


@method(
    title="Weighted PCA (R1)",
    kinds=("gap", "noise", "step", "slow"),
    source="Ø. Gløersen and P. Federolf, PLoS ONE 11(3):e0152616, 2016, strategy R1",
)
def pca_r1(
    problem: Problem,
    *,
    sigma: Annotated[float, Within(20, 2000, "mm")] = 200.0,
    own_weight: Annotated[float, Within(0.001, 1)] = 0.02,
    cumulative: Annotated[float, Within(0.5, 0.9999)] = 0.99,
) -> FloatArray:
    """Predict all markers with gaps at once from those without any.

    Parameters
    ----------
    sigma
        Scale of distance at which another marker's weight falls off.
    own_weight
        Weight of the markers that have gaps.
    cumulative
        Share of the singular values that the components kept must reach.

    Returns
    -------
    (len(span), n_dims) mm.

    Raises
    ------
    CannotRepair
        If no frame shows every marker.
    """
    return fill_r1(window(problem), Settings(sigma, own_weight, cumulative))
