"""What all figures of the desk share: a lane on the time axis, its playhead, fonts and colours."""

from typing import Any

from bokeh.models import (
    CrosshairTool,
    PanTool,
    PrintfTickFormatter,
    Range1d,
    Span,
    WheelZoomTool,
)
from bokeh.plotting import figure

GUTTER = 68
FONT = "Roboto, system-ui, 'Liberation Sans', sans-serif"


WITHOUT_EDGE = {"clip-path": "inset(2px 0 0 1px)"}
"""Bokeh leaves the first pixels of a canvas as they were, white or of the theme before."""


def lane(x_range: Range1d, *tools: Any, **options: Any) -> Any:
    """Make a figure on the shared time axis, panned and zoomed along it only."""
    pan, wheel = PanTool(dimensions="width"), WheelZoomTool(dimensions="width")
    given = {
        "min_border_top": 3,
        "min_border_bottom": 3,
        "sizing_mode": "stretch_both",
        "y_range": Range1d(0, 1),
    }
    fig = figure(
        x_range=x_range,
        tools=[pan, wheel, *tools],
        toolbar_location=None,
        min_border_left=GUTTER,
        min_border_right=12,
        output_backend="canvas",
        styles=WITHOUT_EDGE,
        **given | options,
    )
    fig.toolbar.active_drag, fig.toolbar.active_scroll = pan, wheel
    fig.xaxis.visible = False
    fig.yaxis.ticker.desired_num_ticks = 4
    fig.xaxis.formatter = PrintfTickFormatter(format="%.9g s")
    fig.add_tools(CrosshairTool(dimensions="height", line_alpha=0.25))
    return fig


def cursor(fig: Any) -> Span:
    """Add a playhead."""
    span = Span(location=0, dimension="height", line_width=1.4, name="playhead")
    fig.add_layout(span)
    return span


def paint(fig: Any, tokens: dict[str, str]) -> None:
    """Give a figure the colours and fonts of a theme."""
    fig.update(
        background_fill_color=tokens["panel"],
        border_fill_color=tokens["panel"],
        outline_line_color=tokens["line"],
    )
    for axis in (*fig.xaxis, *fig.yaxis):
        axis.update(
            axis_line_color=None,
            major_tick_line_color=None,
            minor_tick_line_color=None,
            major_label_text_color=tokens["ink2"],
            major_label_text_font=FONT,
            major_label_text_font_size="11px",
            axis_label_text_color=tokens["ink2"],
            axis_label_text_font=FONT,
            axis_label_text_font_style="normal",
            axis_label_text_font_size="11px",
        )
    for grid in (*fig.xgrid, *fig.ygrid):
        grid.grid_line_color = tokens["line"]
