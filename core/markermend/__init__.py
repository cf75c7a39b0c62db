"""MarkerMend: find, judge and repair artefacts in marker trajectories.

The library in one breath::

    import markermend as mm

    take = mm.read("walk.c3d")
    for finding in mm.detect(take):
        print(finding.marker, finding.span, finding.kind, finding.score)
    mm.write(mm.fill(take), "walk-filled.c3d")
"""

import importlib
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

# Public names and where they live; imported when first used, so that the command line starts fast.
_HOME = {
    "AXES": "model",
    "Decision": "review",
    "Event": "model",
    "Evidence": "model",
    "Finding": "model",
    "KINDS": "model",
    "MarkerMendError": "errors",
    "Repair": "repairing",
    "Review": "review",
    "Source": "model",
    "Span": "model",
    "Take": "model",
    "agreement": "comparing",
    "contaminate": "evaluate",
    "detect": "detection",
    "fill": "repairing",
    "read": "io",
    "repair": "repairing",
    "write": "io",
}
__all__ = sorted(_HOME)

if TYPE_CHECKING:
    from markermend.comparing import agreement
    from markermend.detection import detect
    from markermend.errors import MarkerMendError
    from markermend.evaluate import contaminate
    from markermend.io import read, write
    from markermend.model import AXES, KINDS, Event, Evidence, Finding, Source, Span, Take
    from markermend.repairing import Repair, fill, repair
    from markermend.review import Decision, Review


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'markermend' has no attribute {name!r}")
    value = getattr(importlib.import_module(f"markermend.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
