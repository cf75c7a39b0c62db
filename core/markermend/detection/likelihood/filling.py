"""A dense working copy: what is missing or flagged is replaced from the neighbours' prediction."""

import numpy as np

from markermend.model import BoolArray, FloatArray, runs

_END = 3  # frames whose median is the level at an end of a bulky stretch


def interpolated(positions: FloatArray, seen: BoolArray) -> FloatArray:
    """Fill gaps linearly in time, ends held: (n_frames, n_markers, 3)."""
    dense = positions.copy()
    frames = np.arange(len(positions))
    for m in np.flatnonzero(~seen.all(0)):
        known = np.flatnonzero(seen[:, m])
        for axis in range(positions.shape[2]):
            dense[:, m, axis] = np.interp(frames, known, positions[known, m, axis])
    return dense


def bridged(residual: FloatArray, flagged: BoolArray) -> FloatArray:
    """Residual with its flagged frames replaced by a line from side to side.

    Parameters
    ----------
    residual
        (n_frames, 3) mm.
    flagged
        (n_frames,).
    """
    if not flagged.any() or flagged.all():
        return residual
    out = residual.copy()
    n = len(out)
    good = ~flagged
    for span in runs(flagged):
        end = 1 if len(span) <= _END else _END
        before = np.flatnonzero(good[: span.start])[-end:]
        after = np.flatnonzero(good[span.stop :])[:end] + span.stop
        left = np.median(residual[before if len(before) else after], axis=0)
        right = np.median(residual[after if len(after) else before], axis=0)
        share = (np.arange(span.start, min(span.stop, n)) - span.start + 1) / (len(span) + 1)
        out[span.frames] = left + (right - left) * share[:, None]
    return out
