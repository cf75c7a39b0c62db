"""Heavy noise, and what the stages for sudden artefacts share."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from markermend.detection.likelihood.scales import (
    MEDIAN_OF_CHI3,
    QUARTILE_OF_CHI3,
    rolling_quantile,
)
from markermend.model import BoolArray, FloatArray, Kind

LEAST = 0.5  # candidates are kept down to this strength
# Frames at 100 Hz on each side of a local scale, and its stride; `pace` is the rate over 100 Hz.
_SCALE = (40, 10)
_LONG_SCALE = (120, 20)
_LEAST_HALF = 20  # frames that a quantile needs at any rate
_MATES = 5
MATE_SHARE = 0.7

_NOISE_LEVEL = 3.5  # a frame speaks for noise above this many local scales
_NOISE_GAIN = (-0.7, 1.0)  # bounds of what one frame can say
_NOISE_TOTAL = 7.5
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


def local_scale(z: FloatArray, valid: BoolArray, pace: float) -> FloatArray:
    """Usual size of a score around each frame, at least the noise model's own 1."""
    usual = rolling_quantile(z, valid, *_at(pace, *_SCALE), 0.5) / MEDIAN_OF_CHI3
    return np.maximum(1.0, usual)


def _at(pace: float, half: int, stride: int) -> tuple[int, int]:
    """Frames of a scale that is local in seconds, where it has enough of them."""
    return max(_LEAST_HALF, round(half * pace)), max(5, round(stride * pace))


def mates_of(own: FloatArray, valid: BoolArray, neighbours: NDArray[np.intp]) -> FloatArray:
    """Second largest score of a marker's nearest mates in the same frame: an impact hits them all.

    The second largest, so that one mate's artefact does not excuse the marker's own.
    """
    near = np.where(valid, own, 0.0)[neighbours[:, :_MATES]]
    if near.shape[1] < 2:
        return np.zeros_like(own)
    result: FloatArray = np.sort(near, axis=1)[:, -2]
    return result


def roughness(series: FloatArray, valid: BoolArray, floor: float, pace: float) -> FloatArray:
    """Fourth differences over their local scale: (n_markers, n_frames), short in time.

    Parameters
    ----------
    series
        (n_markers, n_frames, 3) mm.
    valid
        (n_markers, n_frames).
    floor
        mm: white noise that is always assumed.
    pace
        Rate over 100 Hz.
    """
    fourth = np.zeros(series.shape[:2])
    if series.shape[1] > 4:
        fourth[:, 2:-2] = np.sqrt((np.diff(series, n=4, axis=1) ** 2).sum(2)) / _FOURTH
    usual = rolling_quantile(fourth, valid, *_at(pace, *_LONG_SCALE), 0.25) / QUARTILE_OF_CHI3
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
                    total *= _rest_without_peaks(positions[max(0, a - 4) : b + 4, m])
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
