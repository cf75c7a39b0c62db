"""Polynomial predictor from parent and siblings."""

from typing import Annotated

from markermend import predict
from markermend.errors import CannotRepair
from markermend.model import FloatArray
from markermend.params import Within
from markermend.registry import method
from markermend.repairing.neighbourhood import neighbourhood
from markermend.repairing.problem import Problem
from markermend.repairing.window import window

CONTEXT = 1500
"""Frames around the span that suffice to learn from."""


@method(
    title="Polynomial predictor",
    kinds=("gap", "noise", "step", "slow"),
    source="P. Skurowski and M. Pawlyta, section 3.3.2, Eq. 3 and 9",
)
def polynomial(
    problem: Problem,
    *,
    order: Annotated[int, Within(1, 5)] = 4,
    context: Annotated[int, Within(0, 6, "frames")] = 3,
    siblings: Annotated[int, Within(1, 8)] = 6,
) -> FloatArray:
    """Predict the marker from powers of its parent's and siblings' coordinates, now and before.

    Unlike in the paper, coordinates are counted from the mean of the neighbours, so that walking
    on does not lead out of what was learnt, and the prediction is shifted to meet the seen frames
    on both sides.

    Parameters
    ----------
    order
        Highest power.
    context
        Past frames that are looked at.
    siblings
        Most markers of the same segment that are looked at.

    Returns
    -------
    (len(span), n_dims) mm.

    Raises
    ------
    CannotRepair
        If there are no neighbours, or too few frames to learn from.
    """
    cut = window(problem, CONTEXT)
    near = neighbourhood(cut)
    middle = near.positions[:, 1:].mean(axis=1)
    predicted = predict.polynomial(
        near.positions - middle[:, None],
        near.trusted,
        near.body,
        0,
        order=order,
        context=context,
        n_siblings=siblings,
    )
    if predicted is None:
        raise CannotRepair(
            f"{cut.label} is seen together with its neighbours in {near.trusted.sum()} frames, too "
            "few to learn from; choose a method that does not learn, such as rigid."
        )
    return cut.meeting(predicted + middle)
