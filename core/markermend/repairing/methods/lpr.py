"""Local polynomial regression."""

from typing import Annotated

from markermend.model import FloatArray
from markermend.params import Within
from markermend.registry import method
from markermend.repairing.problem import Problem
from markermend.repairing.recovery import Recovery, recover, regress_locally
from markermend.repairing.window import window


@method(
    title="Local polynomial regression (LPR)",
    kinds=("gap", "noise", "step", "slow"),
    source="M. Tits, J. Tilmanne, T. Dutoit, PLoS ONE 13(7):e0199744, 2018",
)
def lpr(
    problem: Problem,
    *,
    smoothing: Annotated[float, Within(0, 0.5, "s")] = 0.07,
    quantile: Annotated[float, Within(0, 0.2)] = 0.01,
) -> FloatArray:
    """Tell the marker from the shape of its neighbours' triangle, by a polynomial.

    Parameters
    ----------
    smoothing
        Duration that the neighbours and the result are smoothed over.
    quantile
        Distances to the three neighbours beyond this quantile, on either side, are pulled back.

    Returns
    -------
    (len(span), n_dims) mm.

    Raises
    ------
    CannotRepair
        If fewer than three neighbours are seen throughout, stand in one line, or are hardly ever
        seen together with the marker.
    """
    return recover(window(problem), [regress_locally], Recovery(smoothing, quantile))
