"""The three neighbours that a marker's place is told from, and the distances kept to them.

After M. Tits, J. Tilmanne, T. Dutoit, "Robust and automatic motion-capture data recovery using
soft skeleton constraints and model averaging", PLoS ONE 13(7):e0199744, 2018.
"""

from dataclasses import dataclass
from itertools import combinations, islice

import numpy as np
from numpy.typing import NDArray

from markermend.errors import CannotRepair
from markermend.model import FloatArray
from markermend.repairing.geometry import LocalFrames, defines_frame
from markermend.repairing.remembering import remembered
from markermend.repairing.smoothing import odd_width, smooth_runs
from markermend.repairing.window import Window

RIGIDITY = 20.0
"""What a millimetre of variation weighs beside a millimetre of distance."""

ENOUGH = 300
"""Frames that show every marker: from so many on, only they say how rigid a pair is."""

TRIES = 200
"""Triads tried before all neighbours are taken to stand in one line."""


@dataclass(frozen=True, eq=False)
class Triad:
    """A marker, its gap, and its three references.

    Attributes
    ----------
    cut
        The window looked at.
    stretch
        The gap with the seen frame before and after it, where there are any.
    before, after
        Whether these are there.
    references
        Indices of three markers, the nearest and most rigid first.
    spread
        (n_markers,) mm: how much the distance of each marker varies.
    axes, smooth_axes
        Local frames from the references as seen, and from them smoothed.
    smooth_references
        (n_frames, 3, n_dims) mm.
    local
        (n_frames, n_dims) mm: the marker in the smoothed local frames.
    distances
        (n_frames, 3) mm: from the smoothed marker to the smoothed references.
    width
        Frames that are smoothed over.
    """

    cut: Window
    stretch: slice
    before: bool
    after: bool
    references: NDArray[np.intp]
    spread: FloatArray
    axes: LocalFrames
    smooth_axes: LocalFrames
    smooth_references: FloatArray
    local: FloatArray
    distances: FloatArray
    width: int

    @property
    def size(self) -> int:
        """Frames in the stretch."""
        return int(self.stretch.stop - self.stretch.start)

    def inner(self, values: FloatArray) -> FloatArray:
        """Cut the span's values out of those of the stretch."""
        start = self.cut.span.start - self.stretch.start
        return values[start : start + len(self.cut.span)]

    def ramped(self, predicted: FloatArray, actual: FloatArray) -> FloatArray:
        """Meet the seen frames at both ends by a linear ramp.

        Parameters
        ----------
        predicted
            (size, n_dims) over the stretch.
        actual
            (n_frames, n_dims) over the window, of the same marker in the same coordinates.
        """
        off = predicted - actual[self.stretch]
        return predicted - self.ramp(off[0], off[-1])

    def ramp(self, first: FloatArray, last: FloatArray) -> FloatArray:
        """Go from one offset to the other; where only one end is seen, keep that one."""
        if not (self.before or self.after):
            return np.zeros((self.size, len(first)))
        first, last = (first if self.before else last), (last if self.after else first)
        return np.linspace(first, last, self.size)


@remembered
def triad(cut: Window, smoothing_s: float, by_axis: bool = True) -> Triad:
    """Choose the references of the marker at hand.

    Parameters
    ----------
    smoothing_s
        Duration that references and results are smoothed over.
    by_axis
        Whether they are smoothed by the median of each axis too, as in the paper.

    Raises
    ------
    CannotRepair
        If fewer than three neighbours are seen throughout, or they stand in one line.
    """
    before, after = cut.edges
    start = cut.span.start if before is None else before
    stop = cut.span.stop if after is None else after + 1
    stretch = slice(start, stop)
    rank, spread = remoteness(cut)
    candidates = np.flatnonzero(cut.seen[stretch].all(axis=0) & np.isfinite(spread))
    ordered = candidates[np.argsort(rank[candidates], kind="stable")]
    if len(ordered) < 3:
        raise CannotRepair(
            f"Other markers seen from edge to edge of the gap: {len(ordered)}, and three are "
            "needed; choose a method that needs none, such as pchip."
        )
    references = _in_no_line(cut, ordered, start)
    width = odd_width(smoothing_s, cut.rate)
    seen = cut.positions[:, references]
    smooth = np.stack([smooth_runs(x, width, by_axis) for x in seen.transpose(1, 0, 2)], axis=1)
    smooth_axes = local_axes(smooth)
    return Triad(
        cut=cut,
        stretch=stretch,
        before=before is not None,
        after=after is not None,
        references=references,
        spread=spread,
        axes=local_axes(seen[stretch]),
        smooth_axes=smooth_axes,
        smooth_references=smooth,
        local=smooth_axes.to_local(cut.own),
        distances=np.linalg.norm(smooth - smooth_runs(cut.own, width, by_axis)[:, None], axis=2),
        width=width,
    )


def _in_no_line(cut: Window, ordered: NDArray[np.intp], frame: int) -> NDArray[np.intp]:
    for three in islice(combinations(ordered, 3), TRIES):
        references = np.array(three)
        if defines_frame(cut.positions[frame, references]):
            return references
    raise CannotRepair(
        f"The neighbours of {cut.label} stand in one line and tell no place; choose a method that "
        "needs none, such as pchip."
    )


def remoteness(cut: Window) -> tuple[FloatArray, FloatArray]:
    """Rank the other markers: the nearer and the more rigidly tied, the smaller.

    Only frames that show every marker count, where there are enough of them.

    Returns
    -------
    The largest distance plus `RIGIDITY` times its standard deviation, and that deviation;
    (n_markers,) mm each, infinite for the marker itself.
    """
    ever = cut.seen.any(axis=0)
    whole = cut.seen[:, ever].all(axis=1)
    frames = whole if whole.sum() > ENOUGH else cut.seen[:, cut.marker]
    distance = np.linalg.norm(cut.positions[frames] - cut.own[frames, None], axis=2)
    known = np.isfinite(distance)
    count = known.sum(axis=0)
    mean = np.where(known, distance, 0.0).sum(axis=0) / np.maximum(count, 1)
    off = np.where(known, distance - mean, 0.0)
    spread = np.sqrt(np.square(off).sum(axis=0) / np.maximum(count - 1, 1))
    spread[(count < 2) | (np.arange(len(count)) == cut.marker)] = np.inf
    return mean + off.max(axis=0, initial=0.0) + RIGIDITY * spread, spread


def local_axes(references: FloatArray) -> LocalFrames:
    """Make local frames from the first reference towards the second, in the plane of the third.

    Parameters
    ----------
    references
        (n_frames, 3, n_dims) mm; in two dimensions the third one is not needed.
    """
    a, b, c = references.transpose(1, 0, 2)
    along = _unit(b - a)
    if references.shape[2] == 2:
        across = np.stack([-along[:, 1], along[:, 0]], axis=1)
        return LocalFrames(np.stack([along, across], axis=2), a)
    normal = _unit(np.cross(along, c - a))
    return LocalFrames(np.stack([along, np.cross(normal, along), normal], axis=2), a)


def _unit(vectors: FloatArray) -> FloatArray:
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0))


def keep_distances(points: FloatArray, references: FloatArray, usual: FloatArray) -> FloatArray:
    """Pull points into the usual distances from their references (the soft skeleton constraint).

    Parameters
    ----------
    points
        (n_frames, n_dims) mm.
    references
        (n_frames, 3, n_dims) mm.
    usual
        (2, 3) mm: smallest and largest usual distance to each.

    Notes
    -----
    Five rounds of projection on the shell about each reference, the softest one first, so that the
    most rigid one has the last word.
    """
    for _ in range(5):
        for j in (2, 1, 0):
            away = points - references[:, j]
            distance = np.linalg.norm(away, axis=1, keepdims=True)
            wanted = np.clip(distance, usual[0, j], usual[1, j])
            share = np.divide(wanted, distance, out=np.ones_like(distance), where=distance > 0)
            points = references[:, j] + away * share
    return points
