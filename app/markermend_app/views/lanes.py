"""The lanes and the overview on the page: filled from the desk, and what is done in them."""

from typing import Any

import panel as pn
from bokeh.events import RangesUpdate, Tap
from bokeh.models import Column, CustomJS

from markermend_app.plots.lanes import Lanes
from markermend_app.plots.overview import Overview
from markermend_app.state import curves
from markermend_app.state.desk import Desk
from markermend_app.views.scene import CURSOR_JS, SEEK_JS

LANES_SHOW = ("opened", "review", "findings", "selected", "theme")
REPAIRS_SHOW = ("opened", "selected", "previews", "chosen", "raw_only")
OVERVIEW_SHOWS = ("opened", "review", "findings", "selected", "theme")


class LanesView:
    """X, Y, Z and evidence of the selected marker.

    Attributes
    ----------
    panel
        What goes into the page.
    """

    def __init__(self, desk: Desk) -> None:
        self.desk = desk
        n_dims = desk.opened.take.n_dims if desk.opened else 3
        self.lanes = Lanes(n_dims)
        self.panel = pn.pane.Bokeh(
            Column(*self.lanes.figures, sizing_mode="stretch_both", spacing=0),
            sizing_mode="stretch_both",
            margin=0,
        )
        for figure in self.lanes.figures:
            figure.js_on_event(Tap, CustomJS(code=SEEK_JS))
        self.lanes.figures[0].on_event(RangesUpdate, self._moved)
        desk.param.watch(self._refill, list(LANES_SHOW))
        desk.param.watch(self._refill_repairs, list(REPAIRS_SHOW))
        desk.param.watch(self._rewindow, ["window"])
        self._rewindow()

    def _refill(self, *_: object) -> None:
        values = curves.lanes(self.desk)
        if values is not None:
            self.lanes.show(values, self.desk.theme)

    def _refill_repairs(self, *_: object) -> None:
        values = curves.repairs(self.desk)
        if values is not None:
            self.lanes.show_repairs(values)

    def _rewindow(self, *_: object) -> None:
        low, high = self.desk.window
        if (self.lanes.x_range.start, self.lanes.x_range.end) != (low, high):
            self.lanes.x_range.update(start=low, end=high)
        self._refill()
        self._refill_repairs()

    def _moved(self, event: Any) -> None:
        """Follow a pan or zoom made in the browser."""
        if event.x0 is not None and (event.x0, event.x1) != self.desk.window:
            self.desk.window = (float(event.x0), float(event.x1))


class OverviewView:
    """All markers over time; a tap selects the nearest finding, or jumps.

    Attributes
    ----------
    panel
        What goes into the page.
    """

    def __init__(self, desk: Desk) -> None:
        self.desk = desk
        self.overview = Overview()
        self.panel = pn.pane.Bokeh(self.overview.figure, sizing_mode="stretch_both", margin=0)
        self.overview.figure.on_event(Tap, self._tapped)
        desk.param.watch(self._refill, list(OVERVIEW_SHOWS))
        desk.param.watch(self._rewindow, ["window"])
        self._refill()
        self._rewindow()

    def _refill(self, *_: object) -> None:
        self.values = curves.overview(self.desk)
        if self.values is not None:
            self.overview.show(self.values, self.desk.theme)

    def _rewindow(self, *_: object) -> None:
        low, high = self.desk.window
        self.overview.window.update(left=low, right=high)

    def _tapped(self, event: Any) -> None:
        if event.x is not None and event.y is not None:
            self.desk.jump(float(event.x), float(event.y), self.values)


def cursor_script(lanes: LanesView, overview: OverviewView) -> CustomJS:
    """Give the script that moves all playheads in the browser."""
    spans = [*lanes.lanes.cursor, overview.overview.playhead]
    return CustomJS(args={"cursors": spans}, code=CURSOR_JS)
