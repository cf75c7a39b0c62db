"""Feed-forward network predictor from parent and siblings."""

from typing import Annotated

import numpy as np

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
    title="Neural network predictor (FFNN)",
    kinds=("gap", "noise", "step", "slow"),
    source="P. Skurowski and M. Pawlyta, section 3.3.3, Eq. 10 and 11",
)
def ffnn(
    problem: Problem,
    *,
    average: Annotated[int, Within(10, 2000, "frames")] = 200,
    replicas: Annotated[int, Within(1, 10)] = 5,
    epochs: Annotated[int, Within(1, 500)] = 50,
    seed: Annotated[int, Within(0, 1_000_000)] = 0,
) -> FloatArray:
    """Predict the marker by a network from its parent and siblings and its own moving average.

    Unlike in the paper, coordinates are counted from the mean of the neighbours, so that walking
    on does not lead out of what was learnt, and the prediction is shifted to meet the seen frames
    on both sides.

    Parameters
    ----------
    average
        Frames of the moving average of the marker itself.
    replicas
        Times that the output is repeated and averaged.
    epochs
        Steps of training.
    seed
        Of the weights that training starts from.

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
    predicted = predict.ffnn(
        near.positions - middle[:, None],
        near.trusted[:, None].repeat(len(near.markers), axis=1),
        near.body,
        [0],
        window=average,
        replicas=replicas,
        epochs=epochs,
        seed=seed,
    )[:, 0]
    if not np.isfinite(predicted).all():
        raise CannotRepair(
            f"{cut.label} is seen together with its neighbours in {near.trusted.sum()} frames, too "
            "few to learn from; choose a method that does not learn, such as rigid."
        )
    return cut.meeting(predicted + middle)
