"""Join an unlabelled fragment."""

from typing import Annotated

import numpy as np
from scipy.interpolate import PchipInterpolator

from markermend.errors import CannotRepair
from markermend.model import FloatArray, Span
from markermend.params import Within
from markermend.registry import method
from markermend.repairing.continuity import jumps
from markermend.repairing.geometry import distance_spread
from markermend.repairing.problem import Outcome, Problem
from markermend.repairing.window import window

WITNESSES = 4
"""Neighbours whose distances are looked at."""


@method(
    title="Join an unlabelled fragment",
    kinds=("gap",),
    source="labelling by continuity and constant distances, as operators do it by hand",
)
def join(
    problem: Problem,
    *,
    jump: Annotated[float, Within(0.5, 200, "mm")] = 15.0,
    stretch: Annotated[float, Within(0.5, 200, "mm")] = 15.0,
    missing: Annotated[int, Within(0, 20, "frames")] = 4,
) -> Outcome:
    """Take a ``*n`` trajectory that goes on from the marker at both ends and keeps its distances.

    Parameters
    ----------
    jump
        Largest step at either end beyond the straight continuation.
    stretch
        Largest mean deviation from the usual distances to the most rigid neighbours, beyond what
        these vary.
    missing
        Frames at either end that the fragment may lack; they are bridged.

    Returns
    -------
    (len(span), n_dims) mm, with a note that names the fragment and the evidence.

    Raises
    ------
    CannotRepair
        If no fragment fits.
    """
    take, span = problem.take, problem.span
    cut = window(problem)
    if None in cut.edges:
        raise CannotRepair(
            f"{cut.label} is not seen on both sides of the span, so no fragment can be seen to go "
            "on from it; choose another method."
        )
    fragments = [m for m, role in enumerate(take.roles) if role == "unlabelled"]
    usual = _usual(problem)
    best, best_cost, note = np.empty((0, 0)), np.inf, ""
    for fragment in fragments:
        values = _bridged(problem, take.positions[span.frames, fragment], missing)
        if values is None:
            continue
        start, stop = jumps(problem.own, values, span)
        off = _deviation(problem, values, usual)
        cost = max(start, stop) / jump + off / stretch
        if max(start, stop) <= jump and off <= stretch and cost < best_cost:
            best, best_cost = values, cost
            note = (
                f"{take.labels[fragment]} goes on from {cut.label} within {start:.1f} mm at the "
                f"start and {stop:.1f} mm at the end, and keeps its distances within {off:.1f} mm."
            )
    if not note:
        raise CannotRepair(
            f"None of {len(fragments)} unlabelled fragments goes on from {cut.label} at both ends "
            "of the span and keeps its distances; choose another method."
        )
    return Outcome(best, note=note)


def _bridged(problem: Problem, values: FloatArray, missing: int) -> FloatArray | None:
    """Complete a fragment at its ends from the marker itself; None where too much is missing."""
    known = np.flatnonzero(np.isfinite(values[:, 0]))
    if not len(known) or known[0] > missing or len(values) - 1 - known[-1] > missing:
        return None
    if len(known) < known[-1] - known[0] + 1:
        return None
    if len(known) == len(values):
        return values
    span = problem.span
    around = span.padded(3, problem.n_frames)
    joined = problem.own[around.frames].copy()
    joined[span.start - around.start : span.stop - around.start] = values
    seen = np.flatnonzero(np.isfinite(joined[:, 0]))
    frames = np.arange(span.start, span.stop) - around.start
    return np.asarray(PchipInterpolator(seen, joined[seen])(frames))


def _usual(problem: Problem) -> tuple[np.ndarray, FloatArray, FloatArray]:
    """Give the most rigid neighbours, their usual distances, and how much these vary."""
    cut = window(problem)
    spread, mean = distance_spread(cut.own, cut.positions[:, cut.others])
    order = np.argsort(spread, kind="stable")[: min(WITNESSES, int(np.isfinite(spread).sum()))]
    return cut.others[order], mean[order], spread[order]


def _deviation(
    problem: Problem, values: FloatArray, usual: tuple[np.ndarray, FloatArray, FloatArray]
) -> float:
    """Give how far the distances are off on average, beyond what they vary, in mm."""
    markers, mean, spread = usual
    span: Span = problem.span
    if not len(markers):
        return 0.0
    near = problem.positions[span.frames][:, markers]
    distance = np.linalg.norm(near - values[:, None], axis=2)
    return float(np.maximum(np.abs(distance - mean).mean(axis=0) - spread, 0.0).mean())
