"""Put artefacts of known place, kind and size into a take."""

from collections.abc import Iterable
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from markermend.errors import BadInput, UnknownName
from markermend.model import AXES, BoolArray, FloatArray, Kind, Span, Take
from markermend.truth import Truth

MEAN_LENGTH = 50
"""Frames at 100 Hz that a bulk artefact lasts on average."""
SPREAD = 0.4
"""Standard deviation of the amplitude, as a share of its mean."""

BULK: tuple[Kind, ...] = ("noise", "step", "slow")


def contaminate(
    take: Take,
    kinds: Iterable[str] = ("peak", "noise", "step", "slow"),
    *,
    amplitude_mm: float = 10.0,
    share: float = 0.1,
    seed: int = 0,
    axes: Literal["one", "all"] = "one",
) -> tuple[Take, tuple[Truth, ...]]:
    """Distort a take at random places, and say where.

    Parameters
    ----------
    take
        The take, best one without artefacts.
    kinds
        The kinds to put in: peak, noise, step, slow.
    amplitude_mm
        Mean amplitude; its standard deviation is 0.4 of it.
    share
        Share of the frames that each kind takes.
    seed
        Of the random numbers; the same seed gives the same result.
    axes
        ``"one"`` distorts one axis of the marker, drawn at random, as the paper does; ``"all"``
        distorts all with the same sign and amplitude.

    Returns
    -------
    The distorted take, and what was put in, in the order of time.

    Raises
    ------
    UnknownName
        If a kind is unknown or cannot be put in.
    BadInput
        If the shares of all kinds do not fit into the take one at a time.

    Notes
    -----
    Skurowski & Pawlyta, section 4.1.3: bulk distortions (noise, step, slow) first, single peaks in
    the frames left; one distortion at a time; sign +1 or -1, amplitude N(mu, 0.4 mu), durations
    Poisson with mean 50 at 100 Hz, intervals those of a Poisson process that fills the take.  A
    slow change is a triangle, a step a rectangle, heavy noise is white, a peak is one frame.  A
    distortion is put on a marker that is seen throughout; where no marker is, it is left out.
    """
    wanted = _wanted(kinds)
    if not share > 0.0 or share * len(wanted) > 0.9:
        raise BadInput(
            f"share must be above 0 and at most {0.9 / max(len(wanted), 1):.3g} for "
            f"{len(wanted)} kinds; got {share}."
        )
    if not amplitude_mm > 0.0:
        raise BadInput(f"amplitude_mm must be a positive number of mm; got {amplitude_mm}.")
    rng = np.random.default_rng(seed)
    plan = _plan(take, wanted, share, rng)
    positions = take.positions.copy()
    seen = take.seen[:, take.measured]
    busy = np.zeros(seen.shape, bool)
    truths = []
    for span, kind in plan:
        marker = _draw_marker(span, seen, busy, rng)
        amplitude = float(rng.normal(amplitude_mm, SPREAD * amplitude_mm))
        sign = int(rng.choice((-1, 1))) * (1 if amplitude >= 0.0 else -1)
        axis = int(rng.integers(take.n_dims))
        chosen = [axis] if axes == "one" else list(range(take.n_dims))
        if marker is None:
            continue
        busy[span.padded(1, take.n_frames).frames, marker] = True
        index = int(take.measured[marker])
        for a in chosen:
            positions[span.frames, index, a] += sign * abs(amplitude) * _shape(kind, span, rng)
        names = tuple(AXES[a] for a in chosen)
        truths.append(Truth(take.labels[index], span, kind, abs(amplitude), names, sign=sign))
    return take.with_positions(positions), tuple(sorted(truths, key=lambda truth: truth.span))


def _wanted(kinds: Iterable[str]) -> tuple[Kind, ...]:
    known: tuple[Kind, ...] = ("peak", *BULK)
    given = tuple(kinds)
    for kind in given:
        if kind not in known:
            raise UnknownName.among("kind to put in", kind, known)
    if not given:
        raise BadInput("kinds is empty; name at least one of peak, noise, step, slow.")
    return tuple(kind for kind in known if kind in given)


def _plan(
    take: Take, kinds: tuple[Kind, ...], share: float, rng: np.random.Generator
) -> list[tuple[Span, Kind]]:
    """Draw places in time, one at a time: bulk first, then peaks in the frames left."""
    n_each = round(share * take.n_frames)
    mean = MEAN_LENGTH * take.rate / 100.0
    bulk = [
        (length, kind) for kind in BULK if kind in kinds for length in _lengths(n_each, mean, rng)
    ]
    rng.shuffle(bulk)
    n_free = take.n_frames - sum(length for length, _ in bulk)
    # A Poisson process given its number of events: the cuts of the free time are uniform.
    cuts = np.sort(rng.integers(0, n_free + 1, len(bulk)))
    plan: list[tuple[Span, Kind]] = []
    free = np.ones(take.n_frames, bool)
    used = 0
    for cut, (length, kind) in zip(cuts.tolist(), bulk, strict=True):
        span = Span(cut + used, cut + used + length)
        used += length
        free[span.frames] = False
        plan.append((span, kind))
    if "peak" in kinds:
        frames = rng.permutation(np.flatnonzero(free))[:n_each]
        plan += [(Span(int(frame), int(frame) + 1), "peak") for frame in frames]
    return plan


def _lengths(total: int, mean: float, rng: np.random.Generator) -> list[int]:
    """Draw Poisson durations until they fill `total`; the last takes what is left."""
    lengths: list[int] = []
    left = total
    while left > 0:
        length = max(1, int(rng.poisson(mean)))
        # No remainder so short that it would be another kind of artefact.
        if left - length < mean / 2.0:
            length = left
        lengths.append(length)
        left -= length
    return lengths


def _draw_marker(
    span: Span, seen: BoolArray, busy: BoolArray, rng: np.random.Generator
) -> int | None:
    """Draw a marker that is seen throughout and has nothing in or beside the span."""
    around = span.padded(1, len(seen)).frames
    able: NDArray[np.intp] = np.flatnonzero(seen[around].all(axis=0) & ~busy[around].any(axis=0))
    return int(rng.choice(able)) if len(able) else None


def _shape(kind: Kind, span: Span, rng: np.random.Generator) -> FloatArray:
    """Give the distortion of unit amplitude."""
    n = len(span)
    if kind == "noise":
        return rng.standard_normal(n)
    if kind == "slow":
        middle = (n - 1) / 2.0
        triangle: FloatArray = 1.0 - np.abs(np.arange(n) - middle) / (middle + 1.0)
        return triangle
    return np.ones(n)
