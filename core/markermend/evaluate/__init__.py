"""Contamination of takes with known artefacts, and what detectors make of them."""

import importlib
from typing import TYPE_CHECKING, Any

from markermend.evaluate.contamination import contaminate
from markermend.truth import Truth

# The experiments start processes and learn regressors: imported when first used.
_HOME = {"e1": "classification", "e2": "operators", "predictors": "prediction"}

__all__ = ["Truth", "contaminate", "e1", "e2", "predictors"]

if TYPE_CHECKING:
    from markermend.evaluate.classification import e1
    from markermend.evaluate.operators import e2
    from markermend.evaluate.prediction import predictors


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'markermend.evaluate' has no attribute {name!r}")
    return getattr(importlib.import_module(f"markermend.evaluate.{_HOME[name]}"), name)
