"""Fill one marker from all others through principal components (Gløersen and Federolf, 2016)."""

from dataclasses import dataclass

import numpy as np

from markermend.errors import CannotRepair
from markermend.model import BoolArray, FloatArray
from markermend.repairing.remembering import remembered
from markermend.repairing.window import Window


@dataclass(frozen=True)
class Settings:
    """The parameters of the paper.

    Attributes
    ----------
    sigma
        Scale of the weights exp(-d² / 2 sigma²) by mean distance, mm.
    own_weight
        Weight of the markers to be filled.
    cumulative
        Share of the sum of singular values that the components kept must reach.
    by_axis
        Whether each axis of a marker is scaled to unit variance by itself, as in the paper, or all
        axes of it by one number, so that the result turns with the room.
    """

    sigma: float = 200.0
    own_weight: float = 0.02
    cumulative: float = 0.99
    by_axis: bool = True


def centred(cut: Window) -> FloatArray:
    """Give what to subtract so that the data moves with the body.

    Returns
    -------
    (n_frames, n_dims) mm: the mean of the markers that are seen throughout; where none is, the
    mean of all that is seen, the same for every frame.
    """
    complete = cut.seen.all(axis=0)
    if complete.any():
        return np.asarray(cut.positions[:, complete].mean(axis=1))
    return np.tile(cut.positions[cut.seen].mean(axis=0), (cut.n_frames, 1))


def mean_distances(positions: FloatArray, marker: int) -> FloatArray:
    """Average the distance of one marker to each over the frames where both are seen.

    Returns
    -------
    (n_markers,) mm, infinite where two are never seen together; every few frames are looked at.
    """
    step = max(1, len(positions) // 500)
    some = positions[::step]
    distance = np.linalg.norm(some - some[:, marker, None], axis=2)
    known = np.isfinite(distance)
    count = known.sum(axis=0)
    total = np.where(known, distance, 0.0).sum(axis=0)
    return np.where(count > 0, total / np.maximum(count, 1), np.inf)


def reconstruct(
    complete: FloatArray,
    gapped: FloatArray,
    missing: BoolArray,
    distances: FloatArray,
    settings: Settings,
) -> FloatArray:
    """Map frames without the missing markers to frames with them.

    Parameters
    ----------
    complete
        (n_frames, n_markers, n_dims) mm: frames to learn from, all seen.
    gapped
        (n_gapped, n_markers, n_dims) mm: frames to fill; the missing markers are not read.
    missing
        (n_markers,): which are missing.
    distances
        (n_markers,) mm: to the nearest missing marker.

    Returns
    -------
    (n_gapped, n_markers, n_dims) mm.

    Raises
    ------
    CannotRepair
        If fewer than two frames are complete.

    References
    ----------
    Gløersen and Federolf 2016, and Federolf 2013, Eq. 1: M (zeros) → PC space of the zeroed data
    → T → PC space of the full data.
    """
    if len(complete) < 2:
        raise CannotRepair(
            "No frames show all the markers that would be needed; choose a method that looks at a "
            "few neighbours, such as rigid or wpca."
        )
    n_dims = complete.shape[2]
    weight = np.exp(-np.square(distances) / (2.0 * settings.sigma**2))
    weight[missing] = settings.own_weight
    weights, void = np.repeat(weight, n_dims), np.repeat(missing, n_dims)
    full = complete.reshape(len(complete), -1)
    mean = full.mean(axis=0)
    full = full - mean
    gram = full.T @ full
    variance = np.diag(gram) / len(full)
    if not settings.by_axis:
        variance = np.repeat(variance.reshape(-1, n_dims).mean(axis=1), n_dims)
    spread = np.sqrt(variance)
    scale = weights / np.where(spread > 0, spread, 1.0)
    gram *= scale[:, None] * scale
    basis, size = _components(gram)
    zeroed, zeroed_size = _components(np.where(void | void[:, None], 0.0, gram))
    keep = max(_needed(size, settings.cumulative), _needed(zeroed_size, settings.cumulative))
    basis, zeroed = basis[:, :keep], zeroed[:, :keep]
    given = np.where(void, 0.0, (gapped.reshape(len(gapped), -1) - mean) * scale)
    between = basis.T @ zeroed
    filled = given @ zeroed @ between @ basis.T
    safe = np.where(scale > 0, scale, 1.0)
    return np.asarray((mean + filled / safe).reshape(gapped.shape))


def _components(gram: FloatArray) -> tuple[FloatArray, FloatArray]:
    values, vectors = np.linalg.eigh(gram)
    return vectors[:, ::-1], np.sqrt(np.maximum(values[::-1], 0.0))


def _needed(size: FloatArray, share: float) -> int:
    total = size.cumsum()
    return int(np.argmax(total >= share * total[-1])) + 1


def fill_r1(cut: Window, settings: Settings) -> FloatArray:
    """Fill the span by strategy R1: one map for all markers that have a gap.

    Returns
    -------
    (len(span), n_dims) mm.
    """
    middle = centred(cut)
    data = cut.positions - middle[:, None]
    known: BoolArray = np.asarray(cut.seen.any(axis=0))
    data, seen = data[:, known], cut.seen[:, known]
    marker = int(known[: cut.marker].sum())
    missing: BoolArray = np.asarray(~seen.all(axis=0))
    distances = np.min([mean_distances(data, int(m)) for m in np.flatnonzero(missing)], axis=0)
    frames = cut.span.frames
    filled = reconstruct(data[seen.all(axis=1)], data[frames], missing, distances, settings)
    return np.asarray(filled[:, marker] + middle[frames])


@remembered
def fill_r2(cut: Window, settings: Settings, reach: float) -> FloatArray:
    """Fill the span by strategy R2: other gapped markers help where they are near and seen.

    Parameters
    ----------
    reach
        How near, as a share of the mean distance to all markers.

    Returns
    -------
    (len(span), n_dims) mm.
    """
    middle = centred(cut)
    data = cut.positions - middle[:, None]
    frames = cut.span.frames
    distances = mean_distances(data, cut.marker)
    near = distances <= reach * distances[np.isfinite(distances)].mean()
    keep = (cut.seen.all(axis=0) | near) & cut.seen[frames].all(axis=0)
    keep[cut.marker] = True
    marker = int(keep[: cut.marker].sum())
    if keep.sum() < 2:
        raise CannotRepair(
            f"No other marker near {cut.label} is seen throughout the span; choose a method that "
            "needs none, such as pchip."
        )
    data, seen = data[:, keep], cut.seen[:, keep]
    missing = np.arange(data.shape[1]) == marker
    filled = reconstruct(data[seen.all(axis=1)], data[frames], missing, distances[keep], settings)
    return np.asarray(filled[:, marker] + middle[frames])
