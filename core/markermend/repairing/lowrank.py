"""Fill a matrix of trajectories so that few patterns, or few frequencies, explain it.

All solvers see a matrix (n_frames, n_columns) of which some entries are known, and keep those.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from markermend.errors import CannotRepair
from markermend.model import BoolArray, FloatArray
from markermend.repairing.geometry import distance_spread
from markermend.repairing.pca import centred
from markermend.repairing.problem import Outcome, Problem
from markermend.repairing.window import window


@dataclass(frozen=True, eq=False)
class Solved:
    """A filled matrix and how it was come by.

    Attributes
    ----------
    matrix
        (n_frames, n_columns), equal to the data where they are known.
    objective
        What is being minimised, at the matrix of each iteration or round, where it was asked for.
    residual
        (n_iterations,): how far the solver's constraints are from being met, as a share of the
        data's norm.
    converged
        Whether the residual came below the tolerance.
    """

    matrix: FloatArray
    objective: FloatArray
    residual: FloatArray
    converged: bool


Solver = Callable[[FloatArray, BoolArray], Solved]


def fill_by_matrix(problem: Problem, context: int, markers: int, solve: Solver) -> Outcome:
    """Fill the span by completing the matrix of the trajectories around it.

    Parameters
    ----------
    context
        Frames around the span that the matrix holds, the span included; at least three times the
        span.
    markers
        Other markers that it holds: the most rigidly tied ones, first those seen in the span.
    solve
        Completes a matrix, given the data and which of them are known.

    Raises
    ------
    CannotRepair
        If the marker or every other one is not seen around the span.
    """
    cut = window(problem, context)
    spread, _ = distance_spread(cut.own, cut.positions)
    spread[cut.marker] = np.inf
    hidden = ~cut.seen[cut.span.frames].all(axis=0)
    ranked = np.lexsort([spread, hidden])
    chosen = ranked[np.isfinite(spread[ranked])][:markers]
    if not cut.seen[cut.span.frames][:, chosen].any():
        raise CannotRepair(
            f"No other marker is seen while {cut.label} is not; choose a method that needs none, "
            "such as pchip."
        )
    middle = centred(cut)
    columns = np.concatenate([[cut.marker], chosen])
    data = (cut.positions[:, columns] - middle[:, None]).reshape(cut.n_frames, -1)
    solved = solve(data, np.isfinite(data))
    frames = cut.span.frames
    values = solved.matrix[frames, : cut.n_dims] + middle[frames]
    note = ""
    if not solved.converged:
        note = (
            f"Stopped after {len(solved.residual)} iterations at a residual of "
            f"{solved.residual[-1]:.1e}; more iterations may change it."
        )
    return Outcome(values, note=note)


def interpolated(data: FloatArray, known: BoolArray) -> FloatArray:
    """Fill every column by straight lines, to start from."""
    filled = data.copy()
    time = np.arange(len(data))
    for column in np.flatnonzero(~known.all(axis=0)):
        seen = known[:, column]
        filled[~seen, column] = np.interp(time[~seen], time[seen], data[seen, column])
    return filled


def singular_values(matrix: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Give the singular values, and the vectors of the shorter side, largest first."""
    wide = matrix.shape[0] < matrix.shape[1]
    gram = matrix @ matrix.T if wide else matrix.T @ matrix
    squares, vectors = np.linalg.eigh(gram)
    return np.sqrt(np.maximum(squares[::-1], 0.0)), vectors[:, ::-1]


def nuclear_norm(matrix: FloatArray) -> float:
    """Sum the singular values."""
    return float(singular_values(matrix)[0].sum())


def shrink(matrix: FloatArray, threshold: float) -> FloatArray:
    """Reduce every singular value by a threshold, down to 0 (Cai et al. 2010, Eq. 2.2)."""
    size, vectors = singular_values(matrix)
    keep = size > threshold
    vectors = vectors[:, keep]
    gain = 1.0 - threshold / size[keep]
    if matrix.shape[0] < matrix.shape[1]:
        return np.asarray((vectors * gain) @ (vectors.T @ matrix))
    return np.asarray((matrix @ vectors * gain) @ vectors.T)


def by_truncated_norm(
    data: FloatArray,
    known: BoolArray,
    rank: int,
    rounds: int,
    iterations: int,
    tolerance: float,
) -> Solved:
    """Complete by the truncated nuclear norm: all but the largest singular values are held down.

    Parameters
    ----------
    rank
        Singular values that are free; with none it is the nuclear norm, whose minimum is what
        singular value thresholding tends to for a large threshold (Cai, Candès, Shen 2010,
        Theorem 3.1).
    rounds
        Times that the free patterns are chosen anew.
    iterations
        Steps of the alternating direction method in each round.

    References
    ----------
    Hu, Zhang, Ye, Li, He, IEEE TPAMI 35:2117, 2013, Algorithms 1 and 2; on markers: Hu et al.,
    IEEE Signal Process. Lett. 25:258, 2018.
    """
    matrix = interpolated(data, known)
    scale = float(singular_values(matrix)[0][0])
    beta = 100.0 / scale
    objective, residual = [], []
    for _ in range(rounds):
        size, vectors = singular_values(matrix)
        top = vectors[:, : min(rank, len(size))]
        gain = 1.0 / np.maximum(size[: top.shape[1]], 1e-12 * scale)
        free = (
            (top * gain) @ (top.T @ matrix)
            if matrix.shape[0] < matrix.shape[1]
            else (matrix @ top * gain) @ top.T
        )
        weights, dual = matrix, np.zeros_like(matrix)
        for _ in range(iterations):
            low = shrink(weights - dual / beta, 1.0 / beta)
            weights = np.where(known, data, low + (free + dual) / beta)
            dual = dual + beta * (low - weights)
            off = _relative(low - weights, weights)
            if off < tolerance:
                break
        moved = _relative(weights - matrix, matrix) if rank else 0.0
        matrix = weights
        objective.append(float(singular_values(matrix)[0][rank:].sum()))
        residual.append(max(off, moved))
        if moved < tolerance:
            break
    return _solved(matrix, objective, residual, tolerance)


def by_sparse_low_rank(
    data: FloatArray,
    known: BoolArray,
    weight: FloatArray,
    group: bool,
    iterations: int,
    tolerance: float,
    trace: bool = False,
) -> Solved:
    """Complete by low rank and few frequencies (S-LR), the same ones in all columns (GS-LR).

    Minimises |X|_* + |W F X| with X equal to the data where they are known; F is the orthonormal
    Fourier transform along time, and the second norm sums the moduli of all coefficients, or over
    frequencies the length of all columns' coefficients.

    Parameters
    ----------
    weight
        (n_frames // 2 + 1,): lambda times the penalty of each frequency.
    group
        Whether the columns share their frequencies.
    trace
        Whether to give the objective at every step, which takes half as long again.

    References
    ----------
    Kamali et al., Sensors 20(16):4525, 2020, Eq. 3 to 14 by the alternating direction method; the
    cases of Eq. 8 as they must be: known entries keep their data, the others take the average.
    """
    n = len(data)
    twice = np.full(n // 2 + 1, 2.0)
    twice[0] = 1.0
    if n % 2 == 0:
        twice[-1] = 1.0
    matrix = interpolated(data, known)
    size = float(np.linalg.norm(matrix))
    mu = 60.0 / float(singular_values(matrix)[0][0])
    spectrum = _transform(matrix)
    dual_low, dual_few = np.zeros_like(matrix), np.zeros_like(spectrum)
    objective, residual = [], []
    for step in range(iterations):
        low = shrink(matrix - dual_low, 1.0 / mu)
        few = _shorten(spectrum - dual_few, weight / mu, group)
        before = matrix
        average = 0.5 * (low + dual_low + np.fft.irfft(few + dual_few, n, axis=0, norm="ortho"))
        matrix = np.where(known, data, average)
        spectrum = _transform(matrix)
        dual_low += low - matrix
        dual_few += few - spectrum
        if trace:
            objective.append(nuclear_norm(matrix) + _moduli(spectrum, weight * twice, group))
        off = np.hypot(np.linalg.norm(low - matrix), _length(few - spectrum, twice)) / size
        moved = float(np.linalg.norm(matrix - before)) / size
        residual.append(float(max(off, moved)))
        if residual[-1] < tolerance:
            break
        if step % 10 == 9 and step < iterations // 2:
            change = 2.0 if off > 5.0 * moved else 0.5 if moved > 5.0 * off else 1.0
            mu *= change
            dual_low /= change
            dual_few /= change
    return _solved(matrix, objective, residual, tolerance)


def frequency_penalty(
    n_frames: int, rate: float, weight: float, cutoff: float, high: float
) -> FloatArray:
    """Give lambda times the weight of each frequency: `high` times more above the cut-off.

    Parameters
    ----------
    weight
        The paper's lambda.
    cutoff
        In Hz; the paper's index 100 stands for another frequency in every length of take.
    """
    frequency = np.fft.rfftfreq(n_frames, 1.0 / rate)
    return np.where(frequency > cutoff, weight * high, weight)


def sparse_solver(
    rate: float,
    weight: float,
    cutoff: float,
    high: float,
    group: bool,
    iterations: int,
    tolerance: float,
) -> Solver:
    """Give what completes a matrix of any length by few patterns and few frequencies.

    Parameters
    ----------
    rate
        Hz.
    weight, cutoff, high
        As in `frequency_penalty`.
    group, iterations, tolerance
        As in `by_sparse_low_rank`.
    """

    def solve(data: FloatArray, known: BoolArray) -> Solved:
        penalty = frequency_penalty(len(data), rate, weight, cutoff, high)
        return by_sparse_low_rank(data, known, penalty, group, iterations, tolerance)

    return solve


def _transform(matrix: FloatArray) -> np.ndarray:
    return np.fft.rfft(matrix, axis=0, norm="ortho")


def _shorten(spectrum: np.ndarray, threshold: FloatArray, group: bool) -> np.ndarray:
    """Shorten complex coefficients, one by one or by rows (Kamali, Eq. 12 and 14)."""
    length = np.linalg.norm(spectrum, axis=1, keepdims=True) if group else np.abs(spectrum)
    safe = np.where(length > 0, length, 1.0)
    return spectrum * np.maximum(1.0 - threshold[:, None] / safe, 0.0)


def _moduli(spectrum: np.ndarray, weight: FloatArray, group: bool) -> float:
    length = np.linalg.norm(spectrum, axis=1) if group else np.abs(spectrum).sum(axis=1)
    return float(weight @ length)


def _length(spectrum: np.ndarray, twice: FloatArray) -> float:
    return float(np.sqrt(twice @ np.square(np.abs(spectrum)).sum(axis=1)))


def _relative(part: FloatArray, whole: FloatArray) -> float:
    size = float(np.linalg.norm(whole))
    return float(np.linalg.norm(part)) / size if size > 0 else 0.0


def _solved(
    matrix: FloatArray, objective: list[float], residual: list[float], tolerance: float
) -> Solved:
    return Solved(matrix, np.array(objective), np.array(residual), bool(residual[-1] < tolerance))
