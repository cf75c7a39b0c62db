"""Try all that SHORT could do on other gaps of the same length in the same short window.

Where so little is seen that no stretch of the gap's length can be hidden on the marker itself,
stretches are hidden on other markers, a few at a time.  All ways to fill them are tried; how they
err there says how to weigh them, what error to expect, and how wide the band must be.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from markermend.model import FloatArray, Span
from markermend.repairing.blend.blend import hardness, mixed
from markermend.repairing.blend.mixing import simplex_weights
from markermend.repairing.blend.ways import LEARNT, ways
from markermend.repairing.shortwindow import fill_at_once
from markermend.repairing.window import Window

SEED = 5
ROUNDS, AT_ONCE = 3, 4
"""Times that the window is filled, and markers that are hidden each time."""
LEAST, LEAST_FRAMES = 6, 2
"""Stretches without which nothing is told, and frames seen on each side of one."""
MOST_FRAMES = 300
"""Longer windows take too long to fill again and again, and show enough to test the marker."""
PRIOR = 3.0
"""Stretches that the usual weights count as."""
DOUBTFUL = 2.0
"""A way that is off the others by so many times its usual distance counts half or less."""
SHARE = 0.9
WIDER = 1.18
"""How much wider the band is made, set on other recordings than are reported."""


@dataclass(frozen=True, eq=False)
class Rehearsed:
    """A fill by several ways, and its errors on other gaps.

    Attributes
    ----------
    values
        (length, n_dims) mm.
    likely
        (n_stretches, length) mm: errors there, as they would be if all were as hard as the gap.
    """

    values: FloatArray
    likely: FloatArray

    @property
    def expected_mm(self) -> float:
        """Mean error to be expected."""
        return float(self.likely.mean())

    def band(self) -> FloatArray:
        """Give the 90 % band by position in the gap, (length,) mm."""
        shape = np.sqrt(np.square(self.likely).mean(axis=0))
        level = np.quantile(self.likely / (shape + 1e-9), SHARE) * WIDER
        return np.asarray(level * shape)


@dataclass(frozen=True, eq=False)
class _Trials:
    """(n_ways, n_stretches, length, n_dims) mm: the errors of every way."""

    errors: FloatArray


def rehearsed(near: Window, made: FloatArray, usual: FloatArray) -> Rehearsed | None:
    """Weigh the ways to fill a gap by how they fill others.

    Parameters
    ----------
    near
        The window.
    made
        (n_ways, length, n_dims) mm: how each way fills the gap.
    usual
        (n_ways,): weights that are known to be good.

    Returns
    -------
    The fill with its errors, or None where too few stretches of the length can be hidden.
    """
    if near.n_frames > MOST_FRAMES:
        return None
    tried = _rehearse(
        np.ascontiguousarray(near.positions).tobytes(),
        near.positions.shape,
        near.rate,
        near.labels,
        len(near.span),
    )
    if tried is None:
        return None
    errors = tried.errors
    weights = _weights(errors, usual)
    off = np.stack([_apart(one) for one in errors.swapaxes(0, 1)])
    typical = np.median(off, axis=0) + 1e-9
    values, here = mixed(_gated(weights, _apart(made) / typical), made)
    each = [
        mixed(_gated(weights, apart / typical), one)
        for apart, one in zip(off, errors.swapaxes(0, 1), strict=True)
    ]
    there = np.array([spread.mean() for _, spread in each])
    likely = np.array([np.linalg.norm(one, axis=1) for one, _ in each])
    return Rehearsed(values, likely * hardness(float(here.mean()), there)[:, None])


def _weights(errors: FloatArray, usual: FloatArray) -> FloatArray:
    """Choose weights whose errors cancel, and draw them to the usual ones."""
    size = np.sqrt(np.square(errors).mean(axis=(2, 3)))
    scale = np.sqrt(np.sqrt(size.min(axis=0) * np.median(size, axis=0)) + 1e-9)
    scaled = (errors / scale[:, None, None]).reshape(len(errors), -1)
    covariance = scaled @ scaled.T / scaled.shape[1]
    share = errors.shape[1] / (errors.shape[1] + PRIOR)
    return np.asarray(share * simplex_weights(covariance) + (1 - share) * usual)


def _apart(made: FloatArray) -> FloatArray:
    """Give how far each way is off those that learn, in the median, (n_ways,) mm."""
    away = np.linalg.norm(made[:, None] - made[:LEARNT], axis=3).mean(axis=2)
    return np.asarray(np.median(away, axis=1))


def _gated(weights: FloatArray, apart: FloatArray) -> FloatArray:
    """Take weight off the ways that are farther off than usual, beyond what all of them are."""
    odd = apart / max(float(np.median(apart)), 1e-9)
    gated = weights / (1 + (odd / DOUBTFUL) ** 4)
    return np.asarray(gated / gated.sum())


@lru_cache(maxsize=64)
def _rehearse(
    content: bytes, shape: tuple[int, int, int], rate: float, labels: tuple[str, ...], length: int
) -> _Trials | None:
    """Hide stretches of this length in the window, and fill them; remembered for its other gaps."""
    positions = np.frombuffer(content).reshape(shape)
    errors = []
    for places in _places(np.isfinite(positions[:, :, 0]), length):
        hidden = positions.copy()
        for marker, start in places:
            hidden[start : start + length, marker] = np.nan
        filled = fill_at_once(hidden, rate)
        for marker, start in places:
            near = Window(hidden, marker, Span(start, start + length), 0, rate, labels)
            errors.append(ways(near, filled) - positions[near.span.frames, marker])
    return _Trials(np.stack(errors, axis=1)) if len(errors) >= LEAST else None


def _places(seen: NDArray[np.bool_], length: int) -> list[list[tuple[int, int]]]:
    """Draw the markers and first frames of the stretches, in rounds; no marker comes twice."""
    rng = np.random.default_rng(SEED)
    passed = np.concatenate([np.zeros((1, seen.shape[1]), int), np.cumsum(seen, axis=0)])
    rounds: list[list[tuple[int, int]]] = [[]]
    for marker in rng.permutation(seen.shape[1]):
        count = passed[:, marker]
        whole = count[length:] - count[:-length] == length
        before, after = count[:-length], count[-1] - count[length:]
        starts = np.flatnonzero(whole & (before >= LEAST_FRAMES) & (after >= LEAST_FRAMES))
        if not len(starts):
            continue
        if len(rounds[-1]) == AT_ONCE:
            if len(rounds) == ROUNDS:
                break
            rounds.append([])
        rounds[-1].append((int(marker), int(rng.choice(starts))))
    return [one for one in rounds if one]
