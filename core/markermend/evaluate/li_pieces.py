"""Pieces of takes with what there is to learn from, and the conditions of Li et al. 2020."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from markermend.errors import BadInput
from markermend.evaluate.hiding import Case, Gap, only, spread_markers
from markermend.evaluate.projection import openpose
from markermend.model import FloatArray, Span, Take

EMBARGO = 50
"""Frames on each side of a piece that are not learnt from."""

LENGTHS = (20, 50, 80, 100)
NUMBERS: Mapping[int, tuple[int, ...]] = {3: (1, 2, 3, 5, 8), 2: (2, 4, 5, 9, 13)}
BLACKOUTS = (0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.4)
"""Shares of a piece that are missing whole."""
ENERGIES = (0.9, 0.99, 0.999, 0.9999, 0.99999, 1.0)
RANKS = (1, 2, 4, 8, 16, 32)

LEARNING = tuple(Case(name, name) for name in ("li_eq4", "li_eq8"))
COMPARED = tuple(
    Case(name, name) for name in ("wpca", "lgrnn", "glr", "lpr", "li", "pma", "spline", "auto")
)
BY_RANK = tuple(Case(f"li_eq16 rank {rank}", "li_eq16", {"rank": rank}) for rank in RANKS)
CHOSEN = Case("li_eq16", "li_eq16")
BRIDGES = (
    CHOSEN,
    Case("li_eq16 W = 1", "li_eq16", {"weighting": "none"}),
    *BY_RANK,
    *(Case(name, name) for name in ("li_eq8", "spline", "auto")),
)
BY_ENERGY = tuple(
    Case(f"{name} energy {share:g}", name, {"cumulative": share})
    for name in ("li_eq4", "li_eq8")
    for share in ENERGIES
)


@dataclass(frozen=True, eq=False)
class Piece:
    """A stretch of a take.

    Attributes
    ----------
    seen, truth
        The stretch, and (n_frames, n_markers, n_dims) without a camera's errors.
    training
        Takes to learn from.
    whole, start
        The take that it comes from, and its first frame in there.
    """

    seen: Take
    truth: FloatArray
    training: tuple[Take, ...]
    whole: Take
    start: int


@dataclass(frozen=True)
class Condition:
    """What is hidden, and who fills it; see `markermend.evaluate.li_tables.Row`."""

    figure: str
    setting: str
    x: float
    gaps: tuple[Gap, ...]
    cases: tuple[Case, ...]
    whole: bool = False


def starts_of(takes: Sequence[Take], n: int, frames: int, seed: int) -> tuple[tuple[int, int], ...]:
    """Draw pieces that do not overlap.

    Returns
    -------
    For each the take and the first frame, in order.

    Raises
    ------
    BadInput
        If the takes do not hold so many.
    """
    rng = np.random.default_rng((seed, 1))
    slots = []
    for i, take in enumerate(takes):
        whole, rest = divmod(take.n_frames, frames)
        first = int(rng.integers(rest + 1))
        slots += [(i, first + k * frames) for k in range(whole)]
    if len(slots) < n:
        raise BadInput(
            f"The takes hold {len(slots)} pieces of {frames} frames, and {n} are wanted; give "
            "longer takes or ask for fewer pieces."
        )
    return tuple(sorted(slots[k] for k in rng.permutation(len(slots))[:n]))


def pieces_of(
    takes: Sequence[Take],
    training: Sequence[Take],
    starts: Sequence[tuple[int, int]],
    frames: int,
    *,
    dims: int,
    markers: int,
    seed: int,
) -> list[Piece]:
    """Cut out pieces, each with the given training set, or else with all that is not near it.

    Parameters
    ----------
    dims
        3 for the markers themselves, 2 for their projection.
    markers
        Size of the set in three dimensions, spread over the body; 0 for all.

    Raises
    ------
    BadInput
        If takes differ in rate or lack markers, or one of the markers is not seen throughout.
    """
    everything = [*takes, *training]
    if any(not np.isclose(take.rate, takes[0].rate) for take in everything):
        raise BadInput("Takes of different rates cannot be learnt from; give takes of one rate.")
    if dims == 3:
        labels = spread_markers(takes[0], markers)
        views = [only(take, labels) for take in everything]
        truths = [view.positions for view in views]
    else:
        seeds = np.random.SeedSequence((seed, 2)).generate_state(len(everything))
        both = [openpose(t, seed=int(s)) for t, s in zip(everything, seeds, strict=True)]
        views, truths = [seen for seen, _ in both], [truth for _, truth in both]
    if any(not np.isfinite(truth).all() for truth in truths[: len(takes)]):
        raise BadInput("A marker is not seen throughout; give takes without gaps.")
    pieces = []
    for i, start in starts:
        span = Span(start, start + frames)
        learnt = tuple(views[len(takes) :]) or _elsewhere(views, i, span)
        seen = only(views[i], views[i].labels, span)
        pieces.append(Piece(seen, truths[i][span.frames], learnt, views[i], start))
    return pieces


def _elsewhere(views: Sequence[Take], own: int, span: Span) -> tuple[Take, ...]:
    """Give all takes without the piece and its surroundings."""
    take = views[own]
    rest = [Span(0, max(1, span.start - EMBARGO))]
    if span.stop + EMBARGO < take.n_frames:
        rest.append(Span(span.stop + EMBARGO, take.n_frames))
    parts = [only(take, take.labels, part) for part in rest if len(part) > EMBARGO]
    return (*parts, *(view for i, view in enumerate(views) if i != own))


def conditions(dims: int, n_markers: int, frames: int, rate: float, whole: bool) -> list[Condition]:
    """Give the conditions of the paper, for pieces of `frames` frames.

    Parameters
    ----------
    whole
        Whether the compared methods are to see whole takes too.
    """
    wanted: list[Condition] = []
    if dims == 3:
        for length in LENGTHS:
            gaps = even_gaps(n_markers, frames, 5, length)
            one = ("Table 1, Fig. 3 and 4", f"{length} frames", length, gaps)
            wanted.append(Condition(*one, (*LEARNING, *COMPARED)))
            if whole:
                wanted.append(Condition(*one, COMPARED, whole=True))
    half = Span(frames // 2, frames)
    for number in NUMBERS[dims]:
        if number < n_markers:
            gaps = tuple((marker, half) for marker in _evenly(n_markers, number))
            setting = f"{number} gaps ({50 * number / n_markers:.1f} %)"
            cases = (*LEARNING, Case("wpca", "wpca"), Case("auto", "auto"))
            name = "Table 2" if dims == 3 else "Table 3"
            wanted.append(Condition(name, setting, number, gaps, cases))
    gaps = even_gaps(n_markers, frames, 5, 50)
    wanted.append(Condition("Error by rank", "50 frames", 50, gaps, BY_ENERGY))
    for share in BLACKOUTS:
        length = round(share * frames)
        gaps = tuple((marker, _middle(frames, length)) for marker in range(n_markers))
        setting = f"{100 * share:g} % ({length / rate:.2f} s)"
        wanted.append(Condition("Blackouts, Fig. 6 to 8, 10, 11", setting, share, gaps, BRIDGES))
    for number in sorted({1, *_evenly(n_markers - 1, 5)[1:]}):
        gaps = tuple((marker, _middle(frames, 30)) for marker in range(number))
        one = ("Fig. 9", f"{number} markers", number, gaps)
        wanted.append(Condition(*one, (LEARNING[0], CHOSEN)))
    gaps = tuple((marker, _middle(frames, 30)) for marker in range(n_markers))
    wanted.append(Condition("Fig. 9", f"all {n_markers}", n_markers, gaps, (CHOSEN,)))
    return wanted


def even_gaps(n_markers: int, frames: int, number: int, length: int) -> tuple[Gap, ...]:
    """Spread gaps evenly over markers and time (Fig. 2)."""
    free = frames - length
    return tuple(
        (marker, Span(start, start + length))
        for k, marker in enumerate(_evenly(n_markers, number))
        for start in [round(free * (k + 0.5) / number)]
    )


def _evenly(n: int, number: int) -> list[int]:
    return [int(k) for k in np.linspace(0, n - 1, number).round()]


def _middle(frames: int, length: int) -> Span:
    start = (frames - length) // 2
    return Span(start, start + length)
