"""Estimate an additive artefact of known shape, so that it can be subtracted."""

import numpy as np

from markermend.errors import CannotRepair
from markermend.model import FloatArray, Span
from markermend.repairing.problem import Problem

CONTEXT = 100
"""Frames on each side that tell how much second differences usually vary."""


def recorded_around(problem: Problem) -> tuple[FloatArray, Span]:
    """Give the recording around the span, and the span counted in it.

    Raises
    ------
    CannotRepair
        If something in the span was not recorded.
    """
    around = problem.span.padded(CONTEXT, problem.n_frames)
    inside = Span(problem.span.start - around.start, problem.span.stop - around.start)
    values = problem.own[around.frames].copy()
    values[inside.frames] = problem.recorded[problem.span.frames]
    if not np.isfinite(values[inside.frames]).all():
        raise CannotRepair(
            f"{problem.labels[problem.marker]} is not recorded in the whole span, so there is "
            "nothing to subtract from; choose a method that fills gaps."
        )
    return values, inside


def second_differences(values: FloatArray) -> FloatArray:
    """Give x[t-1] - 2 x[t] + x[t+1] for all inner frames t."""
    return np.diff(values, n=2, axis=0)


def usual_curvature(values: FloatArray, inside: Span) -> FloatArray:
    """Give (n_dims,) mm: the usual size of second differences outside the span, robustly."""
    bends = second_differences(values)
    frames = np.arange(1, len(bends) + 1)
    outside = (frames < inside.start - 1) | (frames > inside.stop)
    known = np.abs(bends[outside & np.isfinite(bends[:, 0])])
    return 1.4826 * np.median(known, axis=0) if len(known) else np.zeros(values.shape[1])
