"""Slow changes: triangles that the neighbours' prediction cannot explain."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from markermend.detection.likelihood import templates
from markermend.detection.likelihood.prediction import Prediction
from markermend.detection.likelihood.sharp import LEAST, Candidate
from markermend.detection.likelihood.whitening import Whitened
from markermend.model import BoolArray, FloatArray

# Frames at 100 Hz; `pace` is the rate over 100 Hz.
LENGTHS = (33, 41, 51, 63, 79)
_TOO_SHORT = 17  # what a triangle of this length explains better is movement
_BOXES = (12, 20, 30, 45, 65)
_AROUND = 50  # within these nothing much may be left
_MOST_BOX = 1.0  # a box of any length that scores higher is no triangle
_MOST_LABELLED = 0.3
_QUANTILE_POWER = 0.7
_ONE_ARTEFACT = 100  # frames at 100 Hz on which one slow change raises the score
_MASKED = 10  # frames beside a triangle in which no second one is looked for
_BASE = 5  # frames beside a triangle that must be recorded: without a base it is any drift
_ECHO = 0.6  # a score that falls below this share was an echo


@dataclass(frozen=True, eq=False)
class Triangles:
    """Triangles of all lengths on whitened series, three per marker.

    Attributes
    ----------
    score, length
        (n_markers, n_frames): the best triangle centred on each frame.
    N
        Length -> (n_series, n_frames): sums over the triangle centred on each frame, 0 where it
        does not fit.
    q
        Length -> (n_series,): energies.
    short
        (n_markers, n_frames): score of a triangle that is too short, centred on each frame.
    box
        Length -> (n_markers, n): scores of boxes that start at each frame.
    """

    score: FloatArray
    length: NDArray[np.intp]
    N: Mapping[int, FloatArray]
    q: Mapping[int, FloatArray]
    short: FloatArray
    box: Mapping[int, FloatArray]


@dataclass(frozen=True, eq=False)
class Hill:
    """One triangle on one marker.

    Attributes
    ----------
    marker, start, length
        Where; the triangle's own frames.
    score, value
        Its likelihood-ratio score, and that over the learnt scale, less what it leaves behind.
    left
        Largest score left around, as a share of its own.
    size
        (3,) mm along the axes of the marker's series.
    """

    marker: int
    start: int
    length: int
    score: float
    value: float
    left: float
    size: FloatArray

    @property
    def stop(self) -> int:
        """Frame after the last."""
        return self.start + self.length

    def overlaps(self, other: "Hill") -> bool:
        """Whether they share a third of the shorter one."""
        both = min(self.stop, other.stop) - max(self.start, other.start)
        return 3 * both > min(self.length, other.length)


def lengths(pace: float) -> tuple[int, ...]:
    """Odd numbers of frames."""
    return tuple(sorted({max(5, 2 * round(L * pace / 2) + 1) for L in LENGTHS}))


def scan(whitened: Whitened, pace: float) -> Triangles:
    """Score triangles of all lengths, centred on every frame where they fit, and boxes."""
    total = templates.sums(whitened)
    n = whitened.g.shape[1]
    best = np.zeros((len(total) // 3, n))
    length = np.full(best.shape, lengths(pace)[0])
    N: dict[int, FloatArray] = {}
    q: dict[int, FloatArray] = {}
    for L in lengths(pace):
        N[L] = np.zeros((len(total), n))
        q[L] = whitened.energy(templates.triangle_template(L))
        if n < L:
            continue
        inner = templates.triangles(total, L)
        part = slice(L // 2, L // 2 + inner.shape[1])
        N[L][:, part] = inner
        z = templates.score(inner, q[L])
        better = z > best[:, part]
        best[:, part] = np.where(better, z, best[:, part])
        length[:, part] = np.where(better, L, length[:, part])
    L = max(3, 2 * round(_TOO_SHORT * pace / 2) + 1)
    short = np.zeros(best.shape)
    if n >= L:
        z = templates.score(
            templates.triangles(total, L), whitened.energy(templates.triangle_template(L))
        )
        short[:, L // 2 : L // 2 + z.shape[1]] = z
    wide = [max(2, round(L * pace)) for L in _BOXES]
    box = {
        L: templates.score(templates.boxes(total, L), whitened.energy(np.ones(L)))
        for L in wide
        if n > L
    }
    return Triangles(best, length, N, q, short, box)


def held_back(score: FloatArray, scale: FloatArray, valid: BoolArray, pace: float) -> FloatArray:
    """(n_markers, n_frames): the learnt scale, larger for markers with heavier tails.

    The tail is taken below what one artefact alone may fill, so that it does not hide itself.
    """
    scale = np.maximum(scale, 0.5)
    u = score / scale
    quantile = 1.0 - min(0.5, max(0.02, _ONE_ARTEFACT * pace / score.shape[1]))
    tail = np.array(
        [np.quantile(row[v], quantile) if v.any() else 1.0 for row, v in zip(u, valid, strict=True)]
    )
    factor = (tail / np.median(tail)) ** _QUANTILE_POWER
    held: FloatArray = scale * np.maximum(factor, 0.3)[:, None]
    return held


def needed(whitened: Whitened, scale: FloatArray, threshold: float, pace: float) -> FloatArray:
    """(n_markers, n_frames) mm: amplitude of a triangle of usual length that would just be found.

    Its direction is taken as unknown: the energies of the three axes are averaged. What is usually
    left around a triangle, one scale, counts against it and has to be passed as well.
    """
    shape = templates.triangle_template(lengths(pace)[len(lengths(pace)) // 2])
    energy = whitened.energy(shape).reshape(-1, 3).mean(1)
    amplitude: FloatArray = (threshold + 1.0) * scale / np.sqrt(energy)[:, None]
    return amplitude


def find_slow(
    whitened: Whitened,
    scale: FloatArray,
    triangles: Triangles,
    labelled: BoolArray,
    axes: FloatArray,
    predictions: Mapping[int, Prediction],
    positions: FloatArray,
    threshold: float,
    least_mm: float,
    pace: float,
) -> list[Candidate]:
    """Triangles that stand out, leave little behind when taken out, and are no echo.

    Parameters
    ----------
    whitened
        Residuals, three series per marker.
    scale, triangles
        From `held_back` and `scan`.
    labelled
        (n_markers, n_frames): frames explained by other kinds, or not seen.
    axes
        (n_markers, 3, 3): local directions of the three series.
    predictions, positions
        How the residuals were made, and from what (n_frames, n_markers, 3).
    threshold
        Value that has to be passed.
    least_mm
        Smallest amplitude.
    pace
        Rate over 100 Hz.
    """
    u = triangles.score / scale
    kept: list[Hill] = []
    hills = _hills(whitened, u, triangles, labelled, LEAST * threshold, least_mm, pace)
    for hill in sorted(hills, key=lambda h: (-h.value, h.marker, h.start)):
        rivals = [k for k in kept if k.marker != hill.marker and k.overlaps(hill)]
        wins = True
        for rival in rivals:
            here = _explained(hill, rival, whitened, axes, predictions, positions)
            there = _explained(rival, hill, whitened, axes, predictions, positions)
            if min(here, there) >= _ECHO:
                continue
            # Whichever of the two leaves less of both is the cause.
            as_echo = rival.left * rival.score + here * hill.score
            as_cause = hill.left * hill.score + there * rival.score
            if as_echo <= as_cause:
                wins = False
                break
            kept.remove(rival)
        if wins:
            kept.append(hill)
    return [
        Candidate("slow", h.marker, h.start, h.stop, h.value / threshold, h.value) for h in kept
    ]


def _hills(
    whitened: Whitened,
    u: FloatArray,
    triangles: Triangles,
    labelled: BoolArray,
    least: float,
    least_mm: float,
    pace: float,
) -> list[Hill]:
    n, base = u.shape[1], round(_BASE * pace)
    echoes = _Echoes(whitened, tuple(L for L in triangles.N if n >= L))
    hills: list[Hill] = []
    for m in np.flatnonzero((u >= least).any(1)).tolist():
        row = u[m].copy()
        while True:
            t = int(row.argmax())
            value = float(row[t])
            if value < least:
                break
            L = int(triangles.length[m, t])
            start = t - L // 2
            row[max(0, start - _MASKED) : start + L + _MASKED] = 0.0
            if start < base or start + L > n - base:
                continue
            if labelled[m, start : start + L].mean() > _MOST_LABELLED:
                continue
            size = triangles.N[L][3 * m : 3 * m + 3, t] / triangles.q[L][3 * m : 3 * m + 3]
            if np.sqrt((size**2).sum()) < least_mm or _rivalled(triangles, m, start, L):
                continue
            left = _left(echoes, triangles, m, t, L, size, round(_AROUND * pace), value, least)
            hill = Hill(m, start, L, float(triangles.score[m, t]), value * (1.0 - left), left, size)
            if hill.value >= least:
                hills.append(hill)
    return hills


class _Echoes:
    """What a triangle of 1 mm adds to the sums of all triangles around it, by series and length."""

    def __init__(self, whitened: Whitened, lengths: tuple[int, ...]) -> None:
        self._whitened = whitened
        self._spectra = {
            L: fft.rfft(np.roll(_padded(templates.triangle_template(L), whitened.size), -(L // 2)))
            for L in lengths
        }
        self._known: dict[tuple[int, int], dict[int, FloatArray]] = {}

    def of(self, marker: int, length: int) -> dict[int, FloatArray]:
        """Length -> (3, size), beginning at the centre of the triangle and going round."""
        if (marker, length) not in self._known:
            weight = self._whitened.weight[3 * marker : 3 * marker + 3] * self._spectra[length]
            self._known[marker, length] = {
                L: fft.irfft(weight * spectrum.conj(), self._whitened.size)
                for L, spectrum in self._spectra.items()
            }
        return self._known[marker, length]


def _padded(shape: FloatArray, size: int) -> FloatArray:
    return np.pad(shape, (0, size - len(shape)))


def _rivalled(triangles: Triangles, marker: int, start: int, length: int) -> bool:
    """Whether a box or a triangle that is too short explains the place better."""
    score = triangles.score[marker, start + length // 2]
    if triangles.short[marker, start : start + length].max() > score:
        return True
    return any(
        z[marker, max(0, start - L // 2) : start + length].max(initial=0.0) > _MOST_BOX * score
        for L, z in triangles.box.items()
    )


def _left(
    echoes: _Echoes,
    triangles: Triangles,
    marker: int,
    middle: int,
    length: int,
    size: FloatArray,
    reach: int,
    value: float,
    least: float,
) -> float:
    """Take a triangle out: the largest score that is left within `reach`, as a share of its own.

    At most 1; no longer looked for once the rest of `value` is below `least`.
    """
    rows = slice(3 * marker, 3 * marker + 3)
    n = triangles.score.shape[1]
    low, high = max(0, middle - reach), min(n, middle + reach + 1)
    shifts = np.arange(low - middle, high - middle)
    score = float(triangles.score[marker, middle])
    left = 0.0
    for L, answer in echoes.of(marker, length).items():
        fits = slice(max(low, L // 2), min(high, n - L // 2))
        inside = slice(fits.start - low, fits.stop - low)
        rest = triangles.N[L][rows, fits] - size[:, None] * answer[:, shifts[inside]]
        z2 = (rest**2 / triangles.q[L][rows, None]).sum(0)
        left = max(left, float(np.sqrt(z2.max(initial=0.0))) / score)
        if value * (1.0 - left) < least:
            break
    return min(left, 1.0)


def _explained(
    hill: Hill,
    cause: Hill,
    whitened: Whitened,
    axes: FloatArray,
    predictions: Mapping[int, Prediction],
    positions: FloatArray,
) -> float:
    """Share of a hill's score that is left once another marker's triangle is taken out."""
    model = predictions[hill.marker].model
    if cause.marker not in model.features:
        return 1.0
    part = slice(max(0, cause.start), min(len(positions), cause.stop))
    shape = templates.triangle_template(cause.length)
    turn = predictions[cause.marker].turn[:, :, part]
    size = axes[cause.marker] @ cause.size
    window = positions[part].copy()
    before = model.residual(window, part.start)
    window[:, cause.marker] -= np.einsum("jin,j->ni", turn, size) * shape[:, None]
    change = (before - model.residual(window, part.start)) @ axes[hill.marker]
    rows = slice(3 * hill.marker, 3 * hill.marker + 3)
    one = Whitened(whitened.g[rows], whitened.weight[rows], whitened.size)
    effect = fft.irfft(one.weight * fft.rfft(change.T, one.size), one.size)
    effect = np.roll(effect, part.start, axis=1)[:, hill.start : hill.stop]
    own = templates.triangle_template(hill.length)
    q = one.energy(own)
    left = one.g[:, hill.start : hill.stop] @ own - effect @ own
    return float(np.sqrt((left**2 / q).sum())) / hill.score
