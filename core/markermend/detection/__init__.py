"""Detectors: one a file in ``methods``, and the functions that run them."""

from markermend.detection.run import DEFAULT, DETECTORS, detect, gaps, overlapping, scan

__all__ = ["DEFAULT", "DETECTORS", "detect", "gaps", "overlapping", "scan"]
