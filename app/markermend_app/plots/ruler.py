"""The ruler over the lanes: the span as a tab whose edges drag, and the events of the file."""

from typing import Any

from bokeh.models import BoxAnnotation, ColumnDataSource, Label, Range1d

from markermend_app.plots.figures import FONT, cursor, lane, paint
from markermend_app.state.values import EventMark, SpanMark
from markermend_app.style.kinds import KIND_STYLES
from markermend_app.style.tokens import TOKENS

HEIGHT = 28


class Ruler:
    """A strip on the lanes' time axis.

    Attributes
    ----------
    figure
        The Bokeh figure.
    tab
        The span; the browser changes ``left`` and ``right`` in seconds.
    cursor
        The playhead.
    """

    def __init__(self, x_range: Range1d) -> None:
        fig = lane(
            x_range,
            height=HEIGHT,
            min_height=HEIGHT,
            sizing_mode="stretch_width",
            min_border_top=2,
            min_border_bottom=0,
            name="ruler",
        )
        fig.yaxis.visible = False
        fig.grid.visible = False
        self.tab = BoxAnnotation(
            left=0,
            right=0,
            top=0.98,
            bottom=0.2,
            editable=True,
            resizable="x",
            movable="x",
            border_radius=3,
            fill_alpha=1.0,
            line_color=None,
            visible=False,
            use_handles=False,
            name="tab",
        )
        self.words = Label(
            x=0,
            y=0.24,
            text="",
            x_offset=12,
            text_font=FONT,
            text_font_size="11px",
            text_font_style="bold",
            name="tab-words",
        )
        self.ends = [
            Label(x=0, y=0.24, text=sign, x_offset=offset, text_align=align, text_font=FONT,
                  text_font_size="11px", text_font_style="bold", visible=False)
            for sign, offset, align in (("[", 3, "left"), ("]", -3, "right"))
        ]  # fmt: skip
        self.events = ColumnDataSource(data={"t": [], "y": [], "label": []})
        self.flags = fig.scatter(
            x="t", y="y", marker="inverted_triangle", size=7, source=self.events, name="events"
        )
        self.names = fig.text(
            x="t",
            y="y",
            text="label",
            source=self.events,
            x_offset=6,
            text_baseline="middle",
            text_font_size="10.5px",
            text_font={"value": FONT},
        )
        for part in (self.tab, self.words, *self.ends):
            fig.add_layout(part)
        self.cursor = cursor(fig)
        self.figure: Any = fig

    def show(self, mark: SpanMark | None, theme: str) -> None:
        """Show another span, in place."""
        tokens = TOKENS[theme]
        shown = mark is not None
        for part in (self.tab, self.words, *self.ends):
            part.visible = shown
        if mark is None:
            return
        ink = tokens[f"on-{mark.kind}"]
        self.tab.update(left=mark.start_s, right=mark.stop_s, fill_color=tokens[mark.kind])
        length = mark.stop_s - mark.start_s
        self.words.update(
            x=mark.start_s,
            text=f"{KIND_STYLES[mark.kind].title} {length:.2f} s",
            text_color=ink,
        )
        for end, at in zip(self.ends, (mark.start_s, mark.stop_s), strict=True):
            end.update(x=at, text_color=ink)

    def fit(self, width_share: float) -> None:
        """Leave the words out where the tab is too narrow for them."""
        self.words.visible = self.tab.visible and width_share > 0.16
        for end in self.ends:
            end.visible = self.tab.visible and width_share > 0.04

    def show_events(self, events: tuple[EventMark, ...], theme: str) -> None:
        """Show the events of a take."""
        tokens = TOKENS[theme]
        self.events.data = {
            "t": [e.time_s for e in events],
            "y": [0.6 for _ in events],
            "label": [e.label for e in events],
        }
        self.flags.glyph.update(fill_color=tokens["ink2"], line_color=None)
        self.names.glyph.text_color = tokens["ink2"]

    def restyle(self, theme: str) -> None:
        """Take the colours of a theme."""
        paint(self.figure, TOKENS[theme])
        self.figure.outline_line_color = None
        self.cursor.line_color = TOKENS[theme]["ink"]
