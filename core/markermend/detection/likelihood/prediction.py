"""Predict each marker from its neighbours; no frame takes part in predicting itself."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from markermend.detection.likelihood.frames import best_rotations
from markermend.model import BoolArray, FloatArray

# (markers that carry the frame of reference, markers that predict in it): small sets are exact on
# rigid segments, large ones help where nothing is rigid. The choice is made per marker.
CHOICES = ((3, 3), (4, 6), (3, 10), (4, 16))
MOST_NEIGHBOURS = max(n for _, n in CHOICES)

HALF_BLOCK = 40  # a fold is two half blocks, trained without these and the half block on each side
FADE = 30  # frames over which the predictions of two folds are blended
_RIDGE_MM = 0.5  # ridge as the noise, per feature and frame, that it stands for
_HUBER = 2.0  # residuals beyond this many median norms lose weight
_TREND = 101  # frames of the running means that keep slow drifts out of the fit


@dataclass(frozen=True, eq=False)
class Prediction:
    """What the neighbours say about one marker, in the local frame of reference.

    Attributes
    ----------
    residual
        (n_frames, 3) mm: observed minus predicted.
    turn
        (3, 3, n_frames): lab to local rotations.
    leverage
        (n_frames,): how far outside the usual postures the frame's features lie.
    carriers, features
        Indices of the markers used.
    """

    residual: FloatArray
    turn: FloatArray
    leverage: FloatArray
    carriers: NDArray[np.intp]
    features: NDArray[np.intp]
    error: float

    def to_lab(self, vectors: FloatArray, frames: slice = slice(None)) -> FloatArray:
        """Turn local vectors (n, 3) of these frames into lab directions."""
        return np.einsum("jin,nj->ni", self.turn[:, :, frames], vectors)

    def to_local(self, vectors: FloatArray) -> FloatArray:
        """Turn lab vectors (n_frames, 3) into local directions."""
        return np.einsum("ijn,nj->ni", self.turn, vectors)


def local_frames(positions: FloatArray, markers: NDArray[np.intp]) -> tuple[FloatArray, FloatArray]:
    """Follow a few markers: lab-to-local rotations (3, 3, n_frames) and centres (n_frames, 3).

    The usual shape is the mean over frames after alignment with the frame of the most usual
    distances. The nearest markers count fully.
    """
    points = positions[:, markers]
    centre = points.mean(1)
    b = points - centre[:, None]
    size = (b * b).sum((1, 2))
    usual = b[np.argsort(size, kind="stable")[len(size) // 2]]
    some = slice(None, None, max(1, len(b) // 200))
    for part in (some, slice(None)):
        H = np.einsum("nki,kj->ijn", b[part], usual)
        turn = best_rotations(H, ((usual * usual).sum() + size[part]) / 2)
        if part is some:
            aligned = np.einsum("ijn,nkj->nki", turn, b[part])
            usual = np.median(aligned, axis=0)
            usual = usual - usual.mean(0)
    return turn, centre


def predict_marker(
    positions: FloatArray,
    trusted: BoolArray,
    marker: int,
    neighbours: NDArray[np.intp],
) -> Prediction:
    """Predict one marker in the frame of reference and from the neighbours that suit it best.

    Parameters
    ----------
    positions
        (n_frames, n_markers, 3) mm, without NaN.
    trusted
        (n_frames, n_markers): frames that may be learnt from.
    marker
        Index.
    neighbours
        Indices of the others, steadiest first.
    """
    best: Prediction | None = None
    made: dict[int, tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]] = {}
    for k, n in CHOICES:
        if n > len(neighbours) and best is not None:
            continue
        k, n = min(k, len(neighbours)), min(n, len(neighbours))
        widest = max((min(w, len(neighbours)) for j, w in CHOICES if j == k), default=n)
        if k not in made:
            turn, centre = local_frames(positions, neighbours[:k])
            used = np.concatenate((neighbours[:widest], [marker]))
            local = np.einsum("ijn,nkj->nki", turn, positions[:, used] - centre[:, None])
            local = local.reshape(len(local), -1)
            local = local - np.median(local, axis=0)
            made[k] = (turn, local[:, :-3], local[:, -3:], *_detrended(local))
        turn, Z, y, Zd, yd = made[k]
        p = 3 * n
        weight = trusted[:, marker].astype(np.float64)
        residual, leverage, error = _regress(Z[:, :p], y, Zd[:, :p], yd, weight)
        if best is None or error < 0.97 * best.error:
            best = Prediction(residual, turn, leverage, neighbours[:k], neighbours[:n], error)
    assert best is not None
    return best


def _detrended(local: FloatArray) -> tuple[FloatArray, FloatArray]:
    trend = local
    for _ in range(3):
        trend = uniform_filter1d(
            trend, min(_TREND, len(local) // 2 * 2 - 1), axis=0, mode="nearest"
        )
    rest = local - trend
    return rest[:, :-3], rest[:, -3:]


def _regress(
    Z: FloatArray, y: FloatArray, Zd: FloatArray, yd: FloatArray, weight: FloatArray
) -> tuple[FloatArray, FloatArray, float]:
    """Ridge regression with leave-block-out folds and one Huber reweighting."""
    n, p = Z.shape
    halves = max(2, round(n / HALF_BLOCK / 2) * 2)
    bounds = np.linspace(0, n, halves + 1).astype(int)
    width = int(np.diff(bounds).max())
    padded = np.zeros((halves, width, p + 3))
    weights = np.zeros((halves, width))
    for h in range(halves):
        part = slice(bounds[h], bounds[h + 1])
        padded[h, : bounds[h + 1] - bounds[h], :p] = Zd[part]
        padded[h, : bounds[h + 1] - bounds[h], p:] = yd[part]
        weights[h, : bounds[h + 1] - bounds[h]] = weight[part]
    residual = inverse = coefficients = np.empty(0)
    for reweighted in (False, True):
        grams = np.matmul(np.swapaxes(padded[:, :, :p] * weights[:, :, None], 1, 2), padded)
        near = grams.copy()
        near[1:] += grams[:-1]
        near[:-1] += grams[1:]
        folds = halves // 2
        left_out = np.empty((folds, p, p + 3))
        for i in range(folds):
            low, high = max(0, 2 * i - 1), min(halves, 2 * i + 3)
            left_out[i] = grams[low:high].sum(0)
        G = grams.sum(0) - left_out
        ridge = _RIDGE_MM**2 * max(weight.sum(), 1.0)
        inverse = np.linalg.inv(G[:, :, :p] + ridge * np.eye(p))
        coefficients = np.matmul(inverse, G[:, :, p:])
        if not reweighted:
            rest = padded[:, :, p:] - np.matmul(
                padded[:, :, :p], np.repeat(coefficients, 2, axis=0)
            )
            norm = np.sqrt((rest * rest).sum(2))
            usual = np.median(norm[weights > 0]) if (weights > 0).any() else 1.0
            weights = weights * np.minimum(1.0, _HUBER * usual / np.maximum(norm, 1e-9))
    rest = padded[:, :, p:] - np.matmul(padded[:, :, :p], np.repeat(coefficients, 2, axis=0))
    norm = np.sqrt((rest * rest).sum(2))
    error = float(np.mean(np.sqrt(norm[weights > 0]))) ** 2 if (weights > 0).any() else np.inf
    residual, leverage = _faded(Z, y, Zd, coefficients, inverse, bounds[::2])
    return residual, leverage, error


def _faded(
    Z: FloatArray,
    y: FloatArray,
    Zd: FloatArray,
    coefficients: FloatArray,
    inverse: FloatArray,
    bounds: NDArray[np.intp],
) -> tuple[FloatArray, FloatArray]:
    n = len(Z)
    predicted = np.zeros_like(y)
    leverage = np.zeros(n)
    total = np.zeros(n)
    for i, (a, b) in enumerate(zip(bounds[:-1], bounds[1:], strict=True)):
        low, high = max(0, a - FADE), min(n, b + FADE)
        t = np.arange(low, high)
        left = np.ones(len(t)) if a == 0 else (t - a + FADE + 0.5) / (2 * FADE)
        right = np.ones(len(t)) if b == n else (b + FADE - t - 0.5) / (2 * FADE)
        share = np.clip(np.minimum(left, right), 0.0, 1.0)
        predicted[low:high] += share[:, None] * (Z[low:high] @ coefficients[i])
        F = Zd[low:high]
        leverage[low:high] += share * ((F @ inverse[i]) * F).sum(1)
        total[low:high] += share
    return y - predicted / total[:, None], leverage / total
