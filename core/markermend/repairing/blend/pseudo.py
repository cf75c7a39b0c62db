"""Honest pseudo-gaps: stretches where the marker is seen, hidden as if they were the gap."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from markermend.model import BoolArray, Span

MOST = 48
GROUPS = 6
INSIDE = 32
EMBARGO = 12


@dataclass(frozen=True, eq=False)
class PseudoGaps:
    """Places of one gap's length and boundary elsewhere on the same marker.

    Attributes
    ----------
    starts
        (n,) ascending: first hidden frame of each.
    length
        Number of hidden frames.
    inside
        (n_inside,): offsets at which the errors are looked at, from the first hidden frame.
    boundary
        (n_boundary,): offsets of the frames from which the rest is kriged.
    groups
        For each group of neighbouring pseudo-gaps its members, and the stretch of frames that
        what predicts them must not have learnt from.
    """

    starts: NDArray[np.intp]
    length: int
    inside: NDArray[np.intp]
    boundary: NDArray[np.intp]
    groups: tuple[tuple[NDArray[np.intp], Span], ...]

    def __len__(self) -> int:
        return len(self.starts)


def inside_offsets(length: int, most: int = INSIDE) -> NDArray[np.intp]:
    """Give up to `most` offsets spread evenly over a gap, the outermost among them."""
    return np.unique(np.linspace(0, length - 1, min(length, most)).round().astype(np.intp))


def possible_starts(rows: BoolArray, length: int, boundary: NDArray[np.intp]) -> NDArray[np.intp]:
    """Give the frames at which a gap of this length and boundary could be hidden."""
    n = len(rows)
    low = max(0, -int(boundary.min(initial=0)))
    high = n - max(length, int(boundary.max(initial=0)) + 1)
    if high < low:
        return np.empty(0, np.intp)
    starts = np.arange(low, high + 1)
    passed = np.concatenate([[0], np.cumsum(rows)])
    fits = passed[starts + length] - passed[starts] == length
    for offset in boundary:
        fits &= rows[starts + offset]
    return np.asarray(starts[fits])


def pseudo_gaps(
    rows: BoolArray, span: Span, boundary: NDArray[np.intp], most: int = MOST
) -> PseudoGaps:
    """Spread up to `most` pseudo-gaps over the frames where all is there.

    Parameters
    ----------
    rows
        (n_frames,): the marker and its neighbours are seen.
    span
        The gap.
    boundary
        Frames around the gap that are used to meet its edges.
    """
    length, offsets = len(span), boundary - span.start
    possible = possible_starts(rows, length, offsets)
    if len(possible) > most:
        chosen = np.unique(np.linspace(0, len(possible) - 1, most).round().astype(np.intp))
        possible = possible[chosen]
    groups = []
    for members in np.array_split(np.arange(len(possible)), GROUPS):
        if len(members):
            first, last = possible[members[0]], possible[members[-1]]
            low = max(first + min(0, int(offsets.min(initial=0))) - EMBARGO, 0)
            high = last + max(length, int(offsets.max(initial=0)) + 1) + EMBARGO
            groups.append((members, Span(int(low), int(min(high, len(rows))))))
    return PseudoGaps(possible, length, inside_offsets(length), offsets, tuple(groups))
