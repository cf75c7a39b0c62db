"""Repairs: one method a file in ``methods``, and the functions that run them.

The laws: a method is a function of a `Problem` and cannot touch what it was not given; repairs
commute, since each is computed from the take as recorded with all spans to be repaired masked;
only `apply` writes positions.
"""

from markermend.repairing.problem import Outcome, Problem, Repair
from markermend.repairing.run import (
    DEFAULTS,
    REPAIRS,
    Refusal,
    Wish,
    apply,
    fill,
    repair,
    repair_all,
)

__all__ = [
    "DEFAULTS",
    "REPAIRS",
    "Outcome",
    "Problem",
    "Refusal",
    "Repair",
    "Wish",
    "apply",
    "fill",
    "repair",
    "repair_all",
]
