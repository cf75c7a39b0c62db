"""Where the artefacts of an exercise go."""

from collections.abc import Sequence

import numpy as np

from markermend.errors import BadInput
from markermend.model import AXES, Kind, Span, Take
from markermend.truth import Truth

SPREAD = 0.4
"""Standard deviation of the size, as a share of its mean (Skurowski & Pawlyta, section 4.1.3)."""
LEAST = 0.5
"""No artefact is smaller than this share of the mean: it would belong to another level."""
MEAN_LENGTH_S = 0.5
LEAST_LENGTH_S = 0.2
GUARD_S = 0.3
"""Seconds around an artefact in which its marker is seen and has nothing else wrong with it."""
TRIES = 200


def plan(
    take: Take, kinds: Sequence[Kind], count: int, amplitude_mm: float, rng: np.random.Generator
) -> tuple[Truth, ...]:
    """Draw artefacts: kinds in turn, markers and places at random, one at a time on each marker.

    Parameters
    ----------
    take
        The take without artefacts; artefacts go where a measured marker is seen.
    kinds, count, amplitude_mm
        What is wanted, how many, and their mean size.
    rng
        Source of all that is random.

    Raises
    ------
    BadInput
        If the take has no room for so many.
    """
    if not len(take.measured):
        raise BadInput("The take has no measured marker to put artefacts on; give another take.")
    free = take.seen.copy()
    order = [kinds[i % len(kinds)] for i in range(count)]
    placed: list[Truth] = []
    for kind in order:
        length = _length(kind, take.rate, rng)
        place = _place(take, free, length, rng)
        if place is None:
            raise BadInput(
                f"The take has room for {len(placed)} artefacts of the {count} that were asked "
                "for; lower --density, or give a longer take."
            )
        marker, span = place
        guard = round(GUARD_S * take.rate)
        free[span.padded(guard, take.n_frames).frames, marker] = False
        placed.append(_truth(take, marker, span, kind, amplitude_mm, rng))
    return tuple(placed)


def _length(kind: Kind, rate: float, rng: np.random.Generator) -> int:
    if kind == "peak":
        return int(rng.integers(1, 3))
    mean = MEAN_LENGTH_S * rate
    return max(round(LEAST_LENGTH_S * rate), 3, int(rng.poisson(mean)))


def _place(
    take: Take, free: np.ndarray, length: int, rng: np.random.Generator
) -> tuple[int, Span] | None:
    guard = round(GUARD_S * take.rate)
    last = take.n_frames - guard - length
    if last < guard:
        return None
    for _ in range(TRIES):
        marker = int(rng.choice(take.measured))
        start = int(rng.integers(guard, last + 1))
        if free[start - guard : start + length + guard, marker].all():
            return marker, Span(start, start + length)
    return None


def _truth(
    take: Take, marker: int, span: Span, kind: Kind, mean_mm: float, rng: np.random.Generator
) -> Truth:
    if kind == "gap":
        return Truth(take.labels[marker], span, kind)
    size = max(float(rng.normal(mean_mm, SPREAD * mean_mm)), LEAST * mean_mm)
    names = AXES[: take.n_dims]
    # One axis, as where one camera errs, or all of them, as where a marker is mistaken.
    axes = names if rng.random() < 0.5 else (names[int(rng.integers(take.n_dims))],)
    return Truth(take.labels[marker], span, kind, round(size, 3), axes)
