"""Pictures of the filling of gaps whose truth is known, beside other programs."""

from collections.abc import Sequence
from typing import Any

import holoviews as hv
import numpy as np

from markermend.evaluate.masks import Row
from markermend_app.plots.picture import INK, Panel, Picture, drawn, log_range, log_ticks, words


def masks(rows: Sequence[Row], seeds: Sequence[int]) -> Picture:
    """Draw the filling of known gaps: the ratio to the best other program, and the error."""
    n = " to ".join(str(n) for n in sorted({min(r.n for r in rows), max(r.n for r in rows)}))
    panels = []
    caption = f"n = {n} gaps a row, seeds of the masks {', '.join(map(str, sorted(seeds)))}. "
    if any(np.isfinite(row.ratio) for row in rows):
        caption += (
            "The best other program of a row is the one with the lowest mean on the gaps that all "
            "of them have filled; the ratio is of the means on the same gaps, below 1 where ours "
            "is lower. "
        )
        panels.append(Panel("Mean error, divided by that of the best other program", ratios(rows)))
    panels.append(Panel("Mean and standard deviation of the error", errors(rows)))
    return Picture(
        "Filling of gaps whose truth is known",
        f"{caption}In brackets: gaps left unfilled. A whisker that reaches the frame goes on "
        "beyond it.",
        tuple((panel,) for panel in panels),
    )


def ratios(rows: Sequence[Row]) -> Any:
    """Draw the ratio to the best other program per cell and method, with number and name."""
    points = [(row.ratio, i) for i, row in enumerate(rows) if np.isfinite(row.ratio)]
    low, high = log_range([1.0, *(ratio for ratio, _ in points)], 1.25)
    wide = (high / low) ** 0.75
    column = high * wide**0.2
    numbers = [(column, i, f"{ratio:.2f}") for ratio, i in points]
    names = [(column, i, f"  × {rows[i].best} ({rows[i].best_mm:.2f} mm)") for _, i in points]
    layers = hv.Overlay(
        [
            hv.VLine(1.0).opts(
                color=INK["ink3"], line_dash="dashed", line_width=1.2, backend="bokeh"
            ),
            _dots(points, "ratio"),
            words(numbers, text_align="right"),
            words(names, text_align="left"),
        ]
    )
    return _lying(layers, rows, low, high * wide, high, "ratio")


def errors(rows: Sequence[Row]) -> Any:
    """Draw the error of each cell and method over the gaps that were filled."""
    points = [(row.mean_mm, i) for i, row in enumerate(rows) if np.isfinite(row.mean_mm)]
    low, high = log_range([row.mean_mm for row in rows] + [r.mean_mm + r.sd_mm for r in rows])
    whiskers = [
        (max(row.mean_mm - row.sd_mm, low), i, row.mean_mm + row.sd_mm, i)
        for i, row in enumerate(rows)
        if np.isfinite(row.mean_mm)
    ]
    layers = hv.Overlay(
        [
            hv.Segments(whiskers).opts(color=INK["ink"], line_width=1.4, backend="bokeh"),
            _dots(points, "mean"),
        ]
    )
    return _lying(layers, rows, low, high, high, "error, mm")


def _dots(points: Sequence[tuple[float, int]], name: str) -> Any:
    return hv.Points(points, [name, "row"]).opts(color=INK["ink"], size=8, backend="bokeh")


def _lying(
    layers: Any, rows: Sequence[Row], low: float, high: float, ticked: float, label: str
) -> Any:
    """Lay rows of a table beneath each other on a logarithmic axis with ticks up to `ticked`."""
    names = [f"{row.cell}, {row.method}" + (f" ({row.left})" if row.left else "") for row in rows]
    return drawn(
        layers,
        560,
        22 * len(rows) + 16,
        logx=True,
        xlim=(low, high),
        ylim=(-0.8, len(rows) - 0.2),
        xticks=log_ticks(low, ticked),
        yticks=list(enumerate(names)),
        invert_yaxis=True,
        xlabel=label,
        ylabel="",
        grid="x",
    )
