"""Whether values that somebody proposes for a span go on from what is seen around it."""

import numpy as np

from markermend.model import FloatArray, Span


def jumps(own: FloatArray, proposed: FloatArray, span: Span) -> tuple[float, float]:
    """Measure how far proposed values miss the straight continuation at both ends.

    Parameters
    ----------
    own
        (n_frames, n_dims) mm: the trajectory, trusted outside the span.
    proposed
        (len(span), n_dims) mm.

    Returns
    -------
    Distances in mm at the start and at the stop, infinite where nothing is seen next to the span.
    """
    before = own[max(0, span.start - 2) : span.start][::-1]
    after = own[span.stop : span.stop + 2]
    return _jump(before, proposed[:2]), _jump(after, proposed[::-1][:2])


def _jump(outside: FloatArray, inside: FloatArray) -> float:
    """Compare the means of extrapolations from both sides of an edge; nearest frames first."""
    known = np.isfinite(outside[:, 0])
    if not (len(known) and known[0]) or not np.isfinite(inside[0, 0]):
        return float("inf")
    slopes = []
    if len(known) > 1 and known[1]:
        slopes.append(outside[0] - outside[1])
    if len(inside) > 1 and np.isfinite(inside[1, 0]):
        slopes.append(inside[1] - inside[0])
    slope = np.mean(slopes, axis=0) if slopes else 0.0
    return float(np.linalg.norm(inside[0] - outside[0] - slope))
