"""How constant the distances between markers are, from a sample of the frames."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from markermend.model import FloatArray

N_SAMPLES = 400
# Markers that the even sample sees less often than this get frames of their own.
FEW = 12
# The share of the largest and of the smallest distances that is cut to the next value, so that
# single artefacts do not make a pair look loose.
TRIM = 0.02
# Weight of nearness beside steadiness.
NEARNESS = 0.5


@dataclass(frozen=True, eq=False)
class Rigidity:
    """Statistics of all pairs of markers, each (n_markers, n_markers) and symmetric.

    Attributes
    ----------
    distance
        Mean distance in mm; NaN where the two are never seen together.
    spread
        Standard deviation of the distance in mm; NaN likewise.
    coherence
        Correlation of the displacements of the two, -1 to 1; 0 where unknown.
    """

    distance: FloatArray
    spread: FloatArray
    coherence: FloatArray

    @property
    def cost(self) -> FloatArray:
        """How little two markers belong together; inf if unknown.

        The spread in units of the usual spread, so that a person who stands still falls into
        parts as well, plus a share of the distance in units of the usual distance.
        """
        cost = self.spread / _usual(self.spread) + NEARNESS * self.distance / _usual(self.distance)
        return np.where(np.isfinite(cost), cost, np.inf)


def sample_frames(seen: NDArray[np.bool_], n_samples: int = N_SAMPLES) -> NDArray[np.intp]:
    """Choose frames evenly, and some more for the markers that are seldom seen.

    Parameters
    ----------
    seen
        (n_frames, n_markers).
    n_samples
        Number of evenly spaced frames.
    """
    n_frames = len(seen)
    even = np.unique(np.linspace(0, n_frames - 1, min(n_samples, n_frames)).astype(np.intp))
    extra = [even]
    for marker in np.flatnonzero(seen[even].sum(axis=0) < FEW):
        own = np.flatnonzero(seen[:, marker])
        extra.append(own[np.linspace(0, len(own) - 1, min(FEW, len(own))).astype(np.intp)])
    return np.unique(np.concatenate(extra))


def measure(
    positions: FloatArray, seen: NDArray[np.bool_], markers: NDArray[np.intp], rate: float
) -> Rigidity:
    """Measure all pairs on a sample of the frames; cost does not grow with the take.

    Parameters
    ----------
    positions
        (n_frames, n_markers, n_dims) mm, NaN where not seen.
    seen
        (n_frames, n_markers).
    markers
        Indices of the markers to measure.
    rate
        Hz; displacements are taken over 0.1 s.
    """
    frames = sample_frames(seen[:, markers])
    sample = positions[np.ix_(frames, markers)]
    n_markers = len(markers)
    distance = np.full((n_markers, n_markers), np.nan)
    spread = np.full((n_markers, n_markers), np.nan)
    for marker in range(n_markers):
        apart = np.sqrt(((sample[:, marker:] - sample[:, marker, None]) ** 2).sum(axis=2))
        mean, std = _trimmed(apart)
        distance[marker, marker:] = distance[marker:, marker] = mean
        spread[marker, marker:] = spread[marker:, marker] = std
    later = np.minimum(frames + max(1, round(0.1 * rate)), len(positions) - 1)
    moved = positions[np.ix_(later, markers)] - sample
    return Rigidity(distance, spread, _coherence(np.nan_to_num(moved)))


def _usual(values: FloatArray) -> float:
    """Median over the pairs of two different markers."""
    pairs = values[np.triu_indices(len(values), 1)]
    pairs = pairs[np.isfinite(pairs)]
    return max(float(np.median(pairs)), 1e-6) if len(pairs) else 1.0


def _trimmed(values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Mean and standard deviation of each column's finite values, extremes cut."""
    values = np.sort(values, axis=0)  # NaN last
    counts = np.isfinite(values).sum(axis=0)
    columns = np.arange(values.shape[1])
    cut = (TRIM * counts).astype(np.intp)
    low = values[np.minimum(cut, len(values) - 1), columns]
    high = values[np.maximum(counts - 1 - cut, 0), columns]
    known = np.arange(len(values))[:, None] < counts
    values = np.where(known, np.clip(values, low, high), 0.0)
    safe = np.maximum(counts, 1)
    mean = values.sum(axis=0) / safe
    std = np.sqrt((np.where(known, values - mean, 0.0) ** 2).sum(axis=0) / safe)
    return np.where(counts, mean, np.nan), np.where(counts, std, np.nan)


def _coherence(moved: FloatArray) -> FloatArray:
    size = np.linalg.norm(moved, axis=2, keepdims=True)
    # A jump of one marker must not decide: long displacements count as their direction only.
    usual = np.median(size[size > 0]) if (size > 0).any() else 1.0
    moved = moved / np.maximum(size, usual)
    product = np.einsum("fid,fjd->ij", moved, moved, optimize=True)
    norm = np.sqrt(np.diag(product))
    scale = np.outer(norm, norm)
    coherence: FloatArray = np.divide(product, scale, out=np.zeros_like(product), where=scale > 0)
    return coherence
