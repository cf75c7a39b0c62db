"""Subtract a step."""

from typing import Annotated

import numpy as np

from markermend.errors import CannotRepair
from markermend.params import Within
from markermend.registry import method
from markermend.repairing.artefacts import recorded_around, second_differences, usual_curvature
from markermend.repairing.problem import Outcome, Problem


@method(
    title="Subtract the step",
    kinds=("step",),
    source="MarkerMend: least squares of second differences, a = (D2h·D2x)/(D2h·D2h)",
)
def unstep(
    problem: Problem,
    *,
    significance: Annotated[float, Within(0, 20)] = 3.0,
    misfit: Annotated[float, Within(0.01, 1)] = 0.5,
) -> Outcome:
    """Find the height of a step by the jumps at its edges, and take it away.

    The motion within the span stays as it was recorded.

    Parameters
    ----------
    significance
        An axis stays as it is unless its height is so many times its uncertainty.
    misfit
        Largest part of the jumps that may be left, as a share of the step.

    Returns
    -------
    (len(span), n_dims) mm, with a note that gives the height.

    Raises
    ------
    CannotRepair
        If the span was not recorded, or what happens at its edges is no step.
    """
    values, inside = recorded_around(problem)
    label = problem.labels[problem.marker]
    shape = np.zeros((len(values), 1))
    shape[inside.frames] = 1.0
    bends, kinks = second_differences(values), second_differences(shape)
    use = np.isfinite(bends[:, 0]) & (kinks[:, 0] != 0)
    power = float(np.square(kinks[use]).sum())
    if power < 2.0:
        raise CannotRepair(
            f"{label} is not seen next to the span, so the height of a step cannot be told; choose "
            "a method that uses its neighbours."
        )
    height = (kinks[use] * bends[use]).sum(axis=0) / power
    doubt = usual_curvature(values, inside) / np.sqrt(power)
    height = np.where(np.abs(height) > significance * doubt, height, 0.0)
    left = np.linalg.norm(bends[use] - kinks[use] * height)
    whole = np.linalg.norm(bends[use])
    if not height.any() or left > misfit * whole:
        raise CannotRepair(
            f"What {label} does at the edges of the span is no step; choose a method that fills "
            "the span anew."
        )
    size = ", ".join(f"{h:+.1f}" for h in height)
    return Outcome(values[inside.frames] - height, note=f"A step of ({size}) mm was taken away.")
