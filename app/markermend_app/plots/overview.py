"""All markers over time in one picture; a tap jumps."""

from typing import Any

import numpy as np
from bokeh.models import (
    BoxAnnotation,
    ColumnDataSource,
    FixedTicker,
    LinearColorMapper,
    PrintfTickFormatter,
    Range1d,
    Span,
    TapTool,
)
from bokeh.plotting import figure

from markermend.model import FloatArray
from markermend_app.plots.figures import GUTTER, WITHOUT_EDGE, paint
from markermend_app.state.values import OverviewValues, SpanMark
from markermend_app.style.tokens import TOKENS


class Overview:
    """Marker × time: shaded by speed, spans by kind, the lanes' window, the playhead.

    Attributes
    ----------
    figure
        The Bokeh figure; its taps are for the view to hear.
    """

    def __init__(self) -> None:
        self.image = ColumnDataSource(data={"image": [np.zeros((1, 1))], "dw": [1.0], "dh": [1.0]})
        self.marks = ColumnDataSource(
            data={name: [] for name in ("id", "left", "right", "bottom", "top", "fill", "line")}
        )
        self.ring = ColumnDataSource(data={name: [] for name in ("left", "right", "bottom", "top")})
        fig = figure(
            x_range=Range1d(0, 1),
            y_range=Range1d(0, 1),
            tools=[TapTool()],
            toolbar_location=None,
            min_border_left=GUTTER,
            min_border_right=12,
            min_border_top=28,
            min_border_bottom=4,
            sizing_mode="stretch_both",
            styles=WITHOUT_EDGE,
            name="overview",
        )
        self.mapper = LinearColorMapper(palette=["#FFFFFF"], low=0, high=1)
        shades = fig.image(
            image="image", x=0, y=0, dw="dw", dh="dh", source=self.image, color_mapper=self.mapper
        )
        quads = fig.quad(
            left="left",
            right="right",
            bottom="bottom",
            top="top",
            fill_color="fill",
            line_color="line",
            source=self.marks,
            name="spans",
        )
        self.selected = fig.quad(
            left="left",
            right="right",
            bottom="bottom",
            top="top",
            fill_alpha=0,
            line_width=2,
            source=self.ring,
        )
        for renderer in (shades, quads, self.selected):
            renderer.nonselection_glyph = renderer.selection_glyph = None
        self.window = BoxAnnotation(left=0, right=1, fill_alpha=0.08, line_width=1.6)
        self.playhead = Span(location=0, dimension="height", line_width=1.2, name="playhead")
        fig.add_layout(self.window)
        fig.add_layout(self.playhead)
        fig.ygrid.visible = False
        fig.xaxis.formatter = PrintfTickFormatter(format="%.9g s")
        self.figure: Any = fig
        self._shade: FloatArray | None = None
        self._theme = ""
        self._marks: tuple[tuple[str, SpanMark], ...] = ()

    def show(self, values: OverviewValues, theme: str) -> None:
        """Show another take, other findings or another theme, in place; only what has changed."""
        tokens = TOKENS[theme]
        anew = values.shade is not self._shade or theme != self._theme
        if values.shade is not self._shade:
            self._shade = values.shade
            self._show_take(values)
        if theme != self._theme:
            self._theme = theme
            self._restyle(tokens)
        self._show_marks(values, tokens, anew)
        self._show_ring(values)

    def _show_take(self, values: OverviewValues) -> None:
        n_rows = max(1, len(values.shade))
        fig = self.figure
        fig.x_range.update(start=0, end=max(values.duration_s, 1e-3))
        fig.y_range.update(start=0, end=n_rows)
        self.image.data = {"image": [values.shade], "dw": [values.duration_s], "dh": [n_rows]}
        known = values.shade[np.isfinite(values.shade)]
        self.mapper.high = float(np.quantile(known, 0.98)) if known.size else 1.0
        fig.yaxis.ticker = FixedTicker(ticks=[row for row, _ in values.groups])
        fig.yaxis.major_label_overrides = {row: _cut(name) for row, name in values.groups}

    def _restyle(self, tokens: dict[str, str]) -> None:
        self.mapper.update(
            palette=_ramp(tokens["panel"], tokens["line2"], 64), nan_color=tokens["sunk"]
        )
        paint(self.figure, tokens)
        self.window.update(fill_color=tokens["accent"], line_color=tokens["accent"])
        self.playhead.line_color = tokens["ink"]
        self.selected.glyph.line_color = tokens["ink"]

    def _show_marks(self, values: OverviewValues, tokens: dict[str, str], anew: bool) -> None:
        """Send what differs: mostly one mark that is settled now."""
        before, self._marks = self._marks, values.marks
        if anew or len(before) != len(values.marks):
            rows = [_drawn(values, label, mark, tokens) for label, mark in values.marks]
            columns = list(zip(*rows, strict=True)) or [()] * len(self.marks.data)
            self.marks.data = {
                name: list(column) for name, column in zip(self.marks.data, columns, strict=True)
            }
            return
        both = enumerate(zip(before, values.marks, strict=True))
        differ = [i for i, (a, b) in both if a is not b]
        patches: dict[str, list[tuple[int, Any]]] = {}
        for i in differ:
            drawn = _drawn(values, *values.marks[i], tokens)
            for name, value in zip(self.marks.data, drawn, strict=True):
                if self.marks.data[name][i] != value:
                    patches.setdefault(name, []).append((i, value))
        if patches:
            self.marks.patch(patches)

    def _show_ring(self, values: OverviewValues) -> None:
        ring: dict[str, list[float]] = {name: [] for name in self.ring.data}
        least = _least(values)
        for label, mark in values.marks:
            if mark.selected:
                left, right = _edges(values, mark)
                row = values.rows[label]
                grown = (left - least / 2, right + least / 2, row - 0.9, row + 1.9)
                for name, value in zip(ring, grown, strict=True):
                    ring[name].append(value)
        if ring != self.ring.data:
            self.ring.data = ring


def _least(values: OverviewValues) -> float:
    """Give the shortest time that is drawn, about four pixels."""
    return values.duration_s / 220


def _edges(values: OverviewValues, mark: SpanMark) -> tuple[float, float]:
    more = max(0.0, _least(values) - (mark.stop_s - mark.start_s)) / 2
    return mark.start_s - more, mark.stop_s + more


def _drawn(
    values: OverviewValues, label: str, mark: SpanMark, tokens: dict[str, str]
) -> tuple[Any, ...]:
    """Give what one mark has in each of the columns."""
    row, fill = values.rows[label], "rgba(0,0,0,0)" if mark.settled else tokens[mark.kind]
    return (mark.id, *_edges(values, mark), row + 0.02, row + 0.98, fill, tokens[mark.kind])


def _cut(name: str, most: int = 8) -> str:
    return name if len(name) <= most else f"{name[: most - 1]}…"


def _ramp(first: str, last: str, n: int) -> list[str]:
    """Give `n` colours between two, as hex."""
    a, b = (np.array([int(c[i : i + 2], 16) for i in (1, 3, 5)]) for c in (first, last))
    shades = (a + (b - a) * share for share in np.linspace(0, 1, n))
    return ["#{:02X}{:02X}{:02X}".format(*np.round(shade).astype(int)) for shade in shades]
