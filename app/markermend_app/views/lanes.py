"""The lanes and the overview on the page: filled from the desk, and what is done in them."""

from typing import Any

import panel as pn
from bokeh.events import RangesUpdate, SelectionGeometry, Tap
from bokeh.models import Column

from markermend_app.plots.lanes import Lanes
from markermend_app.plots.overview import Overview
from markermend_app.state import curves
from markermend_app.state import overview as all_markers
from markermend_app.state.desk import Desk
from markermend_app.views.component import at_once
from markermend_app.views.part import Intent
from markermend_app.views.playheads import SEEKS

LANES_SHOW = (
    "opened", "review", "findings", "selected", "marker", "theme", "window", "signal", "relative",
    "mended",
)  # fmt: skip
REPAIRS_SHOW = (
    "opened", "selected", "marker", "previews", "chosen", "raw_only", "window", "signal",
    "relative", "review",
)  # fmt: skip
DRAG_MS = 200
"""A drag of the tab has ended when it has rested that long."""
REACH = 0.9
"""How far a window may move, in its own width, before more of the curves is sent."""
ALIKE = 0.7
"""How much narrower or wider it may become."""
OVERVIEW_SHOWS = ("opened", "review", "findings", "selected", "theme")


class LanesView:
    """X, Y, Z and evidence of the selected marker.

    Attributes
    ----------
    panel, evidence
        What goes into the page.
    """

    def __init__(self, desk: Desk, intent: Intent) -> None:
        self.desk, self._intent = desk, intent
        n_dims = desk.opened.take.n_dims if desk.opened else 3
        self.lanes = Lanes(n_dims)
        figures = Column(*self.lanes.figures[:-1], sizing_mode="stretch_both", spacing=0)
        self.panel = pn.pane.Bokeh(figures, sizing_mode="stretch_both", margin=0)
        self.evidence = pn.pane.Bokeh(self.lanes.evidence, sizing_mode="stretch_both", margin=0)
        for figure in self.lanes.figures:
            figure.tags = [SEEKS]
        self.lanes.axes[0].on_event(RangesUpdate, self._moved)
        for figure in self.lanes.axes:
            figure.on_event(SelectionGeometry, self._swept)
        self.lanes.ruler.tab.on_change("left", self._dragged)
        self.lanes.ruler.tab.on_change("right", self._dragged)
        self._filling = False
        self._shown: tuple[tuple[float, float], bool] = ((0.0, 0.0), False)
        self._rest: Any = None
        desk.param.watch(self._rewindow, ["window"])
        desk.param.watch(self._refill, list(LANES_SHOW))
        desk.param.watch(self._refill_repairs, list(REPAIRS_SHOW))
        self._rewindow()

    def _refill(self, *events: Any) -> None:
        if self._still_serves(events):
            self.lanes.fit_ruler()
            return
        values = curves.lanes(self.desk)
        if values is not None:
            self._shown = self.desk.window, values.relative
            self._filling = True
            self.lanes.show(values, self.desk.theme)
            self._filling = False

    def _refill_repairs(self, *events: Any) -> None:
        values = curves.repairs(self.desk)
        if values is None:
            return
        if self._still_serves(events):
            self.lanes.fit(values.y_ranges)
        else:
            self.lanes.show_repairs(values)

    def _still_serves(self, events: tuple[Any, ...]) -> bool:
        """Tell whether only the window has moved, and what is drawn reaches beyond it.

        What is drawn is the window that it was made for and as much again on both sides.
        """
        if [getattr(event, "name", "") for event in events] != ["window"]:
            return False
        (first, last), relative = self._shown
        low, high = self.desk.window
        reach = REACH * (last - first)
        return (
            first - reach <= low
            and high <= last + reach
            and ALIKE <= (high - low) / max(last - first, 1e-9) <= 1 / ALIKE
            and curves.is_relative(self.desk) == relative
        )

    def _rewindow(self, *_: object) -> None:
        low, high = self.desk.window
        if (self.lanes.x_range.start, self.lanes.x_range.end) != (low, high):
            self.lanes.x_range.update(start=low, end=high)

    @at_once
    def _moved(self, event: Any) -> None:
        """Follow a pan or zoom made in the browser."""
        if event.x0 is not None and (event.x0, event.x1) != self.desk.window:
            self.desk.window = (float(event.x0), float(event.x1))

    @at_once
    def _swept(self, event: Any) -> None:
        """Add the span that was dragged over a lane."""
        desk = self.desk
        if desk.opened is None or not event.final or not desk.adding:
            return
        rate = desk.opened.take.rate
        first, last = (event.geometry[edge] * rate for edge in ("x0", "x1"))
        self._intent("add", (round(first), max(round(first), round(last)) + 1), {})

    @at_once
    def _dragged(self, attr: str, old: float, new: float) -> None:
        """Move the edges of the finding once the tab rests."""
        if self._filling:
            return
        document = self.lanes.ruler.figure.document
        if self._rest is not None:
            document.remove_timeout_callback(self._rest)
        self._rest = document.add_timeout_callback(self._rested, DRAG_MS)

    @at_once
    def _rested(self) -> None:
        self._rest = None
        if self.desk.opened is None or self.desk.span is None:
            return
        rate, tab = self.desk.opened.take.rate, self.lanes.ruler.tab
        start, stop = round(tab.left * rate + 0.5), round(tab.right * rate + 0.5)
        self._intent("edges", (start, max(stop, start + 1)), {})
        self._refill()  # back to whole frames, and to where it was if nothing changed


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
        self.values = all_markers.overview(self.desk)
        if self.values is not None:
            self.overview.show(self.values, self.desk.theme)

    def _rewindow(self, *_: object) -> None:
        low, high = self.desk.window
        self.overview.window.update(left=low, right=high)

    @at_once
    def _tapped(self, event: Any) -> None:
        if event.x is None or event.y is None or self.values is None:
            return
        found = self.desk.nearest(float(event.x), float(event.y), self.values)
        if found is not None:
            self.desk.select(found)
        else:
            self.desk.go(float(event.x), self.values.duration_s)
