"""Local generalised regression neural network."""

from typing import Annotated

from markermend.model import FloatArray
from markermend.params import Within
from markermend.registry import method
from markermend.repairing.problem import Problem
from markermend.repairing.recovery import Recovery, recover, regress_by_kernel
from markermend.repairing.window import window


@method(
    title="Local regression network (LGRNN)",
    kinds=("gap", "noise", "step", "slow"),
    source="M. Tits, J. Tilmanne, T. Dutoit, PLoS ONE 13(7):e0199744, 2018",
)
def lgrnn(
    problem: Problem,
    *,
    smoothing: Annotated[float, Within(0, 0.5, "s")] = 0.07,
    quantile: Annotated[float, Within(0, 0.2)] = 0.01,
    spread: Annotated[float, Within(0.05, 3)] = 0.3,
) -> FloatArray:
    """Recall where the marker was when its neighbours' triangle looked alike.

    Parameters
    ----------
    smoothing
        Duration that the neighbours and the result are smoothed over.
    quantile
        Distances to the three neighbours beyond this quantile, on either side, are pulled back.
    spread
        Width of the kernel, in standard deviations of the triangle's shape.

    Returns
    -------
    (len(span), n_dims) mm.

    Raises
    ------
    CannotRepair
        If fewer than three neighbours are seen throughout, stand in one line, or are hardly ever
        seen together with the marker.
    """
    return recover(window(problem), [regress_by_kernel], Recovery(smoothing, quantile, spread))
