"""Carried along by its cluster."""

from typing import Annotated

import numpy as np

from markermend.errors import CannotRepair
from markermend.model import FloatArray
from markermend.params import Within
from markermend.registry import method
from markermend.repairing.geometry import closeness, defines_frame, kabsch
from markermend.repairing.neighbourhood import Neighbourhood, neighbourhood
from markermend.repairing.problem import Problem
from markermend.repairing.window import window


@method(
    title="Kinematic, by clusters",
    kinds=("gap", "noise", "step", "slow"),
    source="segments as clusters of the functional body mesh, Skurowski and Pawlyta, section "
    "3.3.2; kinematic fill as in the programs of camera makers",
)
def kinematic(
    problem: Problem, *, stiffness: Annotated[float, Within(0.1, 50, "mm")] = 2.0
) -> FloatArray:
    """Keep the marker's mean place in its segment, found as a cluster of the functional body mesh.

    Where the cluster alone fixes no frame, the markers most rigidly tied to it join in. What is
    left at the edges is taken away linearly.

    Parameters
    ----------
    stiffness
        Variation of a distance below which a marker gets no more weight.

    Returns
    -------
    (len(span), n_dims) mm.

    Raises
    ------
    CannotRepair
        If too few neighbours are seen throughout, or they stand in one line.
    """
    cut = window(problem)
    near = neighbourhood(cut)
    first = cut.span.start if cut.edges[0] is None else cut.edges[0]
    segment = _segment(near, first)
    if segment is None:
        raise CannotRepair(
            f"The markers around {cut.label} stand in one line or are too few to make a segment; "
            "choose a method that needs none, such as pchip."
        )
    members = near.positions[:, segment]
    weights = closeness(near.body.spread[0, segment], stiffness)
    frames = kabsch(members[first], members, weights)
    place = frames.to_local(near.positions[:, 0])[near.trusted].mean(axis=0)
    return cut.meeting(frames.to_world(np.tile(place, (cut.n_frames, 1))))


def _segment(near: Neighbourhood, frame: int) -> list[int] | None:
    """Give the marker's cluster, and as many of the next ones as make it fix a frame."""
    if not near.trusted.any():
        return None
    segment = list(near.body.siblings(0))
    spare = [m for m in near.body.neighbours(0) if m not in segment]
    while not (segment and defines_frame(near.positions[frame, segment])):
        if not spare:
            return None
        segment.append(spare.pop(0))
    return segment
