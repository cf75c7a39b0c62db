"""Problems whose answer is known: the same marker, the same length, elsewhere in the take."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from markermend.model import FloatArray, Kind, Span
from markermend.repairing.blend.pseudo import possible_starts
from markermend.repairing.blend.scene import Scene, survey
from markermend.repairing.problem import Problem
from markermend.repairing.window import window

SEED = 2718
NEAR = 400
"""Frames on each side that a method which takes long is shown."""


@dataclass(frozen=True, eq=False)
class Trial:
    """A problem that was posed where the marker is seen, and what was seen."""

    problem: Problem
    truth: FloatArray

    @cached_property
    def near(self) -> "Trial":
        """The same trial in the frames nearby only, for methods that take long."""
        part = self.problem.span.padded(NEAR, self.problem.n_frames)
        nearby = replace(
            self.problem,
            positions=self.problem.positions[part.frames],
            span=Span(self.problem.span.start - part.start, self.problem.span.stop - part.start),
            recorded=self.problem.recorded[part.frames],
            take=self.problem.take.with_positions(self.problem.take.positions[part.frames]),
        )
        return Trial(nearby, self.truth)


def cut_out(problem: Problem) -> tuple[Problem, Scene]:
    """Cut the problem down to the window that methods look at.

    Returns
    -------
    The same problem in frames of the window, so that its cost does not grow with the take, and
    the marker's neighbours there.

    Raises
    ------
    CannotRepair
        If the marker is not seen anywhere near.
    """
    around = survey(window(problem))
    cut = around.window
    frames = slice(cut.start, cut.start + cut.n_frames)
    smaller = replace(
        problem,
        positions=cut.positions,
        span=cut.span,
        recorded=problem.recorded[frames],
        take=problem.take.with_positions(problem.take.positions[frames]),
    )
    return smaller, around


def places(around: Scene) -> NDArray[np.intp]:
    """Give the first frames of all stretches that could be hidden in place of the span.

    There the marker and its usable neighbours are seen, as are the boundary frames that the span
    itself has.
    """
    span = around.window.span
    return possible_starts(around.rows, len(span), around.boundary - span.start)


def spread_out(starts: NDArray[np.intp], most: int) -> NDArray[np.intp]:
    """Choose `most` of the starts in contiguous parts of the take, so that few are the same."""
    if len(starts) <= most:
        return starts
    at = (np.arange(most) + 0.5) * len(starts) / most
    return starts[at.astype(np.intp)]


def trials(problem: Problem, starts: NDArray[np.intp], reference: FloatArray | None) -> list[Trial]:
    """Pose the same problem at other places of the same marker.

    The span itself stays hidden.  Where the problem's kind leaves data inside the span, an
    artefact of that kind and size is added to what was seen there.

    Parameters
    ----------
    problem
        The span.
    starts
        First frames of the other places.
    reference
        (len(span), n_dims) mm: about where the marker really was in the span, from which the size
        of its artefact is told; without it the other places are posed as gaps.
    """
    artefact = None if reference is None else _artefact(problem, reference)
    rng = np.random.default_rng(SEED)
    found = []
    for start in starts:
        span = Span(int(start), int(start) + len(problem.span))
        truth = problem.own[span.frames].copy()
        positions = problem.positions.copy()
        positions[span.frames, problem.marker] = np.nan
        positions.flags.writeable = False
        recorded = problem.recorded.copy()
        recorded[problem.span.frames] = np.nan
        recorded[span.frames] = np.nan if artefact is None else truth + artefact.draw(rng)
        posed = replace(
            problem,
            positions=positions,
            span=span,
            recorded=recorded,
            kind=problem.kind if artefact is not None else "gap",
        )
        found.append(Trial(posed, truth))
    return found


@dataclass(frozen=True, eq=False)
class Artefact:
    """What was added to the truth inside a span, as far as it can be told.

    Attributes
    ----------
    kind
        The kind of finding.
    size
        (n_dims,) mm: shift, height or standard deviation on each axis.
    length
        Frames.
    """

    kind: Kind
    size: FloatArray
    length: int

    def draw(self, rng: np.random.Generator) -> FloatArray:
        """Give one artefact of this kind and size, (length, n_dims) mm."""
        if self.kind == "noise":
            return np.asarray(rng.normal(0.0, 1.0, (self.length, len(self.size))) * self.size)
        shape = triangle(self.length) if self.kind in ("slow", "peak") else np.ones(self.length)
        return np.outer(shape, self.size)


def triangle(length: int) -> FloatArray:
    """Rise from 0 before the first frame to 1 in the middle, and fall to 0 after the last."""
    place = np.arange(1, length + 1) / (length + 1)
    shape = 1 - np.abs(2 * place - 1)
    return np.asarray(shape / shape.max())


def _artefact(problem: Problem, reference: FloatArray) -> Artefact | None:
    """Estimate the artefact in the span by what it is off the reference."""
    inside = problem.recorded[problem.span.frames]
    known = np.isfinite(inside[:, 0])
    if problem.kind == "gap" or not known.any():
        return None
    length = len(problem.span)
    if problem.kind == "noise" and known.sum() > 2:
        rough = np.diff(inside[known], n=2, axis=0)
        return Artefact("noise", np.sqrt(np.square(rough).mean(axis=0) / 6), length)
    off = inside - reference
    shape = np.ones(length) if problem.kind == "step" else triangle(length)
    size = shape[known] @ off[known] / np.square(shape[known]).sum()
    return Artefact(problem.kind, size, length)
