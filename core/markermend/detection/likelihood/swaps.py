"""Swaps: two markers that exchange their places from one frame to the next.

No model of the body takes part. At the frame of an exchange each path, continued straight on, meets
the other marker better than its own.
"""

from dataclasses import dataclass

import numpy as np

from markermend.model import BoolArray, FloatArray

LEAST_MM = 15.0  # how far both markers must jump
_RATIO = 0.4  # both together must be nearer by this factor when exchanged
_BACK = 3  # frames that a path is continued from


@dataclass(frozen=True)
class Swap:
    """Markers `first` and `second` are exchanged in frames [start, stop).

    ``strength`` is how many times clearer the exchange is than it has to be.
    """

    first: int
    second: int
    start: int
    stop: int
    strength: float


def exchanges(positions: FloatArray, seen: BoolArray) -> list[tuple[int, int, int, float]]:
    """All (frame, first, second, strength) at which two markers change places, in time order.

    Parameters
    ----------
    positions
        (n_frames, n_markers, 3) mm, without NaN.
    seen
        (n_frames, n_markers).
    """
    n, n_markers, _ = positions.shape
    if n < 2 * _BACK or n_markers < 2:
        return []
    ahead = np.full_like(positions, np.nan)
    # A straight line through the last three frames, continued by one.
    ahead[3:] = (4 * positions[2:-1] + positions[1:-2] - 2 * positions[:-3]) / 3
    behind = np.full_like(positions, np.nan)
    behind[:-3] = (4 * positions[1:-2] + positions[2:-1] - 2 * positions[3:]) / 3
    miss = np.sqrt(((positions - ahead) ** 2).sum(2))
    known = seen.copy()
    for shift in (1, 2, 3):
        known[shift:] &= seen[:-shift]
    hot = known & (miss > LEAST_MM)
    found: list[tuple[int, int, int, float]] = []
    for t in np.flatnonzero(hot.sum(1) >= 2).tolist():
        markers = np.flatnonzero(hot[t]).tolist()
        best: list[tuple[float, int, int]] = []
        for i, a in enumerate(markers):
            for b in markers[i + 1 :]:
                kept = miss[t, a] + miss[t, b]
                swapped = _gap(positions[t, b], ahead[t, a]) + _gap(positions[t, a], ahead[t, b])
                if t >= 1 and np.isfinite(behind[t - 1, [a, b]]).all():
                    # The same seen backwards, so that an impact or a peak does not pass.
                    kept = min(
                        kept,
                        _gap(positions[t - 1, a], behind[t - 1, a])
                        + _gap(positions[t - 1, b], behind[t - 1, b]),
                    )
                    swapped = max(
                        swapped,
                        _gap(positions[t - 1, b], behind[t - 1, a])
                        + _gap(positions[t - 1, a], behind[t - 1, b]),
                    )
                if swapped < _RATIO * kept:
                    best.append((_RATIO * kept / max(swapped, 1e-3), a, b))
        used: set[int] = set()
        for strength, a, b in sorted(best, reverse=True):
            if a not in used and b not in used:
                used |= {a, b}
                found.append((t, a, b, strength))
    return found


def find_swaps(positions: FloatArray, seen: BoolArray) -> list[Swap]:
    """Pair exchanges of the same two markers; one without a return lasts to the nearer end."""
    n = len(positions)
    open_since: dict[tuple[int, int], tuple[int, float]] = {}
    swaps = []
    for t, a, b, strength in exchanges(positions, seen):
        if (a, b) in open_since:
            start, first = open_since.pop((a, b))
            swaps.append(Swap(a, b, start, t, min(first, strength)))
        else:
            open_since[(a, b)] = (t, strength)
    for (a, b), (t, strength) in open_since.items():
        start, stop = (t, n) if n - t <= t else (0, t)
        swaps.append(Swap(a, b, start, stop, strength))
    return sorted(swaps, key=lambda s: (s.start, s.first, s.second))


def undone(positions: FloatArray, swaps: list[Swap]) -> FloatArray:
    """Positions with the exchanges taken back."""
    out = positions.copy()
    for s in swaps:
        part = slice(s.start, s.stop)
        out[part, [s.first, s.second]] = out[part, [s.second, s.first]]
    return out


def _gap(a: FloatArray, b: FloatArray) -> float:
    return float(np.sqrt(((a - b) ** 2).sum()))
