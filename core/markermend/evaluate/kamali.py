"""The experiment of Kamali et al. 2020: gaps in periodic gait, filled by low rank and sparsity."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import wilcoxon

from markermend.errors import BadInput
from markermend.evaluate.cycles import cycle_of
from markermend.evaluate.hiding import (
    Case,
    Gap,
    distances,
    fill_gaps,
    hide,
    only,
    spread_markers,
)
from markermend.evaluate.kamali_splits import Split, splits
from markermend.evaluate.kamali_tables import Cell, Example, Kamali, Pair, Point, ordering
from markermend.evaluate.parallel import in_order
from markermend.model import FloatArray, Span, Take
from markermend.repairing.lowrank import (
    Solved,
    by_truncated_norm,
    sparse_solver,
)
from markermend.repairing.run import REPAIRS

WEIGHTS = (0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0)
"""Values of lambda; with 0 it is the nuclear norm alone."""
SPARSE = ("gslr", "slr")
MATRIX = (*SPARSE, "svt", "tnn")
"""Methods that fill all gaps of a matrix at once."""
METHODS = (*MATRIX, "wpca", "pca_r1", "spline", "auto")
TESTED = (
    ("gslr", "slr"), ("gslr", "svt"), ("slr", "svt"), ("gslr", "wpca"), ("slr", "wpca"),
    ("auto", "gslr"),
)  # fmt: skip
"""Pairs that are compared: what the paper says, and the default against the paper's best."""
GAPS, SHARES = (5, 20), (0.1, 0.5)
"""Number of gaps in a mask, and their length as a share of a cycle: least and most."""
ITERATIONS, TOLERANCE = 1500, 1e-5
"""Of the solvers: tight, as their residual is a share of all that is seen and gaps are few."""


@dataclass(frozen=True, eq=False)
class _Task:
    window: Take
    gaps: tuple[Gap, ...]
    runs: tuple[tuple[str, float | None], ...]


@dataclass(frozen=True, eq=False)
class _Filled:
    """What one method made of one mask: (n_gaps, 5) figures, the fills, and if it converged."""

    figures: FloatArray
    values: list[FloatArray]
    converged: bool


def kamali(
    takes: Mapping[str, Take],
    *,
    markers: Sequence[int] = (37, 11),
    methods: Sequence[str] = METHODS,
    weights: Sequence[float] = WEIGHTS,
    masks: int = 20,
    sweep_masks: int = 5,
    cycles: int = 10,
    cycle_s: float | None = None,
    jobs: int = 1,
    seed: int = 0,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Kamali:
    """Hide parts of gait, fill them, and compare methods over many masks.

    Parameters
    ----------
    takes
        Takes by the names that tables give them; periodic ones meet the paper's premise.
    markers
        Sizes of the sets of markers, which are spread over the body; 11 is one for each limb.
    methods
        Names of registered repairs; those in `MATRIX` see all gaps of a mask at once.
    weights
        Values of lambda to try, on masks that are used for nothing else; the best goes on.
    masks, sweep_masks
        Masks for the comparison and for the choice of lambda, on each take and set of markers.
    cycles
        Cycles in a window, at most as many as a take holds.
    cycle_s
        Length of a cycle in s, for takes that do not repeat; by default it is estimated.
    jobs, seed, progress
        As in `markermend.evaluate.e1`; a task is one mask.

    Raises
    ------
    BadInput
        If a take has too few complete markers or cycles, or there is nothing to do.
    UnknownName
        If a method is unknown.

    Notes
    -----
    Kamali et al., Sensors 20(16):4525, 2020, section 2.3: 5 to 20 gaps of 10 to 50 % of a cycle at
    random on random markers; each coordinate counts from its own mean; windows hold whole cycles.
    The error is the Euclidean distance between recovered and true position (Eq. 16), averaged over
    a mask. Tests are paired over masks, since gaps of one mask are not independent.
    """
    if not (takes and markers and methods and weights) or min(masks, sweep_masks) < 1:
        raise BadInput("Nothing to fill; give a take, a number of markers, a method and a mask.")
    if min(markers) < 4 or cycles < 1:
        raise BadInput("Give at least 4 markers and 1 cycle.")
    if min(weights) < 0.0:
        raise BadInput(f"A weight must be 0 or more; got {min(weights):g}.")
    for name in methods:
        REPAIRS.get(name)
    found = {name: cycle_of(take, cycle_s) for name, take in takes.items()}
    settings = [(name, n) for name in takes for n in markers]
    labels = {name: {n: spread_markers(takes[name], n) for n in markers} for name in takes}
    held = {
        name: min(cycles, int(take.duration_s / found[name].seconds))
        for name, take in takes.items()
    }

    def task(name: str, n: int, mask: int, runs: Sequence[tuple[str, float | None]]) -> _Task:
        rng = np.random.default_rng((seed, mask, n, *name.encode()))
        size = round(held[name] * found[name].seconds * takes[name].rate)
        start = int(rng.integers(takes[name].n_frames - size + 1))
        window = only(takes[name], labels[name][n], Span(start, start + size))
        gaps = draw_gaps(window, found[name].seconds * window.rate, rng)
        return _Task(window, gaps, tuple(runs))

    tried = [(name, w) for name in SPARSE if name in methods for w in weights]
    total = len(settings) * (masks + (sweep_masks if tried else 0))
    sweep: list[Point] = []
    if tried:
        tasks = [task(*s, 10_000 + mask, tried) for s in settings for mask in range(sweep_masks)]
        results = in_order(_fill, tasks, jobs, lambda done: progress(done, total))
        for setting in settings:
            some = [next(results) for _ in range(sweep_masks)]
            for i, (method, weight) in enumerate(tried):
                means = np.array([one[i].figures[:, 0].mean() for one in some])
                sweep.append(
                    Point(
                        *setting, method, weight, sweep_masks, float(means.mean()),
                        float(means.std()),
                    )
                )  # fmt: skip
    chosen = {setting: _chosen(setting, methods, sweep) for setting in settings}
    tasks = [task(*s, mask, chosen[s]) for s in settings for mask in range(masks)]
    done_before = total - len(tasks)
    results = in_order(_fill, tasks, jobs, lambda done: progress(done_before + done, total))
    cells: list[Cell] = []
    pairs: list[Pair] = []
    by_class: list[Split] = []
    orderings, examples = [], []
    for k, setting in enumerate(settings):
        some = [next(results) for _ in range(masks)]
        here = [
            _cell(*setting, run, [one[i] for one in some]) for i, run in enumerate(chosen[setting])
        ]
        place = {run[0]: i for i, run in enumerate(chosen[setting])}
        cycle = found[setting[0]].seconds * takes[setting[0]].rate
        made = tasks[k * masks : (k + 1) * masks]
        shares = [np.array([len(span) / cycle for _, span in one.gaps]) for one in made]
        for method, i in place.items():
            by_class += splits(*setting, method, [one[i].figures[:, 0] for one in some], shares)
        tests = [
            _pair(*setting, a, b, [(one[place[a]], one[place[b]]) for one in some])
            for a, b in TESTED
            if a in place and b in place
        ]
        orderings.append(ordering(*setting, here, tests))
        if "gslr" in place:
            examples += _examples(setting[0], tasks[k * masks], some[0][place["gslr"]])
        cells += here
        pairs += tests
    return Kamali(
        seed=seed,
        masks=masks,
        cycles_in_window=held,
        cycles=found,
        labels={name: {str(n): some for n, some in sets.items()} for name, sets in labels.items()},
        cells=tuple(cells),
        pairs=tuple(pairs),
        sweep=tuple(sweep),
        orderings=tuple(orderings),
        examples=tuple(examples),
        splits=tuple(by_class),
    )


def draw_gaps(take: Take, cycle: float, rng: np.random.Generator) -> tuple[Gap, ...]:
    """Draw the gaps of one mask; those of one marker stay apart, and none touches an end.

    Parameters
    ----------
    cycle
        Its length in frames.
    """
    wanted = int(rng.integers(GAPS[0], GAPS[1] + 1))
    gaps: list[Gap] = []
    for _ in range(100 * wanted):
        if len(gaps) == wanted:
            break
        length = max(1, round(float(rng.uniform(*SHARES)) * cycle))
        marker = int(rng.integers(take.n_markers))
        start = int(rng.integers(1, take.n_frames - length))
        span = Span(start, start + length)
        near = span.padded(round(0.1 * cycle) + 1, take.n_frames)
        if not any(marker == m and near.overlaps(other) for m, other in gaps):
            gaps.append((marker, span))
    return tuple(sorted(gaps))


def _fill(task: _Task) -> list[_Filled]:
    gapped = hide(task.window, task.gaps)
    return [_one(task, gapped, *run) for run in task.runs]


def _one(task: _Task, gapped: Take, method: str, weight: float | None) -> _Filled:
    converged = True
    if method in MATRIX:
        values, converged = complete(gapped, task.gaps, method, weight)
    else:
        values = fill_gaps(gapped, task.gaps, Case(method, method))
    return _Filled(distances(values, task.window.positions, task.gaps), values, converged)


def complete(
    gapped: Take, gaps: Sequence[Gap], method: str, weight: float | None
) -> tuple[list[FloatArray], bool]:
    """Fill all gaps at once by completing the matrix of all trajectories.

    Parameters
    ----------
    method
        One of `MATRIX`.
    weight
        Lambda, for the sparse ones.

    Returns
    -------
    The fills, and whether the solver converged.
    """
    data = gapped.positions.reshape(gapped.n_frames, -1)
    mean = np.nanmean(data, axis=0)
    solved = _solve(data - mean, gapped.rate, method, weight)
    matrix = (solved.matrix + mean).reshape(gapped.positions.shape)
    return [matrix[span.frames, marker] for marker, span in gaps], solved.converged


def _solve(data: FloatArray, rate: float, method: str, weight: float | None) -> Solved:
    known = np.isfinite(data)
    defaults: dict[str, Any] = {p.name: p.default for p in REPAIRS.get(method).parameters}
    if method in SPARSE:
        used = defaults["weight"] if weight is None else weight
        frequencies = (used, defaults["cutoff"], defaults["high"])
        solve = sparse_solver(rate, *frequencies, method == "gslr", ITERATIONS, TOLERANCE)
        return solve(data, known)
    rank, rounds = (defaults["rank"], defaults["rounds"]) if method == "tnn" else (0, 1)
    return by_truncated_norm(data, known, rank, rounds, ITERATIONS, TOLERANCE)


def _chosen(
    setting: tuple[str, int], methods: Sequence[str], sweep: Sequence[Point]
) -> tuple[tuple[str, float | None], ...]:
    """Give every method, the sparse ones with the lambda that did best in the sweep."""
    best = {}
    for method in methods:
        points = [p for p in sweep if (p.take, p.markers) == setting and p.method == method]
        best[method] = min(points, key=lambda p: p.mean_mm).weight if points else None
    return tuple(best.items())


def _cell(
    take: str, markers: int, run: tuple[str, float | None], results: Sequence[_Filled]
) -> Cell:
    means = [_mean(one.figures[:, 0]) for one in results]
    known = np.array([mean for mean in means if mean is not None])
    squares = np.concatenate([one.figures[:, 1] for one in results]) ** 2
    mean_square = _mean(squares)
    return Cell(
        take,
        markers,
        *run,
        mean_mm=_mean(known),
        sd_mm=float(known.std()) if len(known) else None,
        median_mm=float(np.median(known)) if len(known) else None,
        rmse_mm=None if mean_square is None else math.sqrt(mean_square),
        gaps=len(squares),
        refused=int(np.isnan(squares).sum()),
        unconverged=sum(not one.converged for one in results),
        masks_mm=tuple(means),
    )


def _mean(values: FloatArray) -> float | None:
    known = values[np.isfinite(values)]
    return float(known.mean()) if len(known) else None


def _pair(
    take: str, markers: int, first: str, second: str, results: Sequence[tuple[_Filled, _Filled]]
) -> Pair:
    off = [_mean(a.figures[:, 0] - b.figures[:, 0]) for a, b in results]
    known = np.array([value for value in off if value is not None])
    p = float(wilcoxon(known).pvalue) if np.any(known) else None
    return Pair(take, markers, first, second, len(known), _mean(known), p)


def _examples(name: str, task: _Task, filled: _Filled, most: int = 3) -> list[Example]:
    def rounded(values: FloatArray) -> tuple[tuple[float, ...], ...]:
        return tuple(tuple(round(x, 3) for x in row) for row in values.tolist())

    return [
        Example(
            name,
            task.window.labels[marker],
            span.start,
            rounded(task.window.positions[span.frames, marker]),
            rounded(values),
        )
        for (marker, span), values in zip(task.gaps[:most], filled.values, strict=False)
    ]
