"""Carried along by the markers that move as one body with it."""

from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from markermend.errors import CannotRepair
from markermend.model import FloatArray
from markermend.params import Within
from markermend.registry import method
from markermend.repairing.geometry import (
    LocalFrames,
    closeness,
    defines_frame,
    distance_spread,
    kabsch,
    mean_shape,
)
from markermend.repairing.problem import Problem
from markermend.repairing.window import Window, window


@method(
    title="Rigid body",
    kinds=("gap", "noise", "step", "slow", "peak"),
    source="S. J. Howarth and J. P. Callaghan, Comput. Methods Biomech. Biomed. Eng. 13:847, 2010",
)
def rigid(problem: Problem, *, markers: Annotated[int, Within(2, 12)] = 4) -> FloatArray:
    """Keep the marker's place among the neighbours whose distance to it changes least.

    The neighbours' weighted best rotation and translation (`kabsch`) make a frame of reference;
    the marker's coordinates in it go straight from those before the span to those after it, and
    stay as they are where only one side is seen.

    Parameters
    ----------
    markers
        Neighbours that make the frame; at least 3, in two dimensions 2.

    Returns
    -------
    (len(span), n_dims) mm.

    Raises
    ------
    CannotRepair
        If too few neighbours are seen throughout the span and at its edges, or stand in one line.
    """
    cut = window(problem)
    anchors = np.array([edge for edge in cut.edges if edge is not None])
    frames = np.concatenate([anchors, np.arange(cut.span.start, cut.span.stop)])
    found = moving_frame(cut, anchors, frames, max(markers, cut.n_dims))
    place = found.at(slice(len(anchors))).to_local(cut.own[anchors])
    times = frames[len(anchors) :]
    steady = np.column_stack([np.interp(times, anchors, axis) for axis in place.T])
    return found.at(slice(len(anchors), None)).to_world(steady)


def moving_frame(
    cut: Window, anchors: NDArray[np.intp], frames: NDArray[np.intp], markers: int
) -> LocalFrames:
    """Fit the frame of the nearest neighbours in the sense of rigidity.

    Parameters
    ----------
    anchors
        Frames, counted in the window, whose mean posture is the frame's shape.
    frames
        Frames for which it is wanted; the neighbours are seen in all of them.
    markers
        Neighbours wanted; more are taken while they stand in one line.

    Raises
    ------
    CannotRepair
        If too few are seen, or all stand in one line.
    """
    others = cut.others[cut.seen[frames][:, cut.others].all(axis=0)]
    spread, _ = distance_spread(cut.own, cut.positions[:, others])
    others, spread = others[np.isfinite(spread)], spread[np.isfinite(spread)]
    if len(others) < cut.n_dims:
        raise CannotRepair(
            f"Other markers seen throughout the span and at its edges: {len(others)}, and a "
            f"rigid body needs {cut.n_dims}; choose a method that needs none, such as pchip."
        )
    order = np.argsort(spread, kind="stable")
    for count in range(min(markers, len(order)), len(order) + 1):
        best = order[:count]
        weights = closeness(spread[best])
        shape = mean_shape(cut.positions[np.ix_(anchors, others[best])], weights)
        if defines_frame(shape):
            return kabsch(shape, cut.positions[np.ix_(frames, others[best])], weights)
    raise CannotRepair(
        f"The markers seen around {cut.label} stand in one line and fix no rigid body; choose a "
        "method that needs none, such as pchip."
    )
