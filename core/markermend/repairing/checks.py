"""What an operator looks at in a repaired span: its edges, its distances, new artefacts."""

from dataclasses import dataclass, replace

import numpy as np

from markermend.detection.run import detect
from markermend.model import Finding, FloatArray, Span, Take
from markermend.repairing.geometry import distance_spread
from markermend.repairing.problem import Problem
from markermend.repairing.run import moved

CLUSTER = 4
"""Neighbours whose distances are looked at."""
COMPANY = 5
"""Neighbours that the detector is shown."""
MARGIN_S = 2.5
MOST_MARGIN = 300
NEAR = 3
"""Frames around the span in which a finding counts as the repair's."""


@dataclass(frozen=True)
class Checks:
    """How a repair fits what is around it.

    Attributes
    ----------
    step_mm, usual_step_mm
        How far the repair's edges are from where the marker was going, and what 95 % of all
        frames of the recording stay under.
    slope_mm, usual_slope_mm
        How much the velocity jumps at the edges, in mm per frame, and likewise what is usual.
    distance_mm, usual_distance_mm
        Root mean square change of the distances to the most rigid neighbours in the span, and
        outside of it; None where no neighbour is seen.
    artefacts
        What the detector finds there after the repair.
    detected
        Whether the detector was run.
    unlooked
        Why it was not, in a sentence, or empty.
    """

    step_mm: float
    usual_step_mm: float
    slope_mm: float
    usual_slope_mm: float
    distance_mm: float | None
    usual_distance_mm: float | None
    artefacts: tuple[Finding, ...]
    detected: bool
    unlooked: str = ""


class Inspector:
    """The surroundings of one span, prepared once for many repairs of it.

    Parameters
    ----------
    problem
        The span, best already cut down to a window.
    first
        Frame of the take with which the window starts.
    """

    def __init__(self, problem: Problem, first: int = 0) -> None:
        self._problem, self._first = problem, first
        self._span = problem.span
        others = np.delete(np.arange(len(problem.labels)), problem.marker)
        spread, mean = distance_spread(problem.own, problem.positions[:, others])
        seen = np.isfinite(problem.positions[problem.span.frames, others][..., 0])
        through = np.asarray(seen.all(axis=0)) & np.isfinite(spread)
        order = np.argsort(np.where(through, spread, np.inf), kind="stable")
        order = order[: int(through.sum())]
        self._cluster = others[order[:CLUSTER]]
        self._mean, self._spread = mean[order[:CLUSTER]], spread[order[:CLUSTER]]
        self._company = others[order[:COMPANY]]
        jumps = np.linalg.norm(np.diff(problem.own, n=2, axis=0), axis=1)
        jumps = jumps[np.isfinite(jumps)]
        self._usual = float(np.quantile(jumps, 0.95)) if len(jumps) else 0.0

    def check(self, values: FloatArray, run_detector: bool = True) -> Checks:
        """Look at one repair.

        Parameters
        ----------
        values
            (len(span), n_dims) mm.
        run_detector
            Look for new artefacts where the detector can, which takes most of the time.
        """
        step, slope = self._edges(values)
        unlooked = "" if run_detector else "Too far off to look for new artefacts."
        if self._problem.n_dims != 3:
            unlooked = "The detector does not look for new artefacts in 2D."
        elif not len(self._company):
            unlooked = "No neighbour is seen, so the detector cannot look for new artefacts."
        distance = usual = None
        if len(self._cluster):
            cluster = self._problem.positions[self._span.frames, self._cluster]
            off = np.linalg.norm(cluster - values[:, None], axis=2) - self._mean
            distance = float(np.sqrt(np.square(off).mean()))
            usual = float(np.sqrt(np.square(self._spread).mean()))
        return Checks(
            step_mm=step,
            usual_step_mm=self._usual,
            slope_mm=slope,
            usual_slope_mm=self._usual,
            distance_mm=distance,
            usual_distance_mm=usual,
            artefacts=() if unlooked else self._artefacts(values),
            detected=not unlooked,
            unlooked=unlooked,
        )

    def _edges(self, values: FloatArray) -> tuple[float, float]:
        own, span = self._problem.own, self._span
        steps, slopes = [], []
        for outside, inside in (
            (own[max(span.start - 2, 0) : span.start], values[:2]),
            (own[span.stop : span.stop + 2][::-1], values[::-1][:2]),
        ):
            if len(outside) < 2 or not np.isfinite(outside).all():
                continue
            velocity = outside[1] - outside[0]
            steps.append(np.linalg.norm(inside[0] - outside[1] - velocity))
            if len(inside) == 2:
                slopes.append(np.linalg.norm(inside[1] - inside[0] - velocity))
        return float(max(steps, default=0.0)), float(max(slopes, default=0.0))

    def _artefacts(self, values: FloatArray) -> tuple[Finding, ...]:
        """Run the default detector on the marker and its neighbours around the span."""
        problem, span = self._problem, self._span
        margin = min(int(MARGIN_S * problem.rate), MOST_MARGIN)
        part = span.padded(margin, problem.n_frames)
        chosen = np.sort(np.append(self._company, problem.marker))
        positions = problem.positions[part.frames][:, chosen].copy()
        place = int(np.flatnonzero(chosen == problem.marker)[0])
        positions[span.start - part.start : span.stop - part.start, place] = values
        label = problem.labels[problem.marker]
        small = Take(positions, problem.rate, [problem.labels[i] for i in chosen])
        around = Span(span.start - part.start, span.stop - part.start).padded(NEAR, len(part))
        return tuple(
            replace(found, span=moved(found.span, part.start + self._first))
            for found in detect(small)
            if found.marker == label and found.kind != "gap" and found.span.overlaps(around)
        )
