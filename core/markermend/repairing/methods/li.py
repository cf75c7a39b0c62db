"""Local interpolation."""

from typing import Annotated

from markermend.model import FloatArray
from markermend.params import Within
from markermend.registry import method
from markermend.repairing.problem import Problem
from markermend.repairing.recovery import Recovery, interpolate_locally, recover
from markermend.repairing.window import window


@method(
    title="Local interpolation (LI)",
    kinds=("gap", "noise", "step", "slow"),
    source="M. Tits, J. Tilmanne, T. Dutoit, PLoS ONE 13(7):e0199744, 2018",
)
def li(
    problem: Problem,
    *,
    smoothing: Annotated[float, Within(0, 0.5, "s")] = 0.07,
    quantile: Annotated[float, Within(0, 0.2)] = 0.01,
) -> FloatArray:
    """Go straight from edge to edge in the local frame of the three most rigid neighbours.

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
        If fewer than three neighbours are seen throughout, or they stand in one line.
    """
    return recover(window(problem), [interpolate_locally], Recovery(smoothing, quantile))
