"""Takes of a simulated person: for the demonstration, for experiments and for tests."""

from markermend.simulate.artefacts import distort
from markermend.simulate.demonstration import (
    DEMO_FILES,
    DEMO_SEED,
    demonstration,
    make_demo,
    read_truth,
)
from markermend.simulate.scenarios import SCENARIOS
from markermend.simulate.take import perform, simulate
from markermend.truth import Truth

__all__ = [
    "DEMO_FILES",
    "DEMO_SEED",
    "SCENARIOS",
    "Truth",
    "demonstration",
    "distort",
    "make_demo",
    "perform",
    "read_truth",
    "simulate",
]
