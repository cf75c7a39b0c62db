"""The pattern of a donor."""

from typing import Annotated

import numpy as np

from markermend.errors import CannotRepair
from markermend.params import Within
from markermend.registry import method
from markermend.repairing.problem import Outcome, Problem
from markermend.repairing.window import window


@method(
    title="Pattern of a donor",
    kinds=("gap", "noise", "step", "slow", "peak"),
    source="relational or pattern fill, as in the programs of camera makers",
)
def pattern(
    problem: Problem,
    *,
    donor: Annotated[int, Within(1, 50)] = 1,
    context: Annotated[int, Within(10, 3000, "frames")] = 300,
) -> Outcome:
    """Move as another marker moves, from the edge before to the edge after.

    Parameters
    ----------
    donor
        Which one: 1 is the marker that has moved most nearly parallel, 2 the next; the last one
        where there are fewer.
    context
        Frames around the span in which the donor is looked for.

    Returns
    -------
    (len(span), n_dims) mm, with a note that names the donor.

    Raises
    ------
    CannotRepair
        If the marker is not seen near the span, or no other one throughout it.
    """
    cut = window(problem, context)
    anchors = [edge for edge in cut.edges if edge is not None]
    others = cut.others[cut.seen[anchors][:, cut.others].all(axis=0)]
    if not len(others):
        raise CannotRepair(
            f"No other marker is seen from edge to edge of the gap of {cut.label}; choose a method "
            "that needs none, such as pchip."
        )
    offset = cut.positions[:, others] - cut.own[:, None]
    with_both = np.isfinite(offset[:, :, :1])
    count = with_both.sum(axis=0)
    mean = np.where(with_both, offset, 0.0).sum(axis=0) / count
    wander = np.square(np.where(with_both, offset - mean, 0.0)).sum(axis=(0, 2)) / count[:, 0]
    ranked = others[np.argsort(wander, kind="stable")]
    chosen = int(ranked[min(donor, len(ranked)) - 1])
    values = cut.meeting(cut.positions[:, chosen])
    return Outcome(values, note=f"The donor is {cut.labels[chosen]}.")
