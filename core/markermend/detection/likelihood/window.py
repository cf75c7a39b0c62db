"""All stages on one window of a take."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation, uniform_filter1d

from markermend.detection.likelihood import peaks, sharp, slow, steps
from markermend.detection.likelihood.filling import bridged, interpolated
from markermend.detection.likelihood.neighbours import steadiest
from markermend.detection.likelihood.nullscale import learnt_scale, speeds
from markermend.detection.likelihood.prediction import (
    MOST_NEIGHBOURS,
    Prediction,
    predict_marker,
)
from markermend.detection.likelihood.scales import rolling_quantile
from markermend.detection.likelihood.sharp import Candidate
from markermend.detection.likelihood.swaps import Swap, find_swaps, undone
from markermend.detection.likelihood.whitening import (
    Whitened,
    principal_axes,
    series_along,
    whiten,
)
from markermend.model import BoolArray, FloatArray

SHORTEST = 32  # frames below which no spectrum can be estimated
_SLOWEST_HZ = 3.0  # what is slower is no witness of peaks and steps
_OWN_FACTOR = 1.5  # how much clearer a peak must be where its path alone tells
FEWEST = 4  # markers below which there is no local frame


@dataclass(frozen=True)
class Settings:
    """The parameters of the detector; see there."""

    rate: float
    peak: float = 5.0
    noise: float = 1.0
    step: float = 4.5
    slow: float = 2.0
    least_slow: float = 1.5
    floor: float = 0.15

    @property
    def pace(self) -> float:
        """Rate over 100 Hz, at which the lengths of the stages are given."""
        return self.rate / 100.0


@dataclass(frozen=True, eq=False)
class Scan:
    """What one window gave.

    Attributes
    ----------
    candidates, swaps
        What was found, frames counted from the window's first.
    residual, final
        (n_markers, n_frames, 3) mm, lab axes: observed minus predicted, as recorded and after
        sharp artefacts were taken out.
    predicted
        (n_frames, n_markers, 3) mm: where the neighbours put each marker.
    needed
        (n_markers, n_frames) mm: amplitude that a slow change would need, or None with too few
        markers.
    """

    candidates: list[Candidate]
    swaps: list[Swap]
    residual: FloatArray
    final: FloatArray
    predicted: FloatArray
    needed: FloatArray | None


def scan_window(recorded: FloatArray, settings: Settings) -> Scan:
    """Run swaps, peaks and noise, steps, and slow changes, each on what the former left.

    Parameters
    ----------
    recorded
        (n_frames, n_markers, 3) mm; NaN where not seen; every marker is seen somewhere.
    settings
        Thresholds and scales.
    """
    seen = np.isfinite(recorded[:, :, 0])
    dense = interpolated(recorded, seen)
    swaps = find_swaps(dense, seen)
    dense = undone(dense, swaps)
    n_markers = dense.shape[1]
    neighbours = steadiest(dense, seen, MOST_NEIGHBOURS)
    alone = n_markers < FEWEST

    pace = settings.pace

    def predict(markers: NDArray[np.intp], positions: FloatArray, good: BoolArray) -> None:
        for m in markers.tolist():
            predictions[m] = predict_marker(positions, good, m, neighbours[m], pace)

    predictions: dict[int, Prediction] = {}
    valid = ~binary_dilation(~seen.T, _widened(3))  # a gap's neighbours in time are no witness
    gappy = np.flatnonzero(~seen.all(0))
    if not alone:
        # Gaps first: their linear stopgap is replaced by what the neighbours say.
        predict(gappy, dense, seen)
        for m in gappy.tolist():
            p = predictions[m]
            dense[:, m] -= p.to_lab(p.residual - bridged(p.residual, ~seen[:, m]))
        clean = _without_peaks(dense, valid, neighbours, settings)
        predict(np.arange(n_markers), clean, seen)
        residual = np.array([predictions[m].residual for m in range(n_markers)])
        for m in np.flatnonzero((clean != dense).any((0, 2))).tolist():
            residual[m] += predictions[m].to_local(dense[:, m] - clean[:, m])
        residual = np.array(
            [bridged(r, ~s) if not s.all() else r for r, s in zip(residual, seen.T, strict=True)]
        )
    else:
        residual = dense.transpose(1, 0, 2).copy()
    order = 2 if alone else 1
    own = np.ascontiguousarray(dense.transpose(1, 0, 2))
    found = _noise(own, residual, dense, valid, neighbours, settings)
    free = valid & ~_mask(found, valid.shape, 3)
    found += _peaks(own, residual, free, neighbours, order, settings)
    flagged = _mask(found, valid.shape, 0)
    calm = np.array([bridged(r, f) for r, f in zip(residual, flagged, strict=True)])
    path = own.copy()
    for m in np.flatnonzero(flagged.any(1)).tolist():
        change = residual[m] - calm[m]
        path[m] -= change if alone else predictions[m].to_lab(change)
    own_jumps = steps.jumps(_whitened(path, 2, settings), free, settings.pace)
    their_jumps = steps.jumps(_whitened(calm, order, settings), free, settings.pace)
    # No edge beside a gap or a peak: a level that was bridged there is no witness either.
    edge_free = free & ~binary_dilation(~seen.T, _widened(7))
    edge_free &= ~binary_dilation(flagged, _widened(3))
    stepped = steps.find_steps(own_jumps, their_jumps, neighbours, edge_free, settings.step, pace)
    found += stepped
    raw = residual if alone else _lab(predictions, residual)
    predicted = dense - raw.transpose(1, 0, 2)
    final, needed = calm, None
    if not alone:
        bulky = [c for c in found if c.strength >= 1 and c.kind in ("noise", "step")]
        for c in stepped:
            if c.strength >= 1:
                flagged[c.marker, c.start : c.stop] = True
                calm[c.marker] = bridged(calm[c.marker], flagged[c.marker])
                change = residual[c.marker] - calm[c.marker]
                path[c.marker] = own[c.marker] - predictions[c.marker].to_lab(change)
        touched = {c.marker for c in bulky}
        again = [
            m
            for m in range(n_markers)
            if m in touched or touched & set(predictions[m].model.features.tolist())
        ]
        clean = np.ascontiguousarray(path.transpose(1, 0, 2))
        good = seen & ~flagged.T
        predict(np.array(again, int), clean, good)
        for m in again:
            calm[m] = bridged(predictions[m].residual, ~good[:, m])
        hills, needed = _slow(calm, clean, predictions, neighbours, good.T, settings)
        found += hills
        final = _lab(predictions, calm)
    return Scan(found, swaps, raw, final, predicted, needed)


def _widened(frames: int) -> BoolArray:
    return np.ones((1, frames), bool)


def _whitened(vectors: FloatArray, steps: int, settings: Settings) -> Whitened:
    """Three series per marker along its principal axes, whitened, without slow changes.

    (n_markers, n_frames, 3) mm. A slow change must not hide a peak on it.
    """
    series = series_along(vectors, principal_axes(vectors, steps))
    return whiten(series, settings.floor, steps, _SLOWEST_HZ / settings.rate)


def _lab(predictions: dict[int, Prediction], residual: FloatArray) -> FloatArray:
    return np.array([predictions[m].to_lab(r) for m, r in enumerate(residual)])


def _mask(found: list[Candidate], shape: tuple[int, int], margin: int) -> BoolArray:
    mask = np.zeros(shape, bool)
    for c in found:
        if c.strength >= 1.0:
            mask[c.marker, max(0, c.start - margin) : c.stop + margin] = True
    return mask


def _noise(
    own: FloatArray,
    residual: FloatArray,
    dense: FloatArray,
    valid: BoolArray,
    neighbours: NDArray[np.intp],
    settings: Settings,
) -> list[Candidate]:
    mine = sharp.roughness(own, valid, settings.floor, settings.pace)
    theirs = sharp.roughness(residual, valid, settings.floor, settings.pace)
    mates = sharp.mates_of(mine, valid, neighbours)
    rough = np.minimum(mine, theirs) / np.maximum(1.0, sharp.MATE_SHARE * mates)
    return sharp.find_noise(rough, dense, settings.noise)


def _without_peaks(
    dense: FloatArray, valid: BoolArray, neighbours: NDArray[np.intp], settings: Settings
) -> FloatArray:
    """Positions without the peaks that paths alone show: what the neighbours are given to learn."""
    own = dense.transpose(1, 0, 2)
    rough = sharp.roughness(own, valid, settings.floor, settings.pace)
    rough /= np.maximum(1.0, sharp.MATE_SHARE * sharp.mates_of(rough, valid, neighbours))
    noise = sharp.find_noise(rough, dense, settings.noise)
    free = valid & ~_mask(noise, valid.shape, 3)
    axes = principal_axes(own, 2)
    mine = peaks.witness(whiten(series_along(own, axes), settings.floor, 2), free, settings.pace)
    mates = sharp.mates_of(mine.score(), free, neighbours)
    clean = dense.copy()
    for peak in peaks.find_peaks((mine,), mates, free, _OWN_FACTOR * settings.peak):
        c = peak.candidate
        if c.strength >= 1.0:
            clean[c.start : c.stop, c.marker] -= axes[c.marker] @ peak.sizes[0]
    return clean


def _peaks(
    own: FloatArray,
    residual: FloatArray,
    free: BoolArray,
    neighbours: NDArray[np.intp],
    order: int,
    settings: Settings,
) -> list[Candidate]:
    mine = peaks.witness(_whitened(own, 2, settings), free, settings.pace)
    theirs = peaks.witness(_whitened(residual, order, settings), free, settings.pace)
    mates = sharp.mates_of(mine.score(), free, neighbours)
    return [p.candidate for p in peaks.find_peaks((mine, theirs), mates, free, settings.peak)]


def _slow(
    residual: FloatArray,
    positions: FloatArray,
    predictions: dict[int, Prediction],
    neighbours: NDArray[np.intp],
    good: BoolArray,
    settings: Settings,
) -> tuple[list[Candidate], FloatArray]:
    pace = settings.pace
    axes = principal_axes(residual, 1)
    whitened = whiten(series_along(residual, axes), settings.floor, 1)
    best = slow.scan(whitened, pace)
    valid = best.score > 0
    width = max(3, round(31 * pace))
    mates = np.median(speeds(positions, settings.rate, width)[neighbours[:, :4]], axis=1)
    leverage = np.array([predictions[m].leverage for m in range(len(residual))])
    leverage = uniform_filter1d(leverage, width, axis=1, mode="nearest")
    usual = rolling_quantile(best.score, valid, round(200 * pace), max(5, round(20 * pace)), 0.5)
    covariates = (mates + 5.0, leverage + 1e-4, usual + 0.2)
    typical = learnt_scale(best.score, covariates, valid & good)
    scale = slow.held_back(best.score, typical, valid, pace)
    found = slow.find_slow(
        whitened,
        scale,
        best,
        ~good,
        axes,
        predictions,
        positions,
        settings.slow,
        settings.least_slow,
        pace,
    )
    return found, slow.needed(whitened, scale, settings.slow, pace)
