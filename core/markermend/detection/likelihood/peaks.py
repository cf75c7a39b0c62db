"""Peaks: boxes of 1 to 3 frames, taken out of the series one after the other."""

from dataclasses import dataclass

import numpy as np
from scipy import fft

from markermend.detection.likelihood import templates
from markermend.detection.likelihood.sharp import LEAST, MATE_SHARE, Candidate, local_scale
from markermend.detection.likelihood.whitening import Whitened
from markermend.model import BoolArray, FloatArray

LONGEST = 3
_JUMP_HALF = 6
_REACH = 16  # frames around a box that its answer is taken out of
_SIDE = 8  # frames in which nothing much may be left
_NEAR_JUMP = 3
_HANDICAP = (1.0, 1.0 / 1.2, 1.0 / 1.4)  # longer boxes fit what moves a little better
_MOST_PER_FRAME = 0.2  # of a marker's frames that may be peaks


@dataclass(frozen=True, eq=False)
class Witness:
    """Boxes of 1 to 3 frames and a jump, scored on one set of series.

    Attributes
    ----------
    N
        (4, n_series, n_frames): sums over boxes that *start* at each frame, and over a jump before
        it.
    q
        (4, n_series): energies.
    usual
        (4, n_markers, n_frames): local scale of the score, at least 1.
    answer
        (3, 4, n_series, 2 * reach + 1): what a box of 1 mm adds to ``N`` around it.
    """

    N: FloatArray
    q: FloatArray
    usual: FloatArray
    answer: FloatArray

    def score(self, template: int = 0) -> FloatArray:
        """(n_markers, n_frames): normalised scores."""
        z: FloatArray = templates.score(self.N[template], self.q[template])
        normalised: FloatArray = z / self.usual[template]
        return normalised


def witness(whitened: Whitened, valid: BoolArray, pace: float = 1.0) -> Witness:
    """Score all boxes of 1 to 3 frames, and jumps.

    Parameters
    ----------
    whitened
        Three series per marker.
    valid
        (n_markers, n_frames): frames that count for the local scale.
    pace
        Rate over 100 Hz.
    """
    total = templates.sums(whitened)
    jump = templates.jump_template(_JUMP_HALF)
    shapes = [np.ones(k) for k in range(1, LONGEST + 1)] + [jump]
    begins = [0] * LONGEST + [-_JUMP_HALF]
    N = np.zeros((len(shapes), *whitened.g.shape))
    for k in range(LONGEST):
        N[k, :, : N.shape[2] - k] = templates.boxes(total, k + 1)
    N[LONGEST] = templates.jumps(total, _JUMP_HALF)
    q = np.array([whitened.energy(shape) for shape in shapes])
    usual = np.array(
        [local_scale(templates.score(a, b), valid, pace) for a, b in zip(N, q, strict=True)]
    )
    kernel = fft.irfft(whitened.weight, whitened.size)
    wide = _REACH + 2 * _JUMP_HALF
    kernel = np.concatenate((kernel[:, -wide:], kernel[:, : wide + 1]), axis=1)
    answer = np.empty((LONGEST, len(shapes), len(kernel), 2 * _REACH + 1))
    for k in range(LONGEST):
        for j, (shape, begin) in enumerate(zip(shapes, begins, strict=True)):
            # N_j(d) = sum_ab T_j(a) kernel(d + begin + a - b) T_k(b)
            joint = np.convolve(shape, np.ones(k + 1))
            part = np.zeros((len(kernel), 2 * _REACH + 1))
            for offset, value in enumerate(joint, begin - k):
                at = wide - _REACH + offset
                part += value * kernel[:, at : at + 2 * _REACH + 1]
            answer[k, j] = part
    return Witness(N, q, usual, answer)


@dataclass(frozen=True, eq=False)
class Peak:
    """A peak, and its best amplitude (3,) mm according to each witness."""

    candidate: Candidate
    sizes: tuple[FloatArray, ...]


def find_peaks(
    witnesses: tuple[Witness, ...], mates: FloatArray, free: BoolArray, threshold: float
) -> list[Peak]:
    """Boxes of 1 to 3 frames on which the witnesses agree and that leave nothing behind.

    The best box of a marker is taken out of its series, and again. A kink, as of a heel strike,
    also scores; but with its best boxes taken out there is still something around.

    Parameters
    ----------
    witnesses
        The marker's own path, and where at hand its residual.
    mates
        (n_markers, n_frames): what the mates' paths do in the same frame.
    free
        (n_markers, n_frames): frames that are seen and not explained yet.
    threshold
        Score, in local noise scales, that a peak has to pass.
    """
    least = LEAST * threshold
    scores = [np.minimum.reduce([w.score(k) for w in witnesses]) for k in range(LONGEST)]
    hot = ((np.maximum.reduce(scores) * free) > least).any(1)
    found = []
    for m in np.flatnonzero(hot).tolist():
        found += _of_marker(witnesses, m, mates[m], free[m], threshold)
    return found


def _of_marker(
    witnesses: tuple[Witness, ...],
    marker: int,
    mates: FloatArray,
    free: BoolArray,
    threshold: float,
) -> list[Peak]:
    rows = slice(3 * marker, 3 * marker + 3)
    left = [w.N[:, rows].copy() for w in witnesses]
    n = len(free)
    open_to = np.array([free * 1.0] * LONGEST)
    for k in range(1, LONGEST):
        open_to[k, : n - k] = open_to[k - 1, : n - k] * open_to[0, k:]
        open_to[k, n - k :] = 0.0

    def score(part: slice) -> FloatArray:
        z = [
            np.sqrt((N[:, :, part] ** 2 / w.q[:, rows, None]).sum(1)) / w.usual[:, marker, part]
            for N, w in zip(left, witnesses, strict=True)
        ]
        joined: FloatArray = np.minimum.reduce(z)
        joined[:LONGEST] *= np.array(_HANDICAP)[:, None]
        return joined

    now = score(slice(0, n))
    taken: list[tuple[int, int, float, tuple[FloatArray, ...]]] = []
    for _ in range(max(4, int(_MOST_PER_FRAME * n))):
        shown = now[:LONGEST] * open_to
        k, t = divmod(int(shown.argmax()), n)
        value = float(shown[k, t])
        if value <= LEAST * threshold:
            break
        around = slice(max(0, t - _NEAR_JUMP), t + k + 1 + _NEAR_JUMP)
        jump, box = (
            np.sum(
                [
                    _raw(N[j, :, part], w.q[j, rows]) ** 2
                    for N, w in zip(left, witnesses, strict=True)
                ],
                axis=0,
            ).max()
            for j, part in ((LONGEST, around), (k, slice(t, t + 1)))
        )
        if jump > box:
            open_to[:, around] = 0.0  # a jump explains it better
            continue
        low, high = max(0, t - _REACH), min(n, t + _REACH + 1)
        sizes = []
        for N, w in zip(left, witnesses, strict=True):
            size = N[k, :, t] / w.q[k, rows]
            part = w.answer[k, :, rows, low - t + _REACH : high - t + _REACH]
            N[:, :, low:high] -= size[:, None] * part
            sizes.append(size)
        now[:, low:high] = score(slice(low, high))
        open_to[:, max(0, t - LONGEST + 1) : t + k + 1] = 0.0
        taken.append((t, k + 1, value, tuple(sizes)))
    peaks = []
    for t, length, value, sizes_of in taken:
        beside = slice(max(0, t - _SIDE), t + length + _SIDE)
        side = float((now[0, beside] * free[beside]).max(initial=0.0))
        strength = value / max(1.0, MATE_SHARE * float(mates[t]), side) / threshold
        if strength >= LEAST:
            peaks.append(Peak(Candidate("peak", marker, t, t + length, strength, value), sizes_of))
    return peaks


def _raw(N: FloatArray, q: FloatArray) -> FloatArray:
    """Score of one marker in units of the noise model: (n,) from (3, n)."""
    result: FloatArray = np.sqrt((N * N / q[:, None]).sum(0))
    return result
