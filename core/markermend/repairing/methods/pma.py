"""Probabilistic model averaging with soft skeleton constraints."""

from typing import Annotated

from markermend.model import FloatArray
from markermend.params import Within
from markermend.registry import method
from markermend.repairing.problem import Problem
from markermend.repairing.recovery import (
    Recovery,
    by_components,
    interpolate_locally,
    recover,
    regress_by_kernel,
    regress_globally,
    regress_locally,
)
from markermend.repairing.window import window


@method(
    title="Model averaging (PMA)",
    kinds=("gap", "noise", "step", "slow"),
    source="M. Tits, J. Tilmanne, T. Dutoit, PLoS ONE 13(7):e0199744, 2018",
)
def pma(
    problem: Problem,
    *,
    smoothing: Annotated[float, Within(0, 0.5, "s")] = 0.07,
    quantile: Annotated[float, Within(0, 0.2)] = 0.01,
    spread: Annotated[float, Within(0.05, 3)] = 0.3,
    loosest: Annotated[float, Within(1, 1000, "mm")] = 1000.0,
) -> FloatArray:
    """Average five models by how usual the distances are that they give.

    The models are local interpolation, local polynomial regression, local regression network,
    global linear regression and weighted PCA; one that does not apply is left out.

    Parameters
    ----------
    smoothing
        Duration that the neighbours, the models and the result are smoothed over.
    quantile
        Distances to the three neighbours beyond this quantile, on either side, are pulled back.
    spread
        Width of the network's kernel, in standard deviations of the triangle's shape.
    loosest
        Largest standard deviation of the distance with which a marker enters the linear model.

    Returns
    -------
    (len(span), n_dims) mm.

    Raises
    ------
    CannotRepair
        If fewer than three neighbours are seen throughout, or they stand in one line.
    """
    models = [
        interpolate_locally,
        regress_locally,
        regress_by_kernel,
        regress_globally,
        by_components,
    ]
    return recover(window(problem), models, Recovery(smoothing, quantile, spread, loosest))
