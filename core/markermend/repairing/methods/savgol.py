"""Savitzky-Golay: a polynomial of high order in a moving window."""

from typing import Annotated

import numpy as np
from numpy.polynomial.legendre import legvander
from numpy.typing import NDArray

from markermend.errors import CannotRepair
from markermend.model import FloatArray
from markermend.params import Within
from markermend.registry import method
from markermend.repairing.problem import Problem
from markermend.repairing.window import both_sides


@method(
    title="Savitzky-Golay",
    kinds=("noise", "peak", "gap"),
    source="P. Skurowski and M. Pawlyta, experiment E3, Eq. 6; Savitzky and Golay, 1964",
)
def savgol(
    problem: Problem,
    *,
    order: Annotated[int, Within(0, 20)] = 13,
    window: Annotated[int, Within(21, 501, "frames")] = 101,
) -> FloatArray:
    """Smooth what was recorded in the span; in a gap, go on with the polynomial of its edges.

    Parameters
    ----------
    order
        Degree of the polynomial.
    window
        Frames that one polynomial is fitted to: around each frame where something was recorded, or
        half of them on each side of a gap.

    Returns
    -------
    (len(span), n_dims) mm.

    Raises
    ------
    CannotRepair
        If the gap is longer than half a window, or too few frames are seen around the span.

    Notes
    -----
    Solved by QR in the Legendre basis: the powers of the frame number that Eq. 6 writes down lose
    all accuracy at order 13.
    """
    inside = problem.recorded[problem.span.frames]
    if problem.kind == "gap" or not np.isfinite(inside).all():
        return _bridge(problem, order, window)
    return _smooth(problem, inside, order, window)


def _bridge(problem: Problem, order: int, window: int) -> FloatArray:
    if len(problem.span) > window // 2:
        raise CannotRepair(
            f"Nothing is recorded in {len(problem.span)} frames, more than half the window of "
            f"{window}; widen the window or choose a method that uses the neighbours."
        )
    knots = both_sides(problem, window // 2)
    if len(knots) <= order:
        raise CannotRepair(
            f"Only {len(knots)} frames are seen around the span; choose an order below that."
        )
    frames = np.arange(problem.span.start, problem.span.stop)
    return _hat(knots, frames, order) @ problem.own[knots]


def _smooth(problem: Problem, inside: FloatArray, order: int, window: int) -> FloatArray:
    half, span = window // 2, problem.span
    around = span.padded(half, problem.n_frames)
    values = problem.own[around.frames].copy()
    values[span.start - around.start : span.stop - around.start] = inside
    known = np.isfinite(values[:, 0])
    hats: dict[bytes, FloatArray] = {}
    smooth = np.empty_like(inside)
    for i, frame in enumerate(range(span.start - around.start, span.stop - around.start)):
        start = max(0, frame - half)
        near = start + np.flatnonzero(known[start : frame + half + 1])
        if len(near) <= order:
            raise CannotRepair(
                f"Only {len(near)} frames are seen within the window; choose an order below that."
            )
        pattern = (near - frame).tobytes()
        if pattern not in hats:
            hats[pattern] = _hat(near, np.array([frame]), order)
        smooth[i] = (hats[pattern] @ values[near])[0]
    return smooth


def _hat(knots: NDArray[np.intp], frames: NDArray[np.intp], order: int) -> FloatArray:
    """Give the matrix from values at the knots to the fitted polynomial's at the frames."""
    low = min(knots[0], frames[0])
    scale = 2.0 / (max(knots[-1], frames[-1]) - low)
    q, r = np.linalg.qr(legvander((knots - low) * scale - 1.0, order))
    basis = legvander((frames - low) * scale - 1.0, order)
    return np.asarray(np.linalg.solve(r.T, basis.T).T @ q.T)
