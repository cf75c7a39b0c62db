"""The 3D view: markers, bones, floor, trails and the chosen repair, played back in the browser.

Python makes the meshes (`markermend_app.plots.scene`) and keeps the positions; the browser draws
with the vtk.js that Panel ships (with a plain canvas where WebGL is missing), asks for positions in
chunks around the cursor, and runs the clock. `SceneView.frame` follows about ten times a second.

**Other parts of the page** hear of every frame in the browser itself, without Python, by events on
``window``:

``markermend:frame``  sent whenever another frame is drawn; ``detail`` has ``frame``, ``time`` in s,
                      ``playing``
``markermend:seek``   heard; ``detail`` has ``frame``, or ``time`` in s
``markermend:step``   heard; stops playback and moves by ``detail.by`` frames
``markermend:play``   heard; ``detail.playing`` true or false, or toggles without a detail

`markermend_app.views.playheads` moves the cursors of the figures by these events.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import param
from numpy.typing import NDArray
from panel.models.vtk import AbstractVTKPlot

from markermend_app.plots import scene as meshes
from markermend_app.views.component import Component
from markermend_app.views.javascript import joined

Array = NDArray[np.float64]

CHUNK_BYTES = 2_000_000
FEWEST_CHUNK_FRAMES = 500

_NUMBER = count(1)


@dataclass(frozen=True, eq=False)
class Focus:
    """What is shown of a finding.

    Attributes
    ----------
    marker
        Index of the marker.
    start, stop
        Its span in frames, half-open.
    colour
        The kind's colour, ``#RRGGBB``.
    neighbours
        Indices of the markers that are ringed.
    raw
        (stop - start, n_dims) as recorded, shown as a hollow ring; None to show none.
    repaired
        (stop - start, n_dims), NaN where a gap stays; None to show what `SceneView` was given.
    """

    marker: int
    start: int
    stop: int
    colour: str
    neighbours: tuple[int, ...] = ()
    raw: Array | None = None
    repaired: Array | None = None


class SceneView(Component):
    """The 3D view of one take; give it one with `show_take`, and findings with `show_focus`.

    Parameters
    ----------
    frame
        Cursor, 0-based. Set it to move there; while playing it follows the browser.
    playing, speed, loop
        Playback; `loop` is ``(start, stop)`` in frames, or None for the whole take.
    selected
        Index of the selected marker, -1 for none; a click on a marker selects it.
    view
        ``front``, ``side`` and ``top`` of the subject as it stands at the cursor, ``oblique`` at
        the beginning, ``free`` once it was turned by hand. The camera is left alone by all else.
    follow
        Whether the camera follows the subject.
    trail
        Seconds of the selected marker's path that are drawn before and after the cursor.
    colours
        See `markermend_app.plots.scene.scene_colours`.
    """

    frame = param.Integer(default=0, bounds=(0, None))
    playing = param.Boolean(default=False)
    speed = param.Number(default=1.0, bounds=(0.1, 4.0))
    loop = param.Tuple(default=None, length=2, allow_None=True)
    selected = param.Integer(default=-1)
    view = param.Selector(default="oblique", objects=["oblique", "front", "side", "top", "free"])
    follow = param.Boolean(default=True)
    trail = param.Number(default=0.5, bounds=(0.0, 2.0))
    colours = param.Dict(default=meshes.scene_colours("light"))

    scene = param.Dict(default={}, doc="What stays the same while a take is shown.")
    focus = param.Dict(default={}, doc="The finding, as the browser gets it.")
    vtk_url = param.String(default=AbstractVTKPlot.__javascript__[0], constant=True)

    _esm: ClassVar[str] = joined(Path(__file__).with_name("scene.js"))

    def __init__(self, **params: Any) -> None:
        super().__init__(**params)
        self._positions: Array = np.empty((0, 0, 3))
        self._amended: dict[tuple[int, int, int], Array] = {}
        self._up = 2

    def show_take(
        self,
        positions: Array,
        rate: float,
        labels: Sequence[str],
        bones: Sequence[tuple[int, int]],
        *,
        frame: int = 0,
        selected: int = -1,
    ) -> None:
        """Show another take; the camera finds it anew.

        Parameters
        ----------
        positions
            (n_frames, n_markers, n_dims) mm, NaN where not seen. Not copied: it is read when the
            browser comes near.
        rate
            Frames per second.
        labels
            One per marker.
        bones
            Pairs of marker indices.
        frame, selected
            Where to begin.
        """
        n_frames, n_markers, _ = positions.shape
        self._positions = positions
        self._amended = {}
        self._up = meshes.up_axis(positions)
        around = meshes.surroundings(positions, self._up)
        chunk = max(FEWEST_CHUNK_FRAMES, CHUNK_BYTES // max(1, 12 * n_markers))
        first = meshes.z_up(positions[min(frame, n_frames - 1)], self._up)
        parts = {
            "skeleton": meshes.skeleton(first, bones),
            "floor": meshes.floor_grid(around),
            "trail": meshes.trail(),
            **meshes.shapes(),
        }
        scene = {
            "id": next(_NUMBER),
            "n_frames": n_frames,
            "n_markers": n_markers,
            "rate": float(rate),
            "labels": list(labels),
            "sides": meshes.sides(labels).tobytes(),
            "chunk_frames": min(chunk, max(1, n_frames)),
            "trail_points": meshes.TRAIL_POINTS,
            "floor": meshes.floor_height(around),
            "centre": around.centre.tolist(),
            "size": around.size.tolist(),
            "meshes": {name: meshes.buffers(mesh) for name, mesh in parts.items()},
        }
        self.param.update(
            scene=scene, focus={}, frame=frame, selected=selected, playing=False, loop=None
        )

    def show_focus(self, focus: Focus | None) -> None:
        """Show a finding and its chosen repair, whole and at once; None shows none."""
        if focus is None:
            self.focus = {}
            return
        shown: dict[str, Any] = {
            "take": self.scene.get("id"),
            "marker": focus.marker,
            "start": focus.start,
            "stop": focus.stop,
            "colour": focus.colour,
            "neighbours": [int(marker) for marker in focus.neighbours],
            "raw": None if focus.raw is None else self._upright(focus.raw),
            "repaired": None if focus.repaired is None else self._upright(focus.repaired),
        }
        self.param.update(focus=shown, selected=focus.marker)

    def amend(self, marker: int, frames: tuple[int, int], values: Array | None) -> None:
        """Show other positions of a marker in a span, or again those that it was given.

        Parameters
        ----------
        marker
            Index.
        frames
            Start and stop of the span, half-open.
        values
            (stop - start, n_dims), or None to take an amendment of this span back.
        """
        start, stop = frames
        if values is None:
            self._amended.pop((marker, start, stop), None)
        else:
            self._amended[marker, start, stop] = values
        self._send_msg(
            {
                "type": "patch",
                "take": self.scene["id"],
                "marker": int(marker),
                "start": int(start),
                "data": self._upright(self._between(start, stop)[:, marker]),
            }
        )

    def _between(self, start: int, stop: int) -> Array:
        """Give the positions of some frames as they are to be shown."""
        part = self._positions[start:stop]
        shown = part
        for (marker, first, last), values in self._amended.items():
            low, high = max(start, first), min(stop, last)
            if low < high:
                shown = part.copy() if shown is part else shown
                shown[low - start : high - start, marker] = values[low - first : high - first]
        return shown

    def _handle_msg(self, msg: Mapping[str, Any]) -> None:
        if msg["take"] != self.scene.get("id"):
            return  # asked before another take was shown
        if msg["type"] == "pick":
            self.selected = int(msg["marker"])
        elif msg["type"] == "want":
            self._send_chunk(int(msg["chunk"]))

    def _send_chunk(self, chunk: int) -> None:
        n_frames = self.scene["chunk_frames"]
        part = self._between(chunk * n_frames, (chunk + 1) * n_frames)
        self._send_msg(
            {
                "type": "chunk",
                "take": self.scene["id"],
                "chunk": chunk,
                "data": self._upright(part),
            }
        )

    def _upright(self, positions: Array) -> bytes:
        return meshes.z_up(positions, self._up).astype("<f4").tobytes()
