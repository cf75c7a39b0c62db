"""The stretch of a take around a span: what a method looks at, whatever the take's length."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from markermend.errors import CannotRepair
from markermend.model import BoolArray, FloatArray, Span
from markermend.repairing.problem import Problem
from markermend.repairing.remembering import remembered

CONTEXT = 3000
"""Frames that a method looks at unless it says otherwise."""


@dataclass(frozen=True, eq=False)
class Window:
    """A part of a problem, in frames of its own.

    Attributes
    ----------
    positions
        (n_frames, n_markers, n_dims) mm, read-only, NaN where not to be trusted.
    marker
        Index of the marker to be repaired.
    span
        Frames to be repaired, counted within the window.
    start
        The window's first frame, counted in the take.
    rate
        Hz.
    labels
        Names of the markers.
    """

    positions: FloatArray
    marker: int
    span: Span
    start: int
    rate: float
    labels: tuple[str, ...]

    @property
    def n_frames(self) -> int:
        """Number of frames in the window."""
        return int(self.positions.shape[0])

    @property
    def n_dims(self) -> int:
        """2 or 3."""
        return int(self.positions.shape[2])

    @property
    def label(self) -> str:
        """Name of the marker to be repaired."""
        return self.labels[self.marker]

    @cached_property
    def own(self) -> FloatArray:
        """(n_frames, n_dims): the marker's trusted positions."""
        return np.ascontiguousarray(self.positions[:, self.marker])

    @cached_property
    def seen(self) -> BoolArray:
        """(n_frames, n_markers): which positions may be trusted."""
        return np.isfinite(self.positions[:, :, 0])

    @cached_property
    def others(self) -> NDArray[np.intp]:
        """Indices of the other markers that are seen throughout the span."""
        through = self.seen[self.span.frames].all(axis=0)
        return np.flatnonzero(through & (np.arange(len(self.labels)) != self.marker))

    @cached_property
    def edges(self) -> tuple[int | None, int | None]:
        """The marker's last seen frame before the span and its first one after it."""
        frames = np.flatnonzero(self.seen[:, self.marker])
        before, after = frames[frames < self.span.start], frames[frames >= self.span.stop]
        return (
            int(before[-1]) if len(before) else None,
            int(after[0]) if len(after) else None,
        )

    def meeting(self, predicted: FloatArray) -> FloatArray:
        """Shift a prediction so that it meets the seen frames at the edges of the gap.

        Parameters
        ----------
        predicted
            (n_frames, n_dims) mm over the window.

        Returns
        -------
        (len(span), n_dims) mm: the prediction in the span, less its error at the edges, which goes
        linearly from one to the other, and stays the same where only one edge is seen.
        """
        anchors = np.array([edge for edge in self.edges if edge is not None])
        off = predicted[anchors] - self.own[anchors]
        frames = np.arange(self.span.start, self.span.stop)
        ramp: FloatArray = np.column_stack([np.interp(frames, anchors, axis) for axis in off.T])
        return predicted[self.span.frames] - ramp


@remembered
def window(problem: Problem, frames: int = CONTEXT) -> Window:
    """Cut out at most `frames` frames around the span, or three times the span if that is more.

    Near an end of the take the other side gets what is left over.

    Raises
    ------
    CannotRepair
        If the marker is not seen anywhere in the window.
    """
    span = problem.span
    size = min(max(frames, 3 * len(span)), problem.n_frames)
    start = span.start - (size - len(span)) // 2
    start = min(max(start, 0), problem.n_frames - size)
    cut = Window(
        positions=problem.positions[start : start + size],
        marker=problem.marker,
        span=Span(span.start - start, span.stop - start),
        start=start,
        rate=problem.rate,
        labels=problem.labels,
    )
    if not cut.seen[:, cut.marker].any():
        raise CannotRepair(
            f"{cut.label} is not seen outside the span, so nothing is known of where it sits; "
            "leave the gap."
        )
    return cut


def seen_frames(problem: Problem) -> NDArray[np.intp]:
    """Give the frames of the whole take in which the marker may be trusted."""
    return np.flatnonzero(np.isfinite(problem.own[:, 0]))


def both_sides(problem: Problem, context: int) -> NDArray[np.intp]:
    """Give up to `context` trusted frames of the marker before the span, and as many after it.

    Raises
    ------
    CannotRepair
        If the marker is not seen on both sides of the span.
    """
    frames, span = seen_frames(problem), problem.span
    before, after = frames[frames < span.start], frames[frames >= span.stop]
    if not (len(before) and len(after)):
        raise CannotRepair(
            f"{problem.labels[problem.marker]} is not seen on both sides of the span; "
            "choose a method that uses its neighbours."
        )
    return np.concatenate([before[-context:], after[:context]])
