"""Which of two people's spans, or of a person's and the truth, mean the same thing."""

from collections.abc import Sequence
from typing import Protocol

from markermend.model import Span

IOU = 0.5
"""Overlap from which two spans count as one, where nothing else is said."""


class Placed(Protocol):
    """Anything with a marker and a span: a finding, a truth."""

    @property
    def marker(self) -> str:
        """Label of the marker."""

    @property
    def span(self) -> Span:
        """Where it is."""


def overlap(one: Span, other: Span, slack: int = 0) -> float:
    """Give intersection over union after both spans are widened by `slack` frames on each side.

    A peak of one frame that somebody marks with three is the same peak, though the plain value is
    a third; on spans of many frames a slack of one or two changes nothing.  Spans that have no
    frame in common, give 0.
    """
    if not one.overlaps(other):
        return 0.0
    both = min(one.stop, other.stop) - max(one.start, other.start) + 2 * slack
    return both / (len(one) + len(other) + 4 * slack - both)


def pairs(
    first: Sequence[Placed], second: Sequence[Placed], least: float = IOU, slack: int = 0
) -> dict[int, int]:
    """Match two lists one to one: same marker, `overlap` of at least `least`, best first.

    Equal overlaps are matched in the order of the lists.

    Returns
    -------
    Index in `first` -> index in `second`.
    """
    by_marker: dict[str, list[int]] = {}
    for j, item in enumerate(second):
        by_marker.setdefault(item.marker, []).append(j)
    candidates = sorted(
        (-share, i, j)
        for i, item in enumerate(first)
        for j in by_marker.get(item.marker, ())
        if (share := overlap(item.span, second[j].span, slack)) >= least
    )
    matched: dict[int, int] = {}
    taken: set[int] = set()
    for _, i, j in candidates:
        if i not in matched and j not in taken:
            matched[i] = j
            taken.add(j)
    return matched
