"""Leave it as a gap."""

import numpy as np

from markermend.model import KINDS, FloatArray
from markermend.registry import method
from markermend.repairing.problem import Problem


@method(title="Leave as a gap", kinds=KINDS, source="an operator's decision like any other")
def leave(problem: Problem) -> FloatArray:
    """Invent nothing: a gap stays one, and an artefact becomes one.

    Returns
    -------
    (len(span), n_dims), all NaN.
    """
    return np.full((len(problem.span), problem.n_dims), np.nan)
