"""The lanes: a ruler, one Bokeh figure per axis and one for the evidence, on one time axis.

Figures are built once and their sources updated in place, since removed figures are never freed in
the browser.
"""

from typing import Any

import numpy as np
from bokeh.models import BoxSelectTool, ColumnDataSource, Label, Range1d, Span

from markermend.model import Kind
from markermend_app.plots.figures import FONT, cursor, lane, paint
from markermend_app.plots.ruler import Ruler
from markermend_app.state.values import Curve, LaneValues, RepairValues
from markermend_app.style.tokens import TOKENS


class Lanes:
    """X, Y, Z and the evidence of one marker.

    Attributes
    ----------
    figures
        The Bokeh figures from top to bottom.
    cursor
        The playheads, one per figure; ``location`` in seconds.
    x_range
        The shared time axis, in seconds.
    """

    def __init__(self, n_dims: int) -> None:
        self.x_range = Range1d(0, 1)
        self.sources = {
            name: ColumnDataSource(data={"t": [], **{axis: [] for axis in "xyz"}})
            for name in ("raw", "inside", "chosen", "partner", "also")
        }
        self.others = ColumnDataSource(data={"t": [], "x": [], "y": [], "z": []})
        self.mended = ColumnDataSource(data={"t": [], "x": [], "y": [], "z": []})
        self.after = ColumnDataSource(data={"t": [], "v": []})
        self.band = ColumnDataSource(data={"t": [], **{f"{a}{e}": [] for a in "xyz" for e in "01"}})
        self.marks = ColumnDataSource(
            data={name: [] for name in ("id", "left", "right", "fill", "alpha", "line", "dash")}
        )
        self.signal = ColumnDataSource(data={"t": [], "v": [], "over": [], "level": []})
        self.ruler = Ruler(self.x_range)
        self.axes = [self._axis_lane(axis) for axis in "xyz"[:n_dims]]
        self.evidence = self._evidence_lane()
        self.figures = [self.ruler.figure, *self.axes, self.evidence]
        self.cursor = [self.ruler.cursor, *(cursor(f) for f in self.figures[1:])]
        self.evidence.xaxis.visible = True
        self._worn: tuple[str, str] = ("", "")
        # Asking a figure for what it draws by name looks through all models of the page.
        self._drawn: dict[str, list[Any]] = {}
        for fig in self.figures[1:]:
            for renderer in fig.renderers:
                self._drawn.setdefault(renderer.name, []).append(renderer)

    def _axis_lane(self, axis: str) -> Any:
        sweep = BoxSelectTool(dimensions="width", persistent=False, name="sweep")
        fig = lane(self.x_range, sweep, name=f"lane-{axis}")
        fig.vstrip(
            x0="left",
            x1="right",
            source=self.marks,
            fill_color="fill",
            fill_alpha="alpha",
            line_color="line",
            line_dash="dash",
            name="spans",
        )
        fig.varea(
            x="t", y1=f"{axis}0", y2=f"{axis}1", source=self.band, name="band", fill_alpha=1.0
        )
        fig.multi_line(
            xs="t", ys=axis, source=self.others, line_dash=[5, 4], line_width=1.1, name="others"
        )
        fig.line(x="t", y=axis, source=self.sources["partner"], line_width=1.2, name="partner")
        fig.multi_line(xs="t", ys=axis, source=self.mended, line_width=1.8, name="mended")
        fig.line(x="t", y=axis, source=self.sources["raw"], line_width=1.5, name="raw")
        fig.line(x="t", y=axis, source=self.sources["inside"], line_width=1.5, name="inside")
        fig.scatter(x="t", y=axis, source=self.sources["inside"], size=3, name="dots")
        fig.line(x="t", y=axis, source=self.sources["chosen"], line_width=2.5, name="chosen")
        fig.line(
            x="t", y=axis, source=self.sources["also"], line_width=2.5, line_dash=[2, 3],
            name="also",
        )  # fmt: skip
        fig.yaxis.axis_label = f"{axis.upper()}  mm"
        return fig

    def _evidence_lane(self) -> Any:
        fig = lane(self.x_range, name="lane-evidence")
        fig.vstrip(
            x0="left",
            x1="right",
            source=self.marks,
            fill_color="fill",
            fill_alpha="alpha",
            line_color="line",
            line_dash="dash",
            name="spans",
        )
        fig.varea(x="t", y1="level", y2="over", source=self.signal, name="over", fill_alpha=0.45)
        fig.line(x="t", y="v", source=self.signal, line_width=1.3, name="signal")
        fig.line(x="t", y="v", source=self.after, line_width=2.0, name="after")
        self.threshold = Span(location=0, dimension="width", line_dash=[4, 3], line_width=1)
        self.levels = Label(
            x=8,
            y=0,
            x_units="screen",
            y_units="data",
            text="",
            text_font_size="11px",
            text_font=FONT,
            y_offset=2,
        )
        fig.add_layout(self.threshold)
        fig.add_layout(self.levels)
        return fig

    def show(self, values: LaneValues, theme: str) -> None:
        """Show another recording, in place."""
        tokens = TOKENS[theme]
        shown = (("raw", values.raw), ("inside", values.inside), ("partner", values.partner))
        for name, curve in shown:
            self.sources[name].data = {"t": curve.time, **_columns(curve.values)}
        self.mended.data = _lines(values.mended)
        self.marks.data = {
            "id": [mark.id for mark in values.marks],
            "left": [mark.start_s for mark in values.marks],
            "right": [mark.stop_s for mark in values.marks],
            "fill": [tokens[mark.kind] for mark in values.marks],
            "alpha": [
                0.0 if mark.settled else (0.14 if mark.selected else 0.10) for mark in values.marks
            ],
            "line": [tokens[mark.kind] for mark in values.marks],
            "dash": ["dashed" if mark.kind == "gap" else "solid" for mark in values.marks],
        }
        for fig, axis in zip(self.axes, "XYZ", strict=False):
            fig.yaxis.axis_label = f"{axis}  {values.unit}"
        self.ruler.show(next((m for m in values.marks if m.selected), None), theme)
        self.ruler.show_events(values.events, theme)
        self.fit_ruler()
        self._show_evidence(values)
        self.restyle(theme, values.kind)

    def show_repairs(self, values: RepairValues) -> None:
        """Show other repairs, in place."""
        chosen = _columns(values.chosen.values)
        self.sources["chosen"].data = {"t": values.chosen.time, **chosen}
        self.sources["also"].data = {"t": values.also.time, **_columns(values.also.values)}
        self.after.data = {"t": values.after.time, "v": values.after.values}
        self.others.data = _lines(values.others)
        half = np.zeros(0) if values.band is None else values.band
        n = len(half)
        self.band.data = {
            "t": values.chosen.time[:n],
            **{f"{a}0": chosen[a][:n] - half for a in "xyz"},
            **{f"{a}1": chosen[a][:n] + half for a in "xyz"},
        }
        self.fit(values.y_ranges)

    def fit(self, y_ranges: tuple[tuple[float, float], ...]) -> None:
        """Scale the lanes."""
        for fig, (low, high) in zip(self.axes, y_ranges, strict=False):
            fig.y_range.update(start=low, end=high)

    def fit_ruler(self) -> None:
        """Fit the words on the ruler to the window."""
        width = max(1e-9, self.x_range.end - self.x_range.start)
        self.ruler.fit((self.ruler.tab.right - self.ruler.tab.left) / width)

    def _show_evidence(self, values: LaneValues) -> None:
        shown = values.evidence
        if shown is None:
            self.signal.data = {"t": [], "v": [], "over": [], "level": []}
            self.evidence.yaxis.axis_label = ""
            self.levels.text = ""
            self.threshold.visible = False
            return
        level = np.full(len(shown.signal), shown.threshold)
        over = np.maximum(shown.signal, shown.threshold)
        if not np.isfinite(shown.threshold):
            level = over = np.full(len(shown.signal), np.nan)
        self.signal.data = {"t": shown.time, "v": shown.signal, "over": over, "level": level}
        known = shown.signal[np.isfinite(shown.signal)]
        top = max([1e-6, *known[:], *([shown.threshold] if np.isfinite(shown.threshold) else [])])
        bottom = min([0.0, *known[:]])
        self.evidence.y_range.update(start=bottom, end=top * 1.15)
        self.evidence.yaxis.axis_label = shown.unit
        self.threshold.visible = bool(np.isfinite(shown.threshold))
        if self.threshold.visible:
            self.threshold.location = shown.threshold
            self.levels.y = shown.threshold
            self.levels.text = (
                f"threshold {shown.threshold:.2g} {shown.unit}, usual {shown.usual:.2g}"
            )
        else:
            self.levels.text = ""

    def restyle(self, theme: str, kind_shown: Kind) -> None:
        """Take the colours of a theme and of a kind, unless they are worn already."""
        worn, self._worn = self._worn, (theme, kind_shown)
        if worn == self._worn:
            return
        tokens = TOKENS[theme]
        self._wear_kind(tokens[kind_shown])
        if worn[0] == theme:
            return
        lines = {
            "raw": tokens["ink"],
            "chosen": tokens["accent"],
            "others": tokens["ink3"],
            "signal": tokens["ink"],
            "after": tokens["accent"],
            "partner": tokens["ink3"],
            "mended": tokens["accent"],
            "also": tokens["accent"],
        }
        self.ruler.restyle(theme)
        for fig in self.figures[1:]:
            paint(fig, tokens)
        for name, colour in lines.items():
            for renderer in self._drawn[name]:
                renderer.glyph.line_color = colour
        for renderer in self._drawn["band"]:
            renderer.glyph.fill_color = tokens["band"]
        for span in self.cursor:
            span.line_color = tokens["ink"]
        self.threshold.line_color = tokens["ink2"]
        self.levels.text_color = tokens["ink2"]

    def _wear_kind(self, colour: str) -> None:
        for renderer in self._drawn["inside"]:
            renderer.glyph.line_color = colour
        for renderer in self._drawn["over"]:
            renderer.glyph.fill_color = colour
        for renderer in self._drawn["dots"]:
            renderer.glyph.update(fill_color=colour, line_color=colour)


def _lines(curves: tuple[Curve, ...]) -> dict[str, list[np.ndarray]]:
    return {
        "t": [curve.time for curve in curves],
        **{axis: [_columns(curve.values)[axis] for curve in curves] for axis in "xyz"},
    }


def _columns(values: np.ndarray) -> dict[str, np.ndarray]:
    missing = np.zeros(len(values))
    return {axis: values[:, d] if d < values.shape[1] else missing for d, axis in enumerate("xyz")}
