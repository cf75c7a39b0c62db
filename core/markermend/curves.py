"""Curves as screens need them: thinned without losing a spike, and small enough to send."""

import warnings

import numpy as np

from markermend.model import BoolArray, FloatArray, Span, Take
from markermend.repairing.geometry import kabsch


def thinned(values: FloatArray, most: int) -> tuple[FloatArray, FloatArray]:
    """Thin a curve to about `most` points and keep every extreme value.

    Parameters
    ----------
    values
        (n, n_columns); NaN where there is nothing.
    most
        Number of points that a screen can show.

    Returns
    -------
    indices
        (k,) positions on the first axis, rising, as floats.
    thin
        (k, n_columns): all values where n <= `most`; else of each bin the minimum and the maximum
        of each column, so that a single outlying sample stays visible.
    """
    n = len(values)
    if n <= most:
        return np.arange(n, dtype=np.float64), values
    n_bins = max(1, most // 2)
    edges = np.linspace(0, n, n_bins + 1).astype(int)
    size = int(np.diff(edges).max())
    at = np.minimum(edges[:-1, None] + np.arange(size), edges[1:, None] - 1)
    binned = values[at]  # (n_bins, size, n_columns)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # bins without any value stay NaN
        low, high = np.nanmin(binned, axis=1), np.nanmax(binned, axis=1)
    rising = values[edges[:-1]] <= values[edges[1:] - 1]
    pairs = np.stack([np.where(rising, low, high), np.where(rising, high, low)], axis=1)
    indices = np.repeat(edges[:-1], 2).astype(np.float64)
    indices[1::2] += (np.diff(edges) - 1) / 2
    return indices, pairs.reshape(-1, values.shape[1])


def speed(positions: FloatArray, rate: float) -> FloatArray:
    """Give the speed by central differences.

    Parameters
    ----------
    positions
        (n_frames, ..., n_dims) mm.
    rate
        Hz.

    Returns
    -------
    (n_frames, ...) mm/s; NaN beside gaps.
    """
    if len(positions) < 3:
        return np.full(positions.shape[:-1], np.nan)
    moved = np.full(positions.shape, np.nan)
    moved[1:-1] = (positions[2:] - positions[:-2]) * (rate / 2)
    moved[0], moved[-1] = moved[1], moved[-2]
    return np.asarray(np.linalg.norm(moved, axis=-1))


def speed_map(take: Take, markers: np.ndarray, n_bins: int) -> FloatArray:
    """Give the mean speed of markers in bins of time, for an overview.

    Returns
    -------
    (n_markers, at most n_bins) mm/s; NaN where a marker was not seen.
    """
    n_bins = max(1, min(n_bins, take.n_frames))
    edges = np.linspace(0, take.n_frames, n_bins + 1).astype(int)
    shade = np.full((len(markers), n_bins), np.nan)
    for row, marker in enumerate(markers):
        fast = speed(take.positions[:, marker], take.rate)
        known = np.isfinite(fast)
        total = np.add.reduceat(np.where(known, fast, 0.0), edges[:-1])
        count = np.add.reduceat(known, edges[:-1])
        shade[row] = np.where(count > 0, total / np.maximum(count, 1), np.nan)
    return shade


def shape(
    take: Take, marker: str, span: Span, n_points: int = 48
) -> tuple[FloatArray, float, float]:
    """Give the outline of a finding for a list: the most telling axis around its span.

    The straight line through the samples just outside the span is subtracted, so that a 5 mm peak
    shows on a marker that travels a metre.

    Returns
    -------
    outline
        (k,) values between 0 and 1, NaN in gaps.
    begins, ends
        Where the span begins and ends, as shares of the outline's width.
    """
    wide = span.padded(max(6, len(span) * 4 // 5), take.n_frames)
    own = take.positions[wide.frames, take.index(marker)]
    frames = np.arange(wide.start, wide.stop)
    before, after = max(span.start - 1, wide.start), min(span.stop, wide.stop - 1)
    ends = own[[before - wide.start, after - wide.start]]
    share = (frames - before) / max(1, after - before)
    straight = ends[0] + share[:, None] * (ends[1] - ends[0])
    away = own - np.where(np.isfinite(straight), straight, 0.0)
    seen = np.isfinite(away[:, 0])
    if seen.any():
        axis = int(np.argmax(np.ptp(away[seen], axis=0)))
        line = away[:, axis]
        low, high = line[seen].min(), line[seen].max()
        line = (line - low) / (high - low) if high > low else np.where(seen, 0.5, np.nan)
    else:
        line = np.full(len(wide), np.nan)
    _, thin = thinned(line[:, None], n_points)
    n = max(1, len(wide) - 1)
    return thin[:, 0], (span.start - wide.start) / n, (span.stop - 1 - wide.start) / n


def expected(
    own: FloatArray, neighbours: FloatArray, trusted: BoolArray, weights: FloatArray
) -> FloatArray:
    """Give where a marker would be if it kept its place among its neighbours.

    Parameters
    ----------
    own
        (n_frames, n_dims) mm.
    neighbours
        (n_frames, n_neighbours, n_dims) mm; NaN where not seen.
    trusted
        (n_frames,): where the marker's own positions may be learnt from.
    weights
        (n_neighbours,): how much each neighbour counts, not negative.

    Returns
    -------
    (n_frames, n_dims) mm; NaN where too few neighbours are seen, or nothing can be learnt.
    """
    n_dims = own.shape[1]
    each = np.isfinite(neighbours[:, :, 0])
    usable = trusted & each.all(axis=1) & np.isfinite(own[:, 0])
    if not usable.any():
        return np.full(own.shape, np.nan)
    if neighbours.shape[1] < n_dims:
        middle = neighbours.mean(axis=1)
        return np.asarray(middle + (own - middle)[usable].mean(axis=0))
    model = neighbours[np.flatnonzero(usable)[int(usable.sum()) // 2]]
    frames = kabsch(model, neighbours, weights)
    place = frames.to_local(own)[usable].mean(axis=0)
    there = frames.to_world(np.broadcast_to(place, own.shape))
    return np.where(each.sum(axis=1)[:, None] >= n_dims, there, np.nan)


def acceleration(positions: FloatArray, rate: float) -> FloatArray:
    """Give the size of the second derivative, (n_frames,) m/s²; NaN beside gaps."""
    found = np.full(len(positions), np.nan)
    if len(positions) > 2:
        bends = np.diff(positions, n=2, axis=0) * (rate * rate / 1000)
        found[1:-1] = np.linalg.norm(bends, axis=1)
    return found


def distance_change(own: FloatArray, neighbours: FloatArray, trusted: BoolArray) -> FloatArray:
    """Give how much the distances to neighbours differ from usual, (n_frames,) mm (rms)."""
    distance = np.linalg.norm(neighbours - own[:, None], axis=2)
    known = np.isfinite(distance) & trusted[:, None]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # a frame or neighbour without any value
        usual = np.nanmedian(np.where(known, distance, np.nan), axis=0)
        return np.asarray(np.sqrt(np.nanmean(np.square(distance - usual), axis=1)))


def lengths(positions: FloatArray, one: int, others: tuple[int, ...]) -> FloatArray:
    """Give the distances of one marker to others, (n_frames, n_others) mm."""
    return np.asarray(
        np.linalg.norm(positions[:, list(others)] - positions[:, one][:, None], axis=2)
    )
