"""The 3D view on the page: fed from the desk, and its clock fed back."""

from typing import Any

import numpy as np

from markermend.repairing import Repair
from markermend_app.plots.scene import scene_colours
from markermend_app.state.desk import Desk
from markermend_app.style.kinds import KIND_STYLES
from markermend_app.views.scene import Focus, SceneView

NEIGHBOURS = 4


class Stage:
    """The skeleton with the finding at hand.

    Attributes
    ----------
    panel
        What goes into the page.
    """

    def __init__(self, desk: Desk) -> None:
        self.desk = desk
        self.panel = SceneView(sizing_mode="stretch_both", margin=0)
        watch = desk.param.watch
        watch(self._open, ["opened", "bones"])
        watch(self._focus, ["selected", "repair", "raw_only", "review", "theme"])
        watch(self._play, ["frame", "playing", "speed", "looping", "selected", "following", "view"])
        watch(self._paint, ["theme"])
        watch(self._mend, ["mended", "opened"])
        self._mended: dict[Any, Any] = {}
        self.panel.param.watch(self._report, ["frame", "playing", "view"])
        self.panel.param.watch(self._picked, ["selected"])
        self._paint()
        self._open()

    def _open(self, *_: object) -> None:
        opened = self.desk.opened
        if opened is None:
            return
        take = opened.take
        shown = np.flatnonzero([role != "model" for role in take.roles])
        self._place = {int(m): i for i, m in enumerate(shown)}
        self._index = [int(m) for m in shown]
        bones = [(self._place[a], self._place[b]) for a, b in self.desk.skeleton[1]]
        labels = [take.labels[m] for m in shown]
        # All of a long take are not copied.
        positions = take.positions if len(shown) == take.n_markers else take.positions[:, shown]
        self._mended = {}
        self.panel.show_take(positions, take.rate, labels, bones, frame=self.desk.frame)
        self._focus()
        self._play()
        self._mend()

    def _focus(self, *_: object) -> None:
        desk, opened, current, span = self.desk, self.desk.opened, self.desk.current, self.desk.span
        if opened is None or current is None or span is None:
            self.panel.show_focus(None)
            return
        take = opened.take
        marker = take.index(current.marker)
        repair = None if desk.raw_only else desk.repair
        near = opened.mesh.neighbours(marker, NEIGHBOURS)
        self.panel.show_focus(
            Focus(
                self._place[marker],
                span.start,
                span.stop,
                KIND_STYLES[desk.judged(current).kind].colour(desk.theme),
                tuple(self._place[m] for m in near),
                take.positions[span.frames, marker],
                None if repair is None else repair.values,
            )
        )

    def _mend(self, *_: object) -> None:
        """Show accepted repairs in place of what was recorded; the focus shows that as a ghost."""
        opened, after = self.desk.opened, self.desk.mended
        if opened is None or after is self._mended:
            return
        before, self._mended = self._mended, after
        for key in {**before, **after}:
            old, new = before.get(key), after.get(key)
            if old is new:
                continue
            if old is not None:
                self._amend(old, shown=False)
            if new is not None:
                self._amend(new, shown=True)

    def _amend(self, done: Repair, *, shown: bool) -> None:
        take = self.desk.opened.take
        for label, values in ((done.marker, done.values), *done.also):
            self.panel.amend(
                self._place[take.index(label)],
                (done.span.start, done.span.stop),
                values if shown else None,
            )

    def _play(self, *_: object) -> None:
        desk, loop = self.desk, self.desk.loop
        self.panel.param.update(
            frame=desk.frame,
            playing=desk.playing,
            speed=desk.speed,
            loop=None if loop is None else (loop.start, loop.stop),
            follow=desk.following,
            view=desk.view,
        )

    def _paint(self, *_: object) -> None:
        self.panel.colours = scene_colours(self.desk.theme)

    def _report(self, *events: Any) -> None:
        self.desk.param.update(**{event.name: event.new for event in events})

    def _picked(self, event: Any) -> None:
        if 0 <= event.new < len(self._index):
            current = self.desk.current
            marker = self._index[event.new]
            if current is None or self.desk.opened.take.labels[marker] != current.marker:
                self.desk.select_marker(marker)
