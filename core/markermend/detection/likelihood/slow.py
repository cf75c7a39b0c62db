"""Slow changes: triangles that the neighbours' prediction cannot explain."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy import fft

from markermend.detection.likelihood import templates
from markermend.detection.likelihood.prediction import Prediction
from markermend.detection.likelihood.sharp import LEAST, Candidate
from markermend.detection.likelihood.whitening import Whitened
from markermend.model import BoolArray, FloatArray

# Frames at 100 Hz; `pace` is the rate over 100 Hz.
LENGTHS = (33, 41, 51, 63, 79)
_BOXES = (12, 20, 30, 45, 65)
_AROUND = 50  # within these nothing much may be left
_MOST_BOX = 1.0  # a box of any length that scores higher is no triangle
_MOST_LABELLED = 0.3
_QUANTILE_POWER = 0.7
_ONE_ARTEFACT = 100  # frames at 100 Hz on which one slow change raises the score
_MASKED = 10  # frames beside a triangle in which no second one is looked for
_ECHO = 0.6  # a score that falls below this share was an echo


@dataclass(frozen=True, eq=False)
class Triangles:
    """The best triangle centred on each frame: (n_markers, n_frames) each."""

    score: FloatArray
    length: FloatArray


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
        (3,) mm in local axes.
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
    """Score triangles of all lengths, centred on every frame where they fit."""
    total = templates.sums(whitened)
    n = whitened.g.shape[1]
    best = np.zeros((len(total) // 3, n))
    length = np.full(best.shape, lengths(pace)[0])
    for L in lengths(pace):
        if n < L:
            continue
        shape = templates.triangle_template(L)
        z = templates.score(templates.triangles(total, L), whitened.energy(shape))
        part = slice(L // 2, L // 2 + z.shape[1])
        better = z > best[:, part]
        best[:, part] = np.where(better, z, best[:, part])
        length[:, part] = np.where(better, L, length[:, part])
    return Triangles(best, length)


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

    Its direction is taken as unknown: the energies of the three axes are averaged.
    """
    shape = templates.triangle_template(lengths(pace)[len(lengths(pace)) // 2])
    energy = whitened.energy(shape).reshape(-1, 3).mean(1)
    amplitude: FloatArray = threshold * scale / np.sqrt(energy)[:, None]
    return amplitude


def find_slow(
    whitened: Whitened,
    scale: FloatArray,
    triangles: Triangles,
    labelled: BoolArray,
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
            here = _explained(hill, rival, whitened, predictions, positions)
            there = _explained(rival, hill, whitened, predictions, positions)
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
    u = u.copy()
    hills: list[Hill] = []
    while True:
        m, t = (int(i) for i in np.unravel_index(int(u.argmax()), u.shape))
        value = float(u[m, t])
        if value < least:
            return hills
        L = int(triangles.length[m, t])
        start = t - L // 2
        u[m, max(0, start - _MASKED) : start + L + _MASKED] = 0.0
        if labelled[m, start : start + L].mean() > _MOST_LABELLED:
            continue
        hill = _taken_out(whitened, m, start, L, value, pace)
        if hill.value >= least and np.sqrt((hill.size**2).sum()) >= least_mm:
            hills.append(hill)


def _taken_out(whitened: Whitened, marker: int, start: int, L: int, u: float, pace: float) -> Hill:
    """Fit the triangle, take it out, and see what is left and whether a box does better."""
    rows = slice(3 * marker, 3 * marker + 3)
    reach = round(_AROUND * pace)
    margin = reach + lengths(pace)[-1]
    low = max(0, start + L // 2 - margin)
    high = min(whitened.g.shape[1], start + L // 2 + margin + 1)
    one = Whitened(whitened.g[rows, low:high], whitened.weight[rows], whitened.size)
    n = high - low
    offset, start = start, start - low
    shape = templates.triangle_template(L)
    q = one.energy(shape)
    N = one.g[:, start : start + L] @ shape
    score = float(np.sqrt((N * N / q).sum()))
    answer = fft.irfft(one.weight * fft.rfft(shape, one.size), one.size)
    answer = np.roll(answer, start, axis=1)[:, :n]
    rest = Whitened(one.g - (N / q)[:, None] * answer, one.weight, one.size)
    middle = start + L // 2
    around = scan(rest, pace).score[0, max(0, middle - reach) : middle + reach + 1]
    left = float(around.max()) / score
    total = templates.sums(one)
    for length in (max(2, round(L * pace)) for L in _BOXES):
        if length < n:
            z = templates.score(templates.boxes(total, length), one.energy(np.ones(length)))[0]
            if z[max(0, start - length // 2) : start + L].max(initial=0.0) > _MOST_BOX * score:
                left = 1.0
    return Hill(marker, offset, L, score, u * max(0.0, 1.0 - left), left, N / q)


def _explained(
    hill: Hill,
    cause: Hill,
    whitened: Whitened,
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
    window = positions[part].copy()
    before = model.residual(window, part.start)
    window[:, cause.marker] -= np.einsum("jin,j->ni", turn, cause.size) * shape[:, None]
    change = before - model.residual(window, part.start)
    rows = slice(3 * hill.marker, 3 * hill.marker + 3)
    one = Whitened(whitened.g[rows], whitened.weight[rows], whitened.size)
    effect = fft.irfft(one.weight * fft.rfft(change.T, one.size), one.size)
    effect = np.roll(effect, part.start, axis=1)[:, hill.start : hill.stop]
    own = templates.triangle_template(hill.length)
    q = one.energy(own)
    left = one.g[:, hill.start : hill.stop] @ own - effect @ own
    return float(np.sqrt((left**2 / q).sum())) / hill.score
