"""Detectors: one a file in ``methods``, and the functions that run them."""

from markermend.detection.likelihood.reach import Reach, smallest_slow_changes
from markermend.detection.run import DEFAULT, DETECTORS, detect, gaps, overlapping, scan

__all__ = [
    "DEFAULT",
    "DETECTORS",
    "Reach",
    "detect",
    "gaps",
    "overlapping",
    "scan",
    "smallest_slow_changes",
]
