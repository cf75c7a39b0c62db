"""The few markers around one, as a small take with a functional body mesh of its own."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from markermend.body import Body, infer
from markermend.errors import CannotRepair
from markermend.model import BoolArray, FloatArray, Take
from markermend.repairing.geometry import distance_spread
from markermend.repairing.remembering import remembered
from markermend.repairing.window import Window

COUNT = 10
"""Neighbours looked at: about as many as a segment and the next one hold."""


@dataclass(frozen=True, eq=False)
class Neighbourhood:
    """A marker, first of all, and the neighbours most rigidly tied to it, in that order.

    Attributes
    ----------
    markers
        Their indices in the window.
    positions
        (n_frames, 1 + n_neighbours, n_dims) mm without NaN: where something is not seen, a
        straight line stands in.
    trusted
        (n_frames,): where nothing stands in.
    body
        The mesh of these markers; the marker itself is number 0.
    """

    markers: NDArray[np.intp]
    positions: FloatArray
    trusted: BoolArray
    body: Body


@remembered
def neighbourhood(cut: Window) -> Neighbourhood:
    """Gather the neighbours that are seen from edge to edge of the gap.

    Raises
    ------
    CannotRepair
        If there are none.
    """
    before, after = cut.edges
    start = cut.span.start if before is None else before
    stop = cut.span.stop if after is None else after + 1
    others = cut.others[cut.seen[start:stop][:, cut.others].all(axis=0)]
    spread, _ = distance_spread(cut.own, cut.positions[:, others])
    others = others[np.argsort(spread, kind="stable")][: min(COUNT, int(np.isfinite(spread).sum()))]
    if not len(others):
        raise CannotRepair(
            f"No other marker is seen from edge to edge of the gap of {cut.label}; choose a method "
            "that needs none, such as pchip."
        )
    markers = np.concatenate([[cut.marker], others])
    near = cut.positions[:, markers]
    seen = cut.seen[:, markers]
    # The mesh knows labels with a subject; these markers are taken to be of one.
    small = Take(
        near,
        cut.rate,
        [f"M{i}" for i in range(len(markers))],
        units="mm" if cut.n_dims == 3 else "px",
    )
    trusted: BoolArray = np.asarray(seen.all(axis=1))
    return Neighbourhood(markers, _bridged(near, seen), trusted, infer(small))


def _bridged(positions: FloatArray, seen: BoolArray) -> FloatArray:
    filled = positions.copy()
    time = np.arange(len(positions))
    for marker in np.flatnonzero(~seen.all(axis=0)):
        known = seen[:, marker]
        for axis in range(positions.shape[2]):
            filled[~known, marker, axis] = np.interp(
                time[~known], time[known], positions[known, marker, axis]
            )
    return filled
