"""Subtract a step."""

from collections.abc import Iterator
from itertools import product
from typing import Annotated

import numpy as np

from markermend.errors import CannotRepair
from markermend.model import BoolArray, FloatArray, Span
from markermend.params import Within
from markermend.registry import method
from markermend.repairing.artefacts import recorded_around, second_differences, usual_curvature
from markermend.repairing.problem import Outcome, Problem

CALM = 2.0
"""What is left at the ends is no more than usual if it is below so many usual curvatures."""


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
    slack: Annotated[int, Within(0, 20, "frames")] = 4,
) -> Outcome:
    """Find the height of a step by the jumps at its edges, and take it away.

    The motion within the span stays as it was recorded.

    Parameters
    ----------
    significance
        An axis stays as it is unless its height is so many times its uncertainty.
    misfit
        Largest part of the jumps that may be left, as a share of the step.
    slack
        How far inside or outside the ends of the span the jumps are looked for.

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
    bends = second_differences(values)
    span, kinks = max(_steps(inside, bends, slack), key=lambda step: _gain(step[1], bends))
    use = np.isfinite(bends[:, 0]) & (kinks != 0)
    power = float(np.square(kinks[use]).sum())
    if power < 2.0:
        raise CannotRepair(
            f"{label} is not seen next to the span, so the height of a step cannot be told; choose "
            "a method that uses its neighbours."
        )
    kinks = kinks[:, None]
    height = (kinks[use] * bends[use]).sum(axis=0) / power
    usual = usual_curvature(values, inside)
    doubt = usual / np.sqrt(power)
    height = np.where(np.abs(height) > significance * doubt, height, 0.0)
    near = use | _near(inside, len(use), slack)
    near &= np.isfinite(bends[:, 0])
    left = np.linalg.norm(bends[near] - kinks[near] * height)
    whole = np.linalg.norm(bends[near])
    calm = CALM * np.sqrt(near.sum()) * np.linalg.norm(usual)
    if not height.any() or left > max(misfit * whole, calm):
        raise CannotRepair(
            f"What {label} does at the edges of the span is no step; choose a method that fills "
            "the span anew."
        )
    size = ", ".join(f"{h:+.1f}" for h in height)
    values[span.frames] -= height
    return Outcome(values[inside.frames], note=f"A step of ({size}) mm was taken away.")


def _steps(inside: Span, bends: FloatArray, slack: int) -> Iterator[tuple[Span, FloatArray]]:
    """Give spans that the step may fill, the one asked for first, and their second differences."""
    n = len(bends) + 2
    ways = sorted(range(-slack, slack + 1), key=abs)
    for before, after in product(ways, ways):
        start, stop = inside.start + before, inside.stop + after
        if 0 <= start < stop <= n:
            shape = np.zeros(n)
            shape[start:stop] = 1.0
            yield Span(start, stop), np.diff(shape, n=2)


def _near(span: Span, n: int, slack: int) -> BoolArray:
    """(n,): second differences at which an end of the step might lie."""
    frames = np.arange(1, n + 1)
    ends = np.array([[span.start], [span.stop]])
    return np.asarray((np.abs(frames - ends + 0.5) < slack + 1).any(axis=0))


def _gain(kinks: FloatArray, bends: FloatArray) -> float:
    """Give by how much the squared second differences become less when the step is taken away."""
    use = np.isfinite(bends[:, 0]) & (kinks != 0)
    power = float(np.square(kinks[use]).sum())
    return float(np.square(kinks[use] @ bends[use]).sum()) / max(power, 2.0)
