"""Contamination of takes with known artefacts, and what detectors make of them."""

from markermend.evaluate.contamination import Truth, contaminate

__all__ = ["Truth", "contaminate"]
