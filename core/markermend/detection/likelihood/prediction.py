"""Predict each marker from its neighbours; no frame takes part in predicting itself."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from markermend.detection.likelihood.frames import best_rotations
from markermend.model import BoolArray, FloatArray

# (markers that carry the frame of reference, markers that predict in it): small sets are exact on
# rigid segments, large ones help where nothing is rigid. The choice is made per marker.
CHOICES = ((3, 3), (4, 6), (3, 10), (4, 16))
MOST_NEIGHBOURS = max(n for _, n in CHOICES)

# Frames at 100 Hz; `pace` is the rate over 100 Hz.
_HALF_BLOCK = 40  # a fold is two half blocks, trained without these and the half block on each side
_FADE = 30  # frames over which the predictions of two folds are blended
_RIDGE_MM = 0.5  # ridge as the noise, per feature and frame, that it stands for
_HUBER = 2.0  # residuals beyond this many median norms lose weight
_TREND = 101  # frames of the running means that keep slow drifts out of the fit
_BETTER = 0.97  # a larger choice must reduce the error to this


@dataclass(frozen=True, eq=False)
class Carrier:
    """A local frame of reference: the markers that carry it and their usual shape (k, 3) mm."""

    markers: NDArray[np.intp]
    usual: FloatArray

    def follow(self, positions: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Give lab-to-local rotations (3, 3, n_frames) and centres (n_frames, 3)."""
        points = positions[:, self.markers]
        centre = points.mean(1)
        b = points - centre[:, None]
        H = np.einsum("nki,kj->ijn", b, self.usual)
        sizes = ((self.usual**2).sum() + (b * b).sum((1, 2))) / 2
        return best_rotations(H, sizes), centre


@dataclass(frozen=True, eq=False)
class Model:
    """How one marker is predicted from its neighbours.

    Attributes
    ----------
    marker, features
        Indices.
    carrier
        The frame of reference.
    origin
        (3 * n_features + 3,): usual local coordinates of the features and of the marker.
    coefficients
        (n_folds, 3 * n_features, 3).
    bounds
        (n_folds + 1,): first frames of the folds, and the end.
    fade
        Frames over which the predictions of two folds are blended.
    """

    marker: int
    features: NDArray[np.intp]
    carrier: Carrier
    origin: FloatArray
    coefficients: FloatArray
    bounds: NDArray[np.intp]
    fade: int

    def residual(self, positions: FloatArray, start: int) -> FloatArray:
        """Give observed minus predicted in local axes, for a stretch of other positions.

        Parameters
        ----------
        positions
            (n, n_markers, 3) mm, beginning at frame `start` of those that were learnt from.
        start
            First frame.
        """
        turn, centre = self.carrier.follow(positions)
        local = _local(positions, self.features, self.marker, turn, centre) - self.origin
        shares = _shares(self.bounds, self.fade, start, start + len(positions))
        predicted = np.zeros((len(positions), 3))
        for fold, share in shares:
            predicted += share[:, None] * (local[:, :-3] @ self.coefficients[fold])
        result: FloatArray = local[:, -3:] - predicted
        return result


@dataclass(frozen=True, eq=False)
class Prediction:
    """What the neighbours say about one marker, in the local frame of reference.

    Attributes
    ----------
    model
        How it was made.
    residual
        (n_frames, 3) mm: observed minus predicted.
    turn
        (3, 3, n_frames): lab to local rotations.
    leverage
        (n_frames,): how far outside the usual postures the frame's features lie.
    """

    model: Model
    residual: FloatArray
    turn: FloatArray
    leverage: FloatArray

    def to_lab(self, vectors: FloatArray) -> FloatArray:
        """Turn local vectors (n_frames, 3) into lab directions."""
        result: FloatArray = np.einsum("jin,nj->ni", self.turn, vectors)
        return result

    def to_local(self, vectors: FloatArray) -> FloatArray:
        """Turn lab vectors (n_frames, 3) into local directions."""
        result: FloatArray = np.einsum("ijn,nj->ni", self.turn, vectors)
        return result


@dataclass(frozen=True, eq=False)
class _View:
    """A marker and its neighbours in one frame of reference, with and without slow drifts."""

    carrier: Carrier
    turn: FloatArray
    origin: FloatArray
    local: FloatArray
    detrended: FloatArray


def predict_marker(
    positions: FloatArray,
    trusted: BoolArray,
    marker: int,
    neighbours: NDArray[np.intp],
    pace: float = 1.0,
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
        Indices of the others, steadiest first; at least 3.
    pace
        Rate over 100 Hz.
    """
    most = len(neighbours)
    fade = max(2, round(_FADE * pace))
    half_block = max(4, round(_HALF_BLOCK * pace))
    choices = dict.fromkeys((min(k, most), min(n, most)) for k, n in CHOICES)
    weight = trusted[:, marker].astype(np.float64)
    views: dict[int, _View] = {}
    grams: dict[int, _Grams] = {}
    best: tuple[float, int, int] | None = None
    for k, n in choices:
        if k not in views:
            widest = max(m for j, m in choices if j == k)
            views[k] = _view(positions, marker, neighbours[:k], neighbours[:widest], pace)
            grams[k] = _Grams(views[k].detrended, weight, half_block)
        error = grams[k].error(3 * n)
        if best is None or error < _BETTER * best[0]:
            best = (error, k, n)
    assert best is not None
    _, k, n = best
    view = views[k]
    keep = np.r_[0 : 3 * n, view.local.shape[1] - 3 : view.local.shape[1]]
    local, detrended = view.local[:, keep], view.detrended[:, keep]
    coefficients, inverse = _Grams(detrended, grams[k].reweighted(3 * n), half_block).folds(3 * n)
    bounds = grams[k].bounds[::2]
    predicted, leverage = np.zeros((len(local), 3)), np.zeros(len(local))
    for i, share in _shares(bounds, fade, 0, len(local)):
        part = np.flatnonzero(share)
        part_of = slice(part[0], part[-1] + 1)
        F = detrended[part_of, :-3]
        predicted[part_of] += share[part_of, None] * (local[part_of, :-3] @ coefficients[i])
        leverage[part_of] += share[part_of] * ((F @ inverse[i]) * F).sum(1)
    model = Model(
        marker, neighbours[:n], view.carrier, view.origin[keep], coefficients, bounds, fade
    )
    return Prediction(model, local[:, -3:] - predicted, view.turn, leverage)


def _carrier(positions: FloatArray, markers: NDArray[np.intp]) -> Carrier:
    """Take the median shape after alignment with the frame of median size.

    The axes are that shape's own principal ones, so that nothing depends on those of the lab.
    """
    points = positions[:, markers]
    b = points - points.mean(1, keepdims=True)
    size = (b * b).sum((1, 2))
    typical = b[np.argsort(size, kind="stable")[len(size) // 2]]
    axes = np.linalg.eigh(typical.T @ typical)[1]
    axes[:, 2] *= np.sign(np.linalg.det(axes))  # turned, not mirrored
    first = Carrier(markers, typical @ axes)
    some = positions[:: max(1, len(positions) // 200)]
    turn, centre = first.follow(some)
    aligned = np.einsum("ijn,nkj->nki", turn, some[:, markers] - centre[:, None])
    usual = np.median(aligned, axis=0)
    return Carrier(markers, usual - usual.mean(0))


def _local(
    positions: FloatArray,
    features: NDArray[np.intp],
    marker: int,
    turn: FloatArray,
    centre: FloatArray,
) -> FloatArray:
    """Local coordinates of the features and, last, of the marker: (n_frames, 3 * k + 3)."""
    points = positions[:, np.append(features, marker)] - centre[:, None]
    turned = np.matmul(points, turn.transpose(2, 1, 0))
    flat: FloatArray = turned.reshape(len(turned), -1)
    return flat


def _view(
    positions: FloatArray,
    marker: int,
    carriers: NDArray[np.intp],
    features: NDArray[np.intp],
    pace: float,
) -> _View:
    carrier = _carrier(positions, carriers)
    turn, centre = carrier.follow(positions)
    local = _local(positions, features, marker, turn, centre)
    origin = np.median(local[:: max(1, len(local) // 300)], axis=0)
    local = local - origin
    trend = local
    width = min(max(3, 2 * round(_TREND * pace / 2) + 1), max(1, len(local) // 2 * 2 - 1))
    for _ in range(3):
        trend = uniform_filter1d(trend, width, axis=0, mode="nearest")
    return _View(carrier, turn, origin, local, local - trend)


class _Grams:
    """Normal equations of a ridge regression by half blocks, so that any fold is a difference.

    The last three columns of the data are the target.
    """

    def __init__(self, data: FloatArray, weight: FloatArray, half_block: int) -> None:
        n = len(data)
        halves = max(2, round(n / half_block / 2) * 2)
        self.bounds = np.linspace(0, n, halves + 1).astype(np.intp)
        self.weight = weight
        lengths = np.diff(self.bounds)
        rows = self.bounds[:-1, None] + np.arange(lengths.max())
        inside = np.arange(lengths.max()) < lengths[:, None]
        self.rows = np.minimum(rows, n - 1)
        self.inside = inside
        self.data = data[self.rows] * inside[..., None]
        self.weights = weight[self.rows] * inside
        grams = np.matmul(np.swapaxes(self.data * self.weights[..., None], 1, 2), self.data)
        out = np.zeros((halves // 2, *grams.shape[1:]))
        for i in range(halves // 2):
            out[i] = grams[max(0, 2 * i - 1) : min(halves, 2 * i + 3)].sum(0)
        self.left = grams.sum(0) - out

    def folds(self, p: int) -> tuple[FloatArray, FloatArray]:
        """Coefficients (n_folds, p, 3) and inverses (n_folds, p, p) of the first p features."""
        ridge = _RIDGE_MM**2 * max(float(self.weight.sum()), 1.0)
        inverse = np.linalg.inv(self.left[:, :p, :p] + ridge * np.eye(p))
        return np.matmul(inverse, self.left[:, :p, -3:]), inverse

    def norms(self, p: int) -> FloatArray:
        """(n_half_blocks, width): sizes of the left-out residuals."""
        ridge = _RIDGE_MM**2 * max(float(self.weight.sum()), 1.0)
        solved = np.linalg.solve(self.left[:, :p, :p] + ridge * np.eye(p), self.left[:, :p, -3:])
        rest = self.data[:, :, -3:] - np.matmul(self.data[:, :, :p], np.repeat(solved, 2, axis=0))
        norms: FloatArray = np.sqrt((rest * rest).sum(2))
        return norms

    def error(self, p: int) -> float:
        """Left-out error with p features, mm, hardly moved by artefacts."""
        good = self.weights > 0
        if not good.any():
            return np.inf
        return float(np.mean(np.sqrt(self.norms(p)[good]))) ** 2

    def reweighted(self, p: int) -> FloatArray:
        """(n_frames,): weights after one Huber step."""
        norm = self.norms(p)
        good = self.weights > 0
        usual = float(np.median(norm[good])) if good.any() else 1.0
        factor = np.minimum(1.0, _HUBER * usual / np.maximum(norm, 1e-9))
        out = self.weight.copy()
        out[self.rows[self.inside]] *= factor[self.inside]
        return out


def _shares(
    bounds: NDArray[np.intp], fade: int, start: int, stop: int
) -> list[tuple[int, FloatArray]]:
    """How much each fold counts in frames start to stop; shares of a frame add up to 1."""
    t = np.arange(start, stop)
    last = len(bounds) - 2
    found = []
    for i, (a, b) in enumerate(pairwise(bounds.tolist())):
        left = np.ones(len(t)) if i == 0 else (t - a + fade + 0.5) / (2 * fade)
        right = np.ones(len(t)) if i == last else (b + fade - t - 0.5) / (2 * fade)
        share = np.clip(np.minimum(left, right), 0.0, 1.0)
        if share.any():
            found.append((i, share))
    total = np.sum([share for _, share in found], axis=0)
    return [(i, share / total) for i, share in found]
