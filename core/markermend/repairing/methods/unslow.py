"""Subtract a slow hill."""

from typing import Annotated

import numpy as np

from markermend.errors import CannotRepair
from markermend.model import FloatArray, Span
from markermend.params import Within
from markermend.registry import method
from markermend.repairing.artefacts import recorded_around, second_differences, usual_curvature
from markermend.repairing.methods.pchip import pchip
from markermend.repairing.methods.rlk import rlk
from markermend.repairing.problem import Outcome, Problem

LEAST_MM = 0.05
"""Scatter of second differences that no recording goes below."""


@method(
    title="Subtract the slow change",
    kinds=("slow",),
    source="MarkerMend: a triangle by its kinks and by its distance to a fill",
)
def unslow(
    problem: Problem,
    *,
    apexes: Annotated[int, Within(3, 201)] = 41,
    misfit: Annotated[float, Within(0.01, 1)] = 0.7,
) -> Outcome:
    """Find the triangle that a slow change is, and take it away.

    The motion within the span stays as it was recorded, less the triangle.

    Parameters
    ----------
    apexes
        Places of the apex that are tried.
    misfit
        Largest part of the distance to a fill that the triangle may leave unexplained.

    Returns
    -------
    (len(span), n_dims) mm, with a note that gives the height and where its apex is.

    Raises
    ------
    CannotRepair
        If the span was not recorded, cannot be filled for comparison, or holds no triangle.

    Notes
    -----
    The height minimises |d - a h|² / (L s²) + |D2 x - a D2 h|² / c², where d is the distance to
    the fill (RLK, or the monotone cubic where that refuses), whose error counts as one observation
    of size s, and c is the usual size of second differences.
    """
    values, inside = recorded_around(problem)
    label = problem.labels[problem.marker]
    if len(inside) < 5:
        raise CannotRepair(
            f"A span of {len(inside)} frames is too short for a slow change; choose another method."
        )
    away = values[inside.frames] - _filled(problem)
    bends = np.linalg.norm(usual_curvature(values, inside)) / problem.n_dims**0.5
    curvature = max(float(bends), LEAST_MM)
    tried = np.linspace(1.0, len(inside) - 2.0, apexes)
    fits = [_fit(values, inside, away, apex, curvature) for apex in tried]
    cost, height, triangle, apex = min(fits, key=lambda fit: fit[0])
    left = np.linalg.norm(away - triangle * height)
    if not np.isfinite(cost) or left > misfit * np.linalg.norm(away):
        raise CannotRepair(
            f"What {label} does in the span is no slow rise and fall; choose a method that fills "
            "the span anew."
        )
    size = ", ".join(f"{h:+.1f}" for h in height)
    note = (
        f"A hill of ({size}) mm with its apex at frame {problem.span.start + apex} was taken away."
    )
    return Outcome(values[inside.frames] - triangle * height, note=note)


def _filled(problem: Problem) -> FloatArray:
    try:
        return rlk(problem)
    except CannotRepair:
        return pchip(problem)


def _fit(
    values: FloatArray, inside: Span, away: FloatArray, apex: float, curvature: float
) -> tuple[float, FloatArray, FloatArray, float]:
    """Fit one triangle: its cost, its height (n_dims,), itself (len, 1), and its apex."""
    n = len(inside)
    frames = np.arange(n)
    rise, fall = (frames + 1) / (apex + 1), (n - frames) / (n - apex)
    triangle = np.minimum(rise, fall)[:, None]
    shape = np.zeros((len(values), 1))
    shape[inside.frames] = triangle
    bends, kinks = second_differences(values), second_differences(shape)
    use = np.isfinite(bends[:, 0]) & (kinks[:, 0] != 0)
    bends, kinks = bends[use], kinks[use]
    plain = (triangle * away).sum(axis=0) / np.square(triangle).sum()
    error = np.square(away - triangle * plain).mean()
    of_fill, of_bends = 1.0 / (n * max(error, 1e-9)), 1.0 / curvature**2
    power = of_fill * np.square(triangle).sum() + of_bends * np.square(kinks).sum()
    height = (
        of_fill * (triangle * away).sum(axis=0) + of_bends * (kinks * bends).sum(axis=0)
    ) / power
    cost = n * np.log(np.square(away - triangle * height).mean() + 1e-12) + of_bends * float(
        np.square(bends - kinks * height).sum() - np.square(bends).sum()
    )
    return float(cost), height, triangle, apex
