"""Hide what was recorded, fill it again by any method, and measure how far off that is."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from markermend.errors import BadInput
from markermend.model import FloatArray, Span, Take
from markermend.repairing.run import Wish, repair_all

Gap = tuple[int, Span]
"""Index of the marker, and the frames."""


@dataclass(frozen=True)
class Case:
    """A method with parameters, under the name that tables give it."""

    name: str
    method: str
    parameters: Mapping[str, Any] = field(default_factory=dict)


def complete_markers(take: Take) -> NDArray[np.intp]:
    """Give the measured markers that are seen in every frame."""
    return np.asarray(take.measured[take.seen[:, take.measured].all(axis=0)])


def spread_markers(take: Take, n: int) -> tuple[str, ...]:
    """Choose markers that are spread over the body, such as one for each limb.

    Each is the one farthest on average from the nearest of those chosen before; the first is the
    one nearest to the middle of all.

    Parameters
    ----------
    n
        How many; 0 takes all that are complete.

    Raises
    ------
    BadInput
        If fewer markers are seen throughout.
    """
    complete = complete_markers(take)
    if len(complete) < max(n, 4):
        raise BadInput(
            f"Only {len(complete)} markers are seen in every frame, and {max(n, 4)} are needed; "
            "give another take or ask for fewer markers."
        )
    if not n:
        return tuple(take.labels[m] for m in complete)
    some = take.positions[:: max(1, take.n_frames // 200)][:, complete]
    distance = np.linalg.norm(some[:, :, None] - some[:, None], axis=3).mean(axis=0)
    chosen = [int(distance.sum(axis=1).argmin())]
    while len(chosen) < n:
        chosen.append(int(distance[:, chosen].min(axis=1).argmax()))
    return tuple(take.labels[m] for m in complete[sorted(chosen)])


def only(take: Take, labels: Sequence[str], span: Span | None = None) -> Take:
    """Cut out some markers, and some frames."""
    frames = slice(None) if span is None else span.frames
    places = [take.index(label) for label in labels]
    return Take(take.positions[frames][:, places], take.rate, tuple(labels), take.units)


def hide(take: Take, gaps: Iterable[Gap]) -> Take:
    """Make gaps."""
    positions = take.positions.copy()
    for marker, span in gaps:
        positions[span.frames, marker] = np.nan
    return take.with_positions(positions)


def fill_gaps(
    gapped: Take, gaps: Sequence[Gap], case: Case, training: Sequence[Take] = ()
) -> list[FloatArray]:
    """Fill the gaps of a take one by one, with NaN where the method refuses.

    Returns
    -------
    One (len(span), n_dims) for each gap.
    """
    wishes = [
        Wish(gapped.labels[marker], span, method=case.method, parameters=case.parameters)
        for marker, span in gaps
    ]
    repairs, _ = repair_all(gapped, wishes, training)
    found = {(done.marker, done.span): done.values for done in repairs}
    return [
        np.asarray(
            found.get((wish.marker, wish.span), np.full((len(wish.span), gapped.n_dims), np.nan))
        )
        for wish in wishes
    ]


def distances(filled: Sequence[FloatArray], truth: FloatArray, gaps: Sequence[Gap]) -> FloatArray:
    """Measure how far each fill is from the truth, a (n_frames, n_markers, n_dims).

    Returns
    -------
    (n_gaps, 5) mm or px: the mean over the gap's frames (Li et al. 2020, Eq. 17), the root mean
    square, and the distance in the first, the middle and the last frame.
    """
    figures = np.empty((len(gaps), 5))
    for row, values, (marker, span) in zip(figures, filled, gaps, strict=True):
        off = np.linalg.norm(values - truth[span.frames, marker], axis=1)
        row[:] = off.mean(), np.sqrt(np.mean(off**2)), off[0], off[len(off) // 2], off[-1]
    return figures
