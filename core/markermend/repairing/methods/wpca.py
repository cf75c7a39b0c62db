"""Weighted principal components, strategy R2."""

from typing import Annotated

from markermend.model import FloatArray
from markermend.params import Within
from markermend.registry import method
from markermend.repairing.pca import Settings, fill_r2
from markermend.repairing.problem import Problem
from markermend.repairing.window import window


@method(
    title="Weighted PCA (R2)",
    kinds=("gap", "noise", "step", "slow"),
    source="Ø. Gløersen and P. Federolf, PLoS ONE 11(3):e0152616, 2016, strategy R2",
)
def wpca(
    problem: Problem,
    *,
    sigma: Annotated[float, Within(20, 2000, "mm")] = 200.0,
    own_weight: Annotated[float, Within(0.001, 1)] = 0.02,
    reach: Annotated[float, Within(0, 2)] = 0.5,
    cumulative: Annotated[float, Within(0.5, 0.9999)] = 0.99,
) -> FloatArray:
    """Predict the marker from how all others have moved together with it.

    Parameters
    ----------
    sigma
        Scale of distance at which another marker's weight falls off.
    own_weight
        Weight of the marker itself.
    reach
        Markers with gaps of their own help within this share of the mean distance to all.
    cumulative
        Share of the singular values that the components kept must reach.

    Returns
    -------
    (len(span), n_dims) mm.

    Raises
    ------
    CannotRepair
        If no frame or no other marker is left to learn from.
    """
    return fill_r2(window(problem), Settings(sigma, own_weight, cumulative), reach)
