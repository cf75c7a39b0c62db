"""Leave it as it is."""

import numpy as np

from markermend.model import KINDS, FloatArray
from markermend.registry import method
from markermend.repairing.problem import Problem


@method(title="Leave as it is", kinds=KINDS, source="an operator's decision like any other")
def leave(problem: Problem) -> FloatArray:
    """Change nothing: a gap stays a gap, an artefact stays as recorded.

    Returns
    -------
    (len(span), n_dims), all NaN, of which nothing is written.
    """
    return np.full((len(problem.span), problem.n_dims), np.nan)
