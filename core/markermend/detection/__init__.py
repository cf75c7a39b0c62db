"""Detectors: one a file in ``methods``, and the function that runs them."""

from markermend.detection.run import DETECTORS, detect, gaps, scan

__all__ = ["DETECTORS", "detect", "gaps", "scan"]
