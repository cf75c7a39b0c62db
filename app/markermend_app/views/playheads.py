"""The playheads of all figures: they follow the 3D view in the browser, without Python.

No callback of Bokeh's own is used for it: those are compiled from text in the browser, which the
page's content policy forbids.
"""

from pathlib import Path
from typing import ClassVar

from markermend_app.views.component import Component

SEEKS = "seeks"
"""Tag of a figure in which a tap moves the cursor there."""


class Playheads(Component):
    """Moves every Bokeh `Span` with the name ``playhead`` with the frames of the 3D view."""

    _esm: ClassVar[Path] = Path(__file__).with_name("playheads.js")
