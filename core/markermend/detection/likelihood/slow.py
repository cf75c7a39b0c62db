"""Slow changes: triangles that the neighbours' prediction cannot explain."""

from dataclasses import dataclass

import numpy as np
from scipy import fft

from markermend.detection.likelihood import templates
from markermend.detection.likelihood.sharp import LEAST, Candidate
from markermend.detection.likelihood.whitening import Whitened
from markermend.model import BoolArray, FloatArray

LENGTHS = (33, 41, 51, 63, 79)  # frames at 100 Hz
_BOXES = (12, 20, 30, 45, 65)
_AROUND = 50  # frames within which nothing much may be left
_MOST_LEFT = 0.42
_MOST_BOX = 1.0  # a box of any length that scores higher is no triangle
_MOST_LABELLED = 0.3
_QUANTILE_POWER = 0.7


@dataclass(frozen=True, eq=False)
class Triangles:
    """The best triangle centred on each frame: (n_markers, n_frames) each."""

    score: FloatArray
    length: FloatArray


def scan(whitened: Whitened) -> Triangles:
    """Score triangles of all lengths, centred on every frame where they fit."""
    total = templates.sums(whitened)
    n = whitened.g.shape[1]
    best = np.zeros((len(total) // 3, n))
    length = np.full(best.shape, LENGTHS[0])
    for L in LENGTHS:
        if n < L:
            continue
        shape = templates.triangle_template(L)
        z = templates.score(templates.triangles(total, L), whitened.energy(shape))
        part = slice(L // 2, L // 2 + z.shape[1])
        better = z > best[:, part]
        best[:, part] = np.where(better, z, best[:, part])
        length[:, part] = np.where(better, L, length[:, part])
    return Triangles(best, length)


def normalised(score: FloatArray, scale: FloatArray, valid: BoolArray) -> FloatArray:
    """Score over its learnt scale, markers with heavier tails held back."""
    u = score / np.maximum(scale, 0.5)
    tail = np.array(
        [np.quantile(row[v], 0.98) if v.any() else 1.0 for row, v in zip(u, valid, strict=True)]
    )
    factor = (tail / np.median(tail)) ** _QUANTILE_POWER
    return np.where(valid, u / np.maximum(factor, 0.3)[:, None], 0.0)


def find_slow(
    whitened: Whitened,
    triangles: Triangles,
    u: FloatArray,
    labelled: BoolArray,
    threshold: float,
    least_mm: float,
) -> list[Candidate]:
    """Take the best triangle, see what is left when it is taken out, and again."""
    u = u.copy()
    n = u.shape[1]
    found = []
    while True:
        m, t = np.unravel_index(int(u.argmax()), u.shape)
        value = float(u[m, t])
        if value < LEAST * threshold:
            break
        L = int(triangles.length[m, t])
        start, stop = max(0, t - L // 2), min(n, t + L // 2 + 1)
        u[m, max(0, t - L // 2 - 10) : t + L // 2 + 11] = 0.0
        if labelled[m, start:stop].mean() > _MOST_LABELLED:
            continue
        rows = slice(3 * m, 3 * m + 3)
        left, amplitude, box = _taken_out(whitened, rows, int(t), L, float(triangles.score[m, t]))
        if amplitude < least_mm or left > _MOST_LEFT or box > _MOST_BOX:
            continue
        found.append(Candidate("slow", int(m), start, stop, value / threshold, value))
    return found


def _taken_out(
    whitened: Whitened, rows: slice, centre: int, L: int, before: float
) -> tuple[float, float, float]:
    """Share of the score left around, amplitude in mm, and how well a box does instead."""
    n = whitened.g.shape[1]
    weight = whitened.weight[rows]
    one = Whitened(whitened.g[rows], weight, whitened.size)
    shape = templates.triangle_template(L)
    start = centre - L // 2
    q = one.energy(shape)
    N = one.g[:, start : start + L] @ shape
    answer = fft.irfft(weight * fft.rfft(shape, whitened.size), whitened.size)
    answer = np.roll(answer, start, axis=1)[:, :n]
    rest = Whitened(one.g - (N / q)[:, None] * answer, weight, whitened.size)
    again = scan(rest).score[0]
    left = float(again[max(0, centre - _AROUND) : centre + _AROUND + 1].max())
    total = templates.sums(one)
    best_box = 0.0
    for length in _BOXES:
        z = templates.score(templates.boxes(total, length), one.energy(np.ones(length)))[0]
        best_box = max(best_box, float(z[max(0, start - length // 2) : start + L].max(initial=0.0)))
    return left / before, float(np.sqrt(((N / q) ** 2).sum())), best_box / before
