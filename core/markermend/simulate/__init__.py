"""Takes of a simulated person: for the demonstration, for experiments and for tests."""

from markermend.simulate.scenarios import SCENARIOS
from markermend.simulate.take import perform, simulate

__all__ = ["SCENARIOS", "perform", "simulate"]
