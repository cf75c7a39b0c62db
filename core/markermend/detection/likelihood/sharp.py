"""Peaks and heavy noise: single frames that neither the marker's own path nor its mates explain."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from markermend.detection.likelihood import templates
from markermend.detection.likelihood.scales import (
    MEDIAN_OF_CHI3,
    QUARTILE_OF_CHI3,
    rolling_quantile,
)
from markermend.detection.likelihood.whitening import Whitened
from markermend.model import BoolArray, FloatArray, Kind

LONGEST_PEAK = 3
LEAST = 0.5  # candidates are kept down to this strength
_SCALE_HALF = 40
_LONG_HALF = 120
_MATES = 5
MATE_SHARE = 0.7
_FLANK = 8
_FLANK_SHARE = 1.0
_JUMP_HALF = 6

_NOISE_LEVEL = 3.5  # a frame speaks for noise above this many local scales
_NOISE_GAIN = (-0.7, 1.0)  # bounds of what one frame can say
_NOISE_TOTAL = 6.0
_SHORTEST_NOISE = 8
_NOISE_REST = 12
_LONG_NOISE = 25  # longer segments cannot be two single peaks
_REST_OF_NOISE = 0.6
_KERNEL_RATIO = 2.5
_FOURTH = np.sqrt(70.0)  # white noise grows by this in fourth differences


@dataclass(frozen=True)
class Candidate:
    """One thing found on one marker, before it becomes a finding."""

    kind: Kind
    marker: int
    start: int
    stop: int
    strength: float
    statistic: float


@dataclass(frozen=True, eq=False)
class Witness:
    """Boxes and jumps scored on one set of series, the marker's own path or its residual.

    Attributes
    ----------
    N
        By box length - 1: (n_series, n_frames) sums over boxes that start at each frame.
    q
        By box length - 1: (n_series,) energies.
    usual
        By box length - 1: (n_markers, n_frames) local scale of the score, at least 1.
    answer
        By box length - 1: (n_series, 2 * flank + 1) what a box of 1 adds to ``N[0]`` around it.
    jump
        (n_markers, n_frames): normalised score of a jump before each frame.
    """

    N: tuple[FloatArray, ...]
    q: tuple[FloatArray, ...]
    usual: tuple[FloatArray, ...]
    answer: tuple[FloatArray, ...]
    jump: FloatArray

    def score(self, length: int) -> FloatArray:
        """(n_markers, n_frames): normalised scores of boxes of this length."""
        return templates.score(self.N[length - 1], self.q[length - 1]) / self.usual[length - 1]

    def after(self, marker: int, frame: int, length: int) -> FloatArray:
        """Scores of single frames around a box once the best box is taken out: (2 flank + 1,)."""
        rows = slice(3 * marker, 3 * marker + 3)
        N = self.N[length - 1][rows, frame] / self.q[length - 1][rows]
        n = self.N[0].shape[1]
        around = np.clip(np.arange(frame - _FLANK, frame + _FLANK + 1), 0, n - 1)
        left = self.N[0][rows][:, around] - N[:, None] * self.answer[length - 1][rows]
        z = np.sqrt((left**2 / self.q[0][rows, None]).sum(0))
        return z / self.usual[0][marker, around]


def witness(whitened: Whitened, valid: BoolArray) -> Witness:
    """Score all boxes of 1 to 3 frames, and jumps.

    Parameters
    ----------
    whitened
        Three series per marker.
    valid
        (n_markers, n_frames): frames that count for the local scale.
    """
    total = templates.sums(whitened)
    N, q, usual, answer = [], [], [], []
    one = fft.rfft(np.ones(1), whitened.size)
    for length in range(1, LONGEST_PEAK + 1):
        shape = np.ones(length)
        sums = np.pad(templates.boxes(total, length), ((0, 0), (0, length - 1)))
        energy = whitened.energy(shape)
        N.append(sums)
        q.append(energy)
        usual.append(local_scale(templates.score(sums, energy), valid))
        spread = fft.irfft(whitened.weight * fft.rfft(shape, whitened.size) * one, whitened.size)
        answer.append(np.concatenate((spread[:, -_FLANK:], spread[:, : _FLANK + 1]), axis=1))
    z = templates.score(
        templates.jumps(total, _JUMP_HALF),
        whitened.energy(templates.jump_template(_JUMP_HALF)),
    )
    jump = z / local_scale(z, valid)
    return Witness(tuple(N), tuple(q), tuple(usual), tuple(answer), jump)


def local_scale(z: FloatArray, valid: BoolArray) -> FloatArray:
    """Usual size of a score around each frame, at least the noise model's own 1."""
    return np.maximum(1.0, rolling_quantile(z, valid, _SCALE_HALF, 0.5, 10) / MEDIAN_OF_CHI3)


def mates_of(own: FloatArray, valid: BoolArray, neighbours: NDArray[np.intp]) -> FloatArray:
    """Second largest score of a marker's nearest mates in the same frame: an impact hits them all.

    The second largest, so that one mate's artefact does not excuse the marker's own.
    """
    near = np.where(valid, own, 0.0)[neighbours[:, :_MATES]]
    if near.shape[1] < 2:
        return np.zeros_like(own)
    result: FloatArray = np.sort(near, axis=1)[:, -2]
    return result


def roughness(series: FloatArray, valid: BoolArray, floor: float) -> FloatArray:
    """Fourth differences over their local scale: (n_markers, n_frames), short in time.

    Parameters
    ----------
    series
        (n_markers, n_frames, 3) mm.
    valid
        (n_markers, n_frames).
    floor
        mm: white noise that is always assumed.
    """
    fourth = np.zeros(series.shape[:2])
    if series.shape[1] > 4:
        fourth[:, 2:-2] = np.sqrt((np.diff(series, n=4, axis=1) ** 2).sum(2)) / _FOURTH
    usual = rolling_quantile(fourth, valid, _LONG_HALF, 0.25, 20) / QUARTILE_OF_CHI3
    return np.where(valid, fourth / np.maximum(usual, floor), 0.0)


def find_noise(rough: FloatArray, positions: FloatArray, threshold: float) -> list[Candidate]:
    """Segments in which most frames are further off than the marker's scale allows.

    Parameters
    ----------
    rough
        (n_markers, n_frames): the smaller roughness of both witnesses.
    positions
        (n_frames, n_markers, 3) mm.
    threshold
        Factor on the sum of evidence that a segment has to pass.
    """
    gain = np.clip(np.log(np.maximum(rough, 1e-3) / _NOISE_LEVEL), *_NOISE_GAIN)
    found = []
    for m in np.flatnonzero((gain > 0).sum(1) >= _SHORTEST_NOISE // 2):
        hot = np.flatnonzero(gain[m] > 0)
        breaks = np.flatnonzero(np.diff(hot) > _NOISE_REST)
        firsts = np.concatenate(([0], breaks + 1))
        lasts = np.concatenate((breaks, [len(hot) - 1]))
        for i, j in zip(firsts, lasts, strict=True):
            for a, b, total in _heaviest(gain[m], int(hot[i]), int(hot[j]) + 1):
                if b - a < _LONG_NOISE:
                    total *= _rest_without_peaks(positions[a - 4 : b + 4, m])
                strength = total / (_NOISE_TOTAL * threshold)
                a, b = _first_frame(rough[m], a, 1), _first_frame(rough[m], b - 1, -1) + 1
                if b - a >= _SHORTEST_NOISE and strength >= LEAST:
                    level = float(np.sqrt(np.mean(rough[m, a:b] ** 2)))
                    found.append(Candidate("noise", int(m), a, b, strength, level))
    return found


def _first_frame(rough: FloatArray, hot: int, step: int) -> int:
    """The outermost frame that is off, from the outermost fourth difference that is.

    One frame off shows in fourth differences as 1, -4, 6, -4, 1 around it.
    """
    return hot + (2 if rough[hot + step] > _KERNEL_RATIO * rough[hot] else 1) * step


def _rest_without_peaks(path: FloatArray, most: int = 2) -> float:
    """Share of fourth differences' size that is left when the best single frames are taken out."""
    if len(path) < 10:
        return 1.0
    fourth = np.diff(path, n=4, axis=0)
    before = np.sqrt((fourth**2).sum(1)).sum()
    kernel = np.array([1.0, -4.0, 6.0, -4.0, 1.0])
    for _ in range(most):
        fit = np.array([np.convolve(axis, kernel, "valid") for axis in fourth.T]) / 70.0
        t = int((fit**2).sum(0).argmax())
        fourth[t : t + 5] -= kernel[:, None] * fit[:, t]
    left = float(np.sqrt((fourth**2).sum(1)).sum() / max(before, 1e-12))
    return min(1.0, left / _REST_OF_NOISE)


def _heaviest(gain: FloatArray, start: int, stop: int) -> list[tuple[int, int, float]]:
    """Disjoint stretches of largest sum, largest first."""
    if stop - start < _SHORTEST_NOISE:
        return []
    c = np.concatenate(([0.0], np.cumsum(gain[start:stop])))
    lowest = np.minimum.accumulate(c)
    j = int((c - lowest).argmax())
    i = int(c[: j + 1].argmin())
    total = float(c[j] - c[i])
    if total < _NOISE_TOTAL * LEAST * 0.5:
        return []
    a, b = start + i, start + j
    return [(a, b, total), *_heaviest(gain, start, a), *_heaviest(gain, b, stop)]


def find_peaks(
    own: Witness, residual: Witness, mates: FloatArray, free: BoolArray, threshold: float
) -> list[Candidate]:
    """Boxes of 1 to 3 frames on which both witnesses agree and that leave nothing behind.

    A kink, as of a heel strike, also scores; but with the best box taken out its flanks still do.

    Parameters
    ----------
    own, residual
        The witnesses.
    mates
        From `mates_of`.
    free
        (n_markers, n_frames): frames that are seen and not explained yet.
    threshold
        Score, in local noise scales, that a peak has to pass.
    """
    lengths = range(1, LONGEST_PEAK + 1)
    u = np.array([np.minimum(own.score(k), residual.score(k)) for k in lengths])
    jump = np.minimum(own.jump, residual.jump)
    n = free.shape[1]
    for k in lengths:
        for shift in range(k):
            u[k - 1, :, : n - shift] *= free[:, shift:]
        u[k - 1, :, n - k + 1 :] = 0.0
    best = u.max(0)
    hot = np.argwhere(best > LEAST * threshold)
    order = np.argsort(-best[hot[:, 0], hot[:, 1]], kind="stable")
    used = np.zeros_like(free)
    found = []
    for m, t in hot[order].tolist():
        length = int(u[:, m, t].argmax()) + 1
        raw = float(best[m, t])
        if used[m, t : t + length].any():
            continue
        used[m, max(0, t - 3) : t + length + 3] = True
        if jump[m, max(0, t - 3) : t + length + 4].max() > raw:
            continue  # a jump explains it better
        left = np.minimum(own.after(m, t, length), residual.after(m, t, length))
        frames = np.clip(np.arange(t - _FLANK, t + _FLANK + 1), 0, n - 1)
        side = float(left[free[m, frames]].max(initial=0.0))
        strength = raw / max(1.0, MATE_SHARE * mates[m, t], _FLANK_SHARE * side) / threshold
        if strength >= LEAST:
            found.append(Candidate("peak", m, t, t + length, strength, raw))
    return found
