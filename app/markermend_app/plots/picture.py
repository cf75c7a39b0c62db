"""A picture of an experiment: panels with a title and a caption, in one file that asks for nothing.

The file holds the drawing program, the typeface and the data, and a policy that forbids every
request, so that it can be sent, archived and opened without a network.
"""

import re
from base64 import b64encode
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any

import holoviews as hv
import numpy as np
from bokeh.core.properties import value
from bokeh.embed import components
from bokeh.models import ColorBar, SaveTool, Text
from bokeh.resources import Resources

from markermend_app.plots.figures import FONT, paint
from markermend_app.style import sheet
from markermend_app.style.tokens import TOKENS

INK = TOKENS["light"]
FONTS = Path(sheet.__file__).parent / "fonts"
RENDERER = hv.renderer("bokeh")

POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src data: blob:; font-src data:"
)

STYLE = """
body{margin:24px 32px 40px;background:VAR-panel;color:VAR-ink;
 font:13px/1.45 FONT;font-variant-numeric:tabular-nums}
h1{margin:0 0 4px;font-size:20px;font-weight:700}
.caption{max-width:900px;margin:0 0 20px;color:VAR-ink2}
.row{display:flex;flex-wrap:wrap;gap:16px 28px;margin:0 0 20px;break-inside:avoid}
figure{margin:0}
figcaption{margin:0 0 4px;font-weight:700;white-space:pre-line}
@media print{body{margin:0}}
"""


@dataclass(frozen=True, eq=False)
class Panel:
    """One element with the words above it; a title may have several lines."""

    title: str
    element: Any


@dataclass(frozen=True, eq=False)
class Picture:
    """Rows of panels under a title and a caption that says how the figures came about."""

    title: str
    caption: str
    rows: tuple[tuple[Panel, ...], ...]

    @property
    def panels(self) -> tuple[Panel, ...]:
        """All panels, row by row."""
        return tuple(panel for row in self.rows for panel in row)


def drawn(
    element: Any, width: int, height: int, *, grid: str = "xy", framed: bool = True, **options: Any
) -> Any:
    """Give an element its size in px without axes, fonts, colours, a grid along x, y or both."""
    common = {
        "frame_width": width,
        "frame_height": height,
        "default_tools": [],
        "toolbar": None,
        "hooks": [_dress, _ruled(grid, framed)],
        "show_legend": False,
        "show_grid": bool(grid),
    }
    return element.opts(**common | options, backend="bokeh", clone=True)


def _dress(plot: Any, _element: Any) -> None:
    """Paint a figure for paper: light, fonts of the house, vectors instead of pixels."""
    figure = plot.state
    paint(figure, INK)
    figure.output_backend = "svg"
    figure.add_tools(SaveTool())
    for text in figure.select({"type": Text}):
        text.text_font = value(FONT)
    for axis in (*figure.xaxis, *figure.yaxis):
        axis.update(axis_line_color=INK["line2"], major_tick_line_color=INK["line2"])
        axis.update(major_tick_in=0, major_tick_out=4, axis_label_text_color=INK["ink"])
    for bar in figure.select({"type": ColorBar}):
        bar.update(major_label_text_font=FONT, major_label_text_font_size="11px")
        bar.update(major_label_text_color=INK["ink2"])
    for legend in figure.legend:
        legend.update(label_text_font=FONT, label_text_font_size="11px", border_line_color=None)
        legend.update(label_text_color=INK["ink2"], background_fill_alpha=0.8, spacing=14)


def _ruled(lines: str, framed: bool) -> Callable[[Any, Any], None]:
    def hook(plot: Any, _element: Any) -> None:
        plot.state.xgrid.visible, plot.state.ygrid.visible = "x" in lines, "y" in lines
        if not framed:
            plot.state.outline_line_color = None

    return hook


def words(points: Iterable[tuple[float, float, str]], **options: Any) -> Any:
    """Write (x, y, text) into a plot."""
    style = {"text_color": INK["ink2"], "text_font_size": "11px"}
    table = list(points)
    return hv.Labels(table, ["x", "y"], "text").opts(**style | options, backend="bokeh")


def log_ticks(low: float, high: float) -> list[tuple[float, str]]:
    """Give round numbers between two positive ones: more of each decade the fewer there are."""
    decades = range(int(np.floor(np.log10(low))), int(np.ceil(np.log10(high))) + 1)
    wide = high / low
    digits: tuple[float, ...] = (1,) if wide >= 1e3 else (1, 2, 5)
    if wide < 10:
        digits = (1, 1.5, 2, 3, 4, 5, 7)
    ticks = [digit * 10.0**decade for decade in decades for digit in digits]
    return [(tick, f"{tick:g}") for tick in ticks if low <= tick <= high]


def log_range(values: Iterable[float], room: float = 1.4) -> tuple[float, float]:
    """Give a range around the positive finite ones of some values, `room` times wider each way."""
    known = [value for value in values if np.isfinite(value) and value > 0]
    if not known:
        return 0.1, 10.0
    return min(known) / room, max(known) * room


def html(picture: Picture) -> str:
    """Give a page that holds all it needs."""
    models = [RENDERER.get_plot(panel.element).state for panel in picture.panels]
    for model in models:
        model.sizing_mode = None  # the frame has a size, the figure takes what its labels need
    script, places = components(models)
    waiting = iter(places)
    rows = "\n".join(_row(row, [next(waiting) for _ in row]) for row in picture.rows)
    library = "\n".join(
        f"<script>{text}</script>" for text in Resources(mode="inline", components=["bokeh"]).js_raw
    )
    return "\n".join(
        (
            "<!DOCTYPE html>",
            '<html lang="en"><head><meta charset="utf-8">',
            f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">',
            f"<title>{escape(picture.title)}</title>",
            f"<style>{_style()}</style>",
            library,
            "</head><body>",
            f"<h1>{escape(picture.title)}</h1>",
            f'<p class="caption">{escape(_kept_together(picture.caption))}</p>',
            rows,
            script.strip(),
            "</body></html>\n",
        )
    )


def _row(panels: Sequence[Panel], places: Sequence[str]) -> str:
    figures = (
        f"<figure><figcaption>{escape(panel.title)}</figcaption>{place}</figure>"
        for panel, place in zip(panels, places, strict=True)
    )
    return f'<div class="row">{"".join(figures)}</div>'


def _kept_together(text: str) -> str:
    """Put a space that does not break between a number and its unit."""
    return re.sub(r"(\d) (?=(mm|Hz|%)\b|%)", "\\1\N{NO-BREAK SPACE}", text)


def _style() -> str:
    faces = "".join(
        f'@font-face{{font-family:"Roboto";font-weight:{weight};src:url("data:font/woff2;base64,'
        f'{b64encode((FONTS / f"roboto-latin-{weight}-normal.woff2").read_bytes()).decode()}")}}'
        for weight in (400, 700)
    )
    style = STYLE.replace("FONT", FONT)
    for name in ("panel", "ink2", "ink"):
        style = style.replace(f"VAR-{name}", INK[name])
    return faces + style
