"""The experiment of Li et al. 2020: gaps and blackouts filled by eigenspaces that were learnt."""

import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from threadpoolctl import threadpool_limits

from markermend.errors import BadInput
from markermend.evaluate.hiding import Case, distances, fill_gaps, hide, only
from markermend.evaluate.li_pieces import (
    CHOSEN,
    COMPARED,
    LEARNING,
    Condition,
    Piece,
    conditions,
    even_gaps,
    pieces_of,
    starts_of,
)
from markermend.evaluate.li_tables import Li, Row, Sample, Timing, Weighting
from markermend.evaluate.parallel import in_order
from markermend.evaluate.projection import LOST, NOISE_PX
from markermend.model import FloatArray, Span, Take
from markermend.repairing.eigenspace import chosen, nearness, piece
from markermend.repairing.methods.li_eq16 import RANKS
from markermend.repairing.run import Wish, pose
from markermend.repairing.window import window

FRAMES = 200
TRAINED_ON = (500, 800, 1000, 1500, 2000, 2500)
CONTEXT = 50
"""Frames before and after a blackout that Eq. 16 fits, its default."""
PROJECTED = (
    f"no recording: markers projected by a pinhole camera onto OpenPose's 25 points, with "
    f"{NOISE_PX:g} px of noise and {100 * LOST:g} % drop-outs; errors to the points without noise"
)


@dataclass(frozen=True, eq=False)
class _Task:
    piece: Piece
    condition: Condition


@dataclass(frozen=True, eq=False)
class _Result:
    """Figures (n_cases, n_gaps, 5), the fills by case, and the rank and scale for a blackout."""

    figures: FloatArray
    fills: list[list[FloatArray]]
    choice: tuple[int, int] | None


def li(
    takes: Sequence[Take],
    training: Sequence[Take] = (),
    *,
    dims: Sequence[int] = (3, 2),
    markers: int = 15,
    pieces: int = 20,
    figures: Sequence[str] = (),
    times: bool = True,
    jobs: int = 1,
    seed: int = 0,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Li:
    """Hide gaps and blackouts in pieces of 200 frames, and fill them with and without learning.

    Parameters
    ----------
    takes
        Takes of the same markers without gaps, from which pieces that do not overlap are drawn.
    training
        Takes to learn from; without any, all of `takes` but the piece and half a second around it.
        The compared methods are then given whole takes in addition, so that all see the same.
    dims
        3, 2 or both; two dimensions are a projection, see `markermend.evaluate.projection`.
    markers
        Size of the set in three dimensions, spread over the body, 15 as in the paper; 0 for all.
    pieces
        How many.
    figures
        Only conditions in whose name one of these words occurs, such as ``Blackouts``.
    times
        Whether to measure running times (Table 4), the only figures that differ between runs.
    jobs, seed, progress
        As in `markermend.evaluate.e1`; a task is one piece under one condition.

    Raises
    ------
    BadInput
        If the takes hold too few pieces or markers, or nothing is left to do.

    Notes
    -----
    Li et al., IEEE Access 8:76980, 2020, section IV; errors by Eq. 17 with the plain mean over a
    gap's frames.  Gaps of Table 2 and 3 run to the end of a piece.  The weights W are those of
    Eq. 13 among weights that fall off with the distance to the blackout.
    """
    if not takes or pieces < 1 or not dims or any(d not in (2, 3) for d in dims):
        raise BadInput("Nothing to fill; give a take, a piece, and 2 or 3 dimensions.")
    if 0 < markers < 6:
        raise BadInput(f"The tables need at least 6 markers; got {markers}.")
    starts = starts_of(takes, pieces, FRAMES, seed)
    rate = takes[0].rate
    plan: list[tuple[int, list[Piece], Condition]] = []
    for d in dims:
        cut = pieces_of(takes, training, starts, FRAMES, dims=d, markers=markers, seed=seed)
        plan += [
            (d, cut, condition)
            for condition in conditions(d, cut[0].seen.n_markers, FRAMES, rate, not training)
            if not figures or any(word.lower() in condition.figure.lower() for word in figures)
        ]
    if not plan:
        raise BadInput(f"No table or figure is named {', '.join(figures)}; try Table or Fig.")
    tasks = [_Task(one, condition) for _, cut, condition in plan for one in cut]
    results = in_order(_measure, tasks, jobs, lambda done: progress(done, len(tasks)))
    rows: list[Row] = []
    weights: list[Weighting] = []
    samples: list[Sample] = []
    for d, cut, condition in plan:
        some = [next(results) for _ in cut]
        rows += _rows(d, cut[0].seen.labels, condition, some)
        samples += _samples(d, cut[0], condition, some[0])
        choices = [one.choice for one in some if one.choice is not None]
        if choices:
            weights.append(weighting(d, condition, choices))
    solid = [cut for d, cut, _ in plan if d == 3]
    return Li(
        seed=seed,
        rate=rate,
        pieces=pieces,
        piece_frames=FRAMES,
        starts=starts,
        labels=plan[0][1][0].seen.labels,
        projected=PROJECTED if 2 in dims else "",
        rows=tuple(rows),
        weights=tuple(weights),
        samples=tuple(samples),
        times=_times(solid[0][0]) if times and solid else (),
    )


def _measure(task: _Task) -> _Result:
    one, condition = task.piece, task.condition
    take, training, first = one.seen, one.training, 0
    if condition.whole:
        take, training, first = one.whole, (), one.start
    gaps = [(m, Span(s.start + first, s.stop + first)) for m, s in condition.gaps]
    gapped = hide(take, gaps)
    fills = [fill_gaps(gapped, gaps, case, training) for case in condition.cases]
    figures = np.stack([distances(fill, one.truth, condition.gaps) for fill in fills])
    kept = fills if condition.figure == "Table 2" or _blackout(condition) else []
    return _Result(figures, kept, _choice(gapped, task) if _blackout(condition) else None)


def _blackout(condition: Condition) -> bool:
    return condition.figure.startswith("Blackouts")


def _choice(gapped: Take, task: _Task) -> tuple[int, int]:
    """Give the rank and the index of the weights that `CHOSEN` takes for the first marker."""
    marker, span = task.condition.gaps[0]
    problem = pose(gapped, Wish(gapped.labels[marker], span), training=task.piece.training)
    around = piece(problem, window(problem), CONTEXT)
    return chosen(around.training, around.missing, RANKS, around.weights)


def _rows(
    dims: int, labels: Sequence[str], condition: Condition, results: Sequence[_Result]
) -> list[Row]:
    given = "whole takes" if condition.whole else "pieces (and training where learnt)"
    rows = []
    for i, case in enumerate(condition.cases):
        figures = np.stack([one.figures[i] for one in results])  # (n_pieces, n_gaps, 5)
        pieces = [_mean(one[:, 0]) for one in figures]
        known = np.array([value for value in pieces if value is not None])
        square = _mean(figures[:, :, 1] ** 2)
        first, middle, last = (_mean(figures[:, :, k]) for k in (2, 3, 4))
        rows.append(
            Row(
                condition.figure,
                dims,
                given,
                condition.setting,
                float(condition.x),
                case.name,
                gaps=figures[:, :, 0].size,
                refused=int(np.isnan(figures[:, :, 0]).sum()),
                mean=_mean(known),
                sd=float(known.std()) if len(known) else None,
                rmse=None if square is None else float(np.sqrt(square)),
                first=first,
                middle=middle,
                last=last,
                pieces=tuple(pieces),
                markers={
                    labels[marker]: _mean(figures[:, g, 0])
                    for g, (marker, _) in enumerate(condition.gaps)
                }
                if _blackout(condition)
                else {},
            )
        )
    return rows


def _mean(values: FloatArray) -> float | None:
    known = values[np.isfinite(values)]
    return float(known.mean()) if known.size else None


def _samples(dims: int, one: Piece, condition: Condition, result: _Result) -> list[Sample]:
    """Give the trajectories of Fig. 5, and the first, middle and last frames of Figs. 10 and 11."""
    wanted = LEARNING[0] if condition.figure == "Table 2" and condition.x == 5 else CHOSEN
    if wanted not in condition.cases or not result.fills:
        return []
    samples = []
    fills = result.fills[condition.cases.index(wanted)]
    for (marker, span), values in zip(condition.gaps, fills, strict=True):
        if not np.isfinite(values).all():
            continue
        n = len(span)
        some = [0, n // 2, n - 1] if _blackout(condition) else list(range(n))
        samples.append(
            Sample(
                "Fig. 10 and 11" if _blackout(condition) else "Fig. 5",
                dims,
                condition.setting,
                wanted.name,
                one.seen.labels[marker],
                tuple(span.start + k for k in some),
                _numbers(one.truth[span.frames, marker][some]),
                _numbers(values[some]),
            )
        )
    return samples


def _numbers(values: FloatArray) -> tuple[tuple[float, ...], ...]:
    return tuple(tuple(round(x, 3) for x in row) for row in values.tolist())


def weighting(dims: int, condition: Condition, choices: Sequence[tuple[int, int]]) -> Weighting:
    """Summarise the ranks and indices of weights chosen for the blackouts of one length."""
    ranks, indices = zip(*choices, strict=True)
    _, span = condition.gaps[0]
    around = Span(max(0, span.start - CONTEXT), span.stop + CONTEXT)
    candidates = nearness(around, span)
    before = [weights[: span.start - around.start] for weights in candidates]
    scales = [None if np.ptp(w) == 0 else 1.0 / float(np.log(w[-1] / w[-2])) for w in before]
    usual = before[Counter(indices).most_common(1)[0][0]]
    return Weighting(
        dims,
        condition.setting,
        tuple(None if scale is None else round(scale, 1) for scale in scales),
        tuple(ranks),
        tuple(indices),
        tuple(float(w) for w in usual / usual.max()),
    )


def _times(one: Piece) -> tuple[Timing, ...]:
    gaps = even_gaps(one.seen.n_markers, FRAMES, 5, 50)
    gapped = hide(one.seen, gaps)
    longest = max(one.training, key=lambda take: take.n_frames)
    found = []
    for n in TRAINED_ON:
        if n <= longest.n_frames:
            learnt = (only(longest, longest.labels, Span(0, n)),)
            found.append(Timing("li_eq4", n, _seconds(gapped, gaps, LEARNING[0], learnt)))
    found += [Timing(case.name, 0, _seconds(gapped, gaps, case, ())) for case in COMPARED]
    return tuple(found)


def _seconds(
    gapped: Take, gaps: Sequence[tuple[int, Span]], case: Case, training: Sequence[Take]
) -> float:
    spent = []
    with threadpool_limits(1):
        for _ in range(3):
            start = time.perf_counter()
            fill_gaps(gapped, gaps, case, training)
            spent.append(time.perf_counter() - start)
    return min(spent)
