"""From marks on single coordinates to findings on markers."""

from collections.abc import Sequence

import numpy as np

from markermend.detection.published.stages import Mark, Stage
from markermend.model import AXES, BoolArray, Evidence, Finding, FloatArray, Span

# Marks on two axes are one artefact if they overlap when widened by this many frames.
SLACK = 1


def score_of(strength: float) -> float:
    """Map strength to 0 .. 1: a finding just at its threshold has 0.5, one at twice 0.75."""
    return float(1.0 - 2.0**-strength)


def findings(
    stage: Stage,
    expected: FloatArray,
    trusted: BoolArray,
    labels: Sequence[str],
    n_dims: int,
    pad: int,
) -> list[Finding]:
    """Merge the marks of one stage over the axes of each marker.

    Parameters
    ----------
    stage
        What was found; columns are marker by marker, axis by axis.
    expected
        (n_frames, n_columns) mm: where the marker would have been.
    trusted
        (n_frames, n_columns): a mark is dropped of which half was interpolated before this stage,
        since it lay in a gap or was found by a stage before.
    labels
        Names of the markers.
    n_dims
        Columns per marker.
    pad
        Frames of evidence on both sides of the span.
    """
    found = []
    by_marker: dict[int, list[Mark]] = {}
    for mark in stage.marks:
        if trusted[mark.span.frames, mark.column].mean() > 0.5:
            by_marker.setdefault(mark.column // n_dims, []).append(mark)
    for marker, marks in by_marker.items():
        for group in _groups(marks):
            best = max(group, key=lambda mark: mark.strength)
            span = Span(min(m.span.start for m in group), max(m.span.stop for m in group))
            per_axis = dict.fromkeys(range(n_dims), 0.0)
            for mark in group:
                axis = mark.column % n_dims
                per_axis[axis] = max(per_axis[axis], mark.amplitude)
            found.append(
                Finding(
                    marker=labels[marker],
                    span=span,
                    kind=stage.kind,
                    score=score_of(best.strength),
                    axes=tuple(AXES[a] for a, size in per_axis.items() if size > 0.0),
                    amplitude=float(np.linalg.norm(list(per_axis.values()))),
                    detector="published",
                    strength=best.strength,
                    evidence=_evidence(stage, best, span, expected, n_dims, pad),
                )
            )
    return found


def _groups(marks: Sequence[Mark]) -> list[list[Mark]]:
    """Group marks whose spans overlap, in the order of time."""
    groups: list[list[Mark]] = []
    reach = -1
    for mark in sorted(marks, key=lambda mark: mark.span):
        if groups and mark.span.start < reach + SLACK:
            groups[-1].append(mark)
        else:
            groups.append([mark])
            reach = mark.span.stop
        reach = max(reach, mark.span.stop)
    return groups


def _evidence(
    stage: Stage, best: Mark, span: Span, expected: FloatArray, n_dims: int, pad: int
) -> Evidence:
    window = span.padded(pad, len(expected))
    first = best.column - best.column % n_dims
    return Evidence(
        name=f"{stage.name}, {AXES[best.column % n_dims]}",
        start=window.start,
        signal=stage.signal[window.frames, best.column].copy(),
        threshold=float(stage.threshold[best.column]),
        usual=float(stage.usual[best.column]),
        prediction=expected[window.frames, first : first + n_dims].copy(),
    )
