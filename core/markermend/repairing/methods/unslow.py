"""Subtract a slow hill."""

from typing import Annotated

import numpy as np

from markermend.errors import CannotRepair
from markermend.model import FloatArray
from markermend.params import Within
from markermend.registry import method
from markermend.repairing.hills import covariance, fit, unexplained
from markermend.repairing.problem import Outcome, Problem
from markermend.repairing.window import window

LEAST_OUTSIDE = 20
"""Frames outside the span without which nothing can be said of how the marker wanders."""


@method(
    title="Subtract the slow change",
    kinds=("slow",),
    source="MarkerMend: a triangle by generalised least squares under the neighbours' residual",
)
def unslow(
    problem: Problem,
    *,
    apexes: Annotated[int, Within(3, 201)] = 41,
    lean: Annotated[float, Within(0.01, 10)] = 0.08,
    significance: Annotated[float, Within(0, 20)] = 3.0,
) -> Outcome:
    """Find the triangle that a slow change is, and take it away.

    What the neighbours do not explain of the marker wanders in a way that is learnt outside the
    span; the likeliest triangle on top of that is subtracted. The motion within the span stays as
    it was recorded, less the triangle.

    Parameters
    ----------
    apexes
        Places of the apex that are tried.
    lean
        How far off the middle the apex usually is, as a share of the span.
    significance
        An axis stays as it is unless its height is so many times its uncertainty.

    Returns
    -------
    (len(span), n_dims) mm, with a note that gives the height and where its apex is.

    Raises
    ------
    CannotRepair
        If the span was not recorded, too little is seen around it, or it holds no triangle.
    """
    cut = window(problem)
    recorded = problem.recorded[problem.span.frames]
    if len(problem.span) < 5 or not np.isfinite(recorded).all():
        raise CannotRepair(
            f"{cut.label} is not recorded in at least five frames, the whole span, so there is no "
            "slow change to subtract; choose a method that fills gaps."
        )
    rest = unexplained(problem, cut)
    outside = int((~rest.inside).sum())
    if outside < LEAST_OUTSIDE or not rest.inside.any():
        raise CannotRepair(
            f"Only {outside} frames of {cut.label} around the span show how it usually wanders; "
            "choose a method that fills the span anew."
        )
    tops = np.linspace(1.0, len(cut.span) - 2.0, apexes)
    at = rest.frames - cut.span.start
    shapes = [triangle(at, len(cut.span), top) for top in tops]
    off = (tops / (len(cut.span) - 1) - 0.5) / lean
    found = fit(rest, covariance(rest, cut.rate), shapes, -np.square(off))
    sure = np.abs(found.height) > significance * found.doubt
    if not sure.any():
        raise CannotRepair(
            f"What {cut.label} does in the span is no slow rise and fall; choose a method that "
            "fills the span anew."
        )
    height = np.where(sure, found.height, 0.0)
    top = tops[found.which]
    hill = triangle(np.arange(len(cut.span)), len(cut.span), top)[:, None] * height
    size = ", ".join(f"{h:+.1f}" for h in height)
    note = (
        f"A hill of ({size}) mm with its apex {round(top)} frames into the span was taken away; "
        f"its height is known to {found.doubt[0]:.1f} mm."
    )
    return Outcome(recorded - hill, note=note)


def triangle(at: np.ndarray, length: int, top: float) -> FloatArray:
    """Rise from 0 before frame 0 to 1 at `top` and fall to 0 after the last frame; 0 elsewhere."""
    rise, fall = (at + 1) / (top + 1), (length - at) / (length - top)
    return np.asarray(np.clip(np.minimum(rise, fall), 0.0, 1.0))
