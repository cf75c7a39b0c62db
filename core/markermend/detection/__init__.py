"""Detectors: one a file in ``methods``, and the functions that run them."""

from typing import TYPE_CHECKING, Any

from markermend.detection.run import DEFAULT, DETECTORS, detect, gaps, overlapping, scan

if TYPE_CHECKING:
    from markermend.detection.likelihood.reach import Reach, smallest_slow_changes

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


def __getattr__(name: str) -> Any:
    # A detector costs a second to import, which is paid by those who use one.
    if name not in ("Reach", "smallest_slow_changes"):
        raise AttributeError(f"module 'markermend.detection' has no attribute {name!r}")
    from markermend.detection.likelihood import reach

    return getattr(reach, name)
