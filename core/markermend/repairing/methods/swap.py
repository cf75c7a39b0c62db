"""Swap labels back."""

from typing import Annotated

import numpy as np

from markermend.errors import CannotRepair
from markermend.model import FloatArray
from markermend.params import Within
from markermend.registry import method
from markermend.repairing.continuity import jumps
from markermend.repairing.problem import Outcome, Problem


@method(
    title="Swap labels back",
    kinds=("step",),
    source="P. Skurowski and M. Pawlyta, section 1: exchanged labels look like steps",
)
def swap(problem: Problem, *, better: Annotated[float, Within(1.1, 100)] = 2.0) -> Outcome:
    """Exchange the marker with its counterpart over the span, so that both go on smoothly.

    The counterpart is the partner that was found, or else the measured marker with which the
    exchange leaves the smallest jumps.

    Parameters
    ----------
    better
        How many times smaller the jumps of both must become.

    Returns
    -------
    (len(span), n_dims) mm, the partner's values under ``also``, and a note with the jumps.

    Raises
    ------
    CannotRepair
        If the marker is not recorded throughout the span, or no exchange makes both smoother.
    """
    take, span = problem.take, problem.span
    label = problem.labels[problem.marker]
    mine = problem.recorded[span.frames]
    if not np.isfinite(mine).all():
        raise CannotRepair(
            f"{label} is not recorded in the whole span, so there is nothing to exchange; choose a "
            "method that fills gaps."
        )
    names = [problem.partner] if problem.partner else [n for n in problem.labels if n != label]
    found: list[tuple[float, float, str, FloatArray]] = []
    for name in names:
        other = take.positions[:, take.index(name)]
        theirs = other[span.frames]
        if np.isfinite(theirs).all():
            now = _roughness(problem.recorded, mine, other, theirs, problem)
            then = _roughness(problem.recorded, theirs, other, mine, problem)
            found.append((then, now, name, theirs))
    then, now, name, theirs = min(found, key=lambda f: f[0], default=(np.inf, 0.0, "", mine))
    if not then * better < now:
        raise CannotRepair(
            f"No exchange of {label} with {problem.partner or 'another marker'} makes both go on "
            "more smoothly; choose another method."
        )
    note = f"Exchanged with {name}: the jumps of both go from {now:.1f} to {then:.1f} mm."
    return Outcome(theirs, note=note, also=((name, mine),))


def _roughness(
    first: FloatArray, in_first: FloatArray, second: FloatArray, in_second: FloatArray,
    problem: Problem,
) -> float:  # fmt: skip
    """Sum the jumps of two trajectories at the edges of the span where they are seen."""
    ends = (*jumps(first, in_first, problem.span), *jumps(second, in_second, problem.span))
    seen = [end for end in ends if np.isfinite(end)]
    return float(sum(seen)) if seen else float("inf")
