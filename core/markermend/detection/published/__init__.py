"""The stages of the published detector (Skurowski & Pawlyta, sections 3.4 and 3.5)."""

from markermend.detection.published.pipeline import run
from markermend.detection.published.settings import Settings

__all__ = ["Settings", "run"]
