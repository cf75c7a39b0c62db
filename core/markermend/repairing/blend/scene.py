"""The neighbours that a marker can be regressed on around one span."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from markermend.errors import CannotRepair
from markermend.model import BoolArray, FloatArray, runs
from markermend.repairing.geometry import (
    LocalFrames,
    closeness,
    defines_frame,
    distance_spread,
    kabsch,
)
from markermend.repairing.kriging import hermite
from markermend.repairing.problem import Problem
from markermend.repairing.remembering import remembered
from markermend.repairing.window import Window, window

BOUNDARY = 12
"""Seen frames on each side of a gap that what is left over is kriged from."""
REACH = 24
"""Frames beyond which a seen frame says nothing about the edge any more."""
SHORT_DROPOUT_S = 0.1
"""A neighbour's drop-out up to here is bridged where the marker only learns from it."""
TINY_DROPOUT_S = 0.025
"""The same inside the span, where the fill would follow the bridge."""
KEPT_SHARE = 0.5
MOST_FRAMES_FOR_SPREAD = 600


@dataclass(frozen=True, eq=False)
class Scene:
    """A marker and its usable neighbours in a window around one span.

    Attributes
    ----------
    window
        The window; `neighbours` and all masks below are in its frames.
    order
        Indices of the neighbours in the window, the most rigid first.
    spread
        (n_neighbours,) mm: standard deviation of each one's distance to the marker.
    neighbours
        (n_frames, n_neighbours, n_dims) mm; short drop-outs are bridged.
    there
        (n_frames,): all neighbours are there.
    """

    window: Window
    order: NDArray[np.intp]
    spread: FloatArray
    neighbours: FloatArray
    there: BoolArray

    @cached_property
    def rows(self) -> BoolArray:
        """(n_frames,): the marker is seen and all neighbours are there."""
        return self.window.seen[:, self.window.marker] & self.there

    @cached_property
    def boundary(self) -> NDArray[np.intp]:
        """Frames around the span from which what is left over is kriged, ascending."""
        return boundary_frames(self.rows, self.window.span.start, self.window.span.stop)

    def frames_of(self, markers: int) -> LocalFrames:
        """Fit the frame of reference of the first `markers` neighbours, or of the fewest more.

        Raises
        ------
        CannotRepair
            If the neighbours define no frame of reference.
        """
        at = self._posture
        for n in range(min(markers, len(self.order)), len(self.order) + 1):
            shape = self.neighbours[at, :n]
            if defines_frame(shape):
                return kabsch(shape, self.neighbours[:, :n], closeness(self.spread[:n]))
        raise CannotRepair(
            f"Only {len(self.order)} neighbours of {self.window.label} are seen throughout the "
            f"span, which fixes no frame of reference ({self.window.n_dims} off one line are "
            "needed); choose pchip or auto."
        )

    @cached_property
    def _posture(self) -> int:
        """Give the frame next to the span in which all are there."""
        frames = np.flatnonzero(self.rows)
        return int(frames[np.argmin(np.abs(frames - self.window.span.start + 1))])


def scene(problem: Problem, least: int) -> Scene:
    """Choose the neighbours that are there throughout the span and in most other frames.

    Raises
    ------
    CannotRepair
        If fewer than `least` neighbours are, or the marker itself is not seen nearby.
    """
    cut = window(problem)
    found = survey(cut)
    if len(found.order) < least:
        raise CannotRepair(
            f"Only {len(found.order)} neighbours of {cut.label} are seen throughout the span and "
            f"{least} are needed; choose auto or pchip, or fill its neighbours first."
        )
    return found


@remembered
def survey(cut: Window) -> Scene:
    """Choose the neighbours, however few they are."""
    positions, seen = _bridged(cut)
    span = cut.span
    hull = slice(max(span.start - 1, 0), min(span.stop + 1, cut.n_frames))
    through = np.asarray(seen[hull].all(axis=0))
    candidates = np.flatnonzero(through & (np.arange(len(through)) != cut.marker))
    step = max(1, cut.n_frames // MOST_FRAMES_FOR_SPREAD)
    spread, _ = distance_spread(cut.own[::step], positions[::step, candidates], least=5)
    kept: list[int] = []
    rows = cut.seen[:, cut.marker].copy()
    wanted = KEPT_SHARE * rows.sum()
    for i in np.argsort(spread, kind="stable"):
        if not np.isfinite(spread[i]):
            break
        fewer = rows & seen[:, candidates[i]]
        if fewer.sum() >= wanted:
            rows = fewer
            kept.append(int(i))
    order = candidates[kept]
    there = np.asarray(seen[:, order].all(axis=1))
    return Scene(cut, order, spread[kept], positions[:, order], there)


def boundary_frames(rows: BoolArray, start: int, stop: int) -> NDArray[np.intp]:
    """Give up to BOUNDARY usable frames on each side of a span, none farther off than REACH."""
    low = max(start - REACH, 0)
    before = low + np.flatnonzero(rows[low:start])
    after = stop + np.flatnonzero(rows[stop : stop + REACH])
    return np.concatenate([before[-BOUNDARY:], after[:BOUNDARY]])


def _bridged(cut: Window) -> tuple[FloatArray, BoolArray]:
    """Bridge the short drop-outs of all other markers by cubics."""
    if cut.seen.all(axis=0).sum() >= len(cut.labels) - 1:
        return cut.positions, cut.seen
    positions, seen = cut.positions.copy(), cut.seen.copy()
    hull = cut.span.padded(1, cut.n_frames)
    for m in np.flatnonzero(~cut.seen.all(axis=0)):
        if m == cut.marker:
            continue
        known = np.flatnonzero(cut.seen[:, m])
        for gap in runs(~cut.seen[:, m]):
            longest = TINY_DROPOUT_S if gap.overlaps(hull) else SHORT_DROPOUT_S
            if len(gap) <= longest * cut.rate and gap.start > 0 and gap.stop < cut.n_frames:
                near = known[(known >= gap.start - 3) & (known < gap.stop + 3)]
                weights = hermite(np.arange(gap.start, gap.stop, dtype=float), near.astype(float))
                positions[gap.frames, m] = weights @ cut.positions[near, m]
                seen[gap.frames, m] = True
    return positions, seen
