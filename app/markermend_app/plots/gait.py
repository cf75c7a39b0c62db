"""Pictures of gaps in periodic gait, filled by low rank and sparsity."""

from collections.abc import Sequence
from typing import Any

import holoviews as hv
import numpy as np

from markermend.evaluate.kamali_splits import Split
from markermend.evaluate.kamali_tables import Cell, Kamali, Point
from markermend_app.plots.completion import dots, lying, styles
from markermend_app.plots.picture import INK, Panel, Picture, drawn, log_range, log_ticks


def kamali(result: Kamali) -> Picture:
    """Draw errors by mask (Fig. 4), by lambda (Fig. 3b), by number and by length of the gaps."""
    rows = []
    for take, markers in dict.fromkeys((cell.take, cell.markers) for cell in result.cells):
        cells = [c for c in result.cells if (c.take, c.markers) == (take, markers)]
        points = [p for p in result.sweep if (p.take, p.markers) == (take, markers)]
        panels = [Panel(f"{take}, {markers} markers\n○ a mask, ● mean, | median", by_mask(cells))]
        if points:
            title = f"Choice of λ, n = {points[0].masks} masks of their own\nmean and deviation"
            panels.append(Panel(title, by_weight(points)))
        for by, title in (
            ("gaps", "By the gaps in a mask"),
            ("share", "By a gap's share of a cycle"),
        ):
            some = [s for s in result.splits if (s.take, s.markers, s.by) == (take, markers, by)]
            if some:
                panels.append(Panel(f"{title}\nmean over gaps", by_class(some)))
        rows.append(tuple(panels))
    return Picture(
        "Gaps in gait, filled by low rank and sparsity",
        f"Mean distance over the gaps of a mask, n = {result.masks} masks, seed {result.seed}. "
        "In brackets: the λ used, gaps refused, and masks in which the solver stopped before its "
        "tolerance was met. As in Kamali et al. 2020, Figs. 3b and 4.",
        tuple(rows),
    )


def by_mask(cells: Sequence[Cell]) -> Any:
    """Draw the error of each mask per method, with mean and median (Fig. 4)."""
    masks = [(v, i) for i, cell in enumerate(cells) for v in cell.masks_mm if v is not None]
    means = [(cell.mean_mm, i, 0) for i, cell in enumerate(cells) if cell.mean_mm is not None]
    medians = [
        (cell.median_mm, i - 0.32, cell.median_mm, i + 0.32)
        for i, cell in enumerate(cells)
        if cell.median_mm is not None
    ]
    layers = [
        hv.Points(masks, ["error", "row"], label="mask").opts(
            size=6, line_color=INK["ink3"], fill_alpha=0.0, backend="bokeh"
        ),
        hv.Segments(medians).opts(color=INK["accent"], line_width=2.0, backend="bokeh"),
        *dots(means, INK["ink"]),
    ]
    return lying(layers, [_named(c) for c in cells], log_range([v for v, _ in masks]), "error, mm")


def _named(cell: Cell) -> str:
    said = [] if cell.weight is None else [f"λ {cell.weight:g}"]
    said += [f"{cell.refused} refused"] if cell.refused else []
    said += [f"{cell.unconverged} unconverged"] if cell.unconverged else []
    return cell.method + (f" ({', '.join(said)})" if said else "")


def by_weight(points: Sequence[Point]) -> Any:
    """Draw the mean error per method over lambda, evenly spaced as it may be 0 (Fig. 3b)."""
    weights = sorted({point.weight for point in points})
    look = styles(point.method for point in points)
    low, high = log_range([p.mean_mm for p in points] + [p.mean_mm + p.sd_mm for p in points])
    layers = []
    for method in dict.fromkeys(point.method for point in points):
        some = sorted((p for p in points if p.method == method), key=lambda p: p.weight)
        curve = [(weights.index(p.weight), p.mean_mm, 0) for p in some if np.isfinite(p.mean_mm)]
        spread = [
            (weights.index(p.weight), max(p.mean_mm - p.sd_mm, low), weights.index(p.weight),
             p.mean_mm + p.sd_mm)
            for p in some
            if np.isfinite(p.mean_mm)
        ]  # fmt: skip
        colour = look[method]["color"]
        line = hv.Curve([point[:2] for point in curve], "x", "error", label=method)
        layers += [
            hv.Segments(spread).opts(color=colour, line_width=1.2, backend="bokeh"),
            line.opts(**look[method], backend="bokeh"),
            *dots(curve, colour),
        ]
    return drawn(
        hv.Overlay(layers),
        360,
        220,
        logy=True,
        xlim=(-0.5, len(weights) - 0.5),
        ylim=(low, 1.2 * high),  # room for the legend
        xticks=[(i, f"{weight:g}") for i, weight in enumerate(weights)],
        yticks=log_ticks(low, high),
        xlabel="λ",
        ylabel="error, mm",
        show_legend=True,
        legend_position="top_left",
        legend_cols=2,
    )


def by_class(splits: Sequence[Split]) -> Any:
    """Draw the mean error per method over the number of gaps, or over their length."""
    names = list(dict.fromkeys(split.name for split in splits))
    look = styles(split.method for split in splits)
    known = [split for split in splits if split.mean_mm is not None]
    low, high = log_range([split.mean_mm for split in known if split.mean_mm is not None])
    layers = []
    for method, style in look.items():
        line = [(names.index(s.name), s.mean_mm, 0) for s in known if s.method == method]
        layers += [
            hv.Curve([point[:2] for point in line], "x", "error", label=method).opts(
                **style, backend="bokeh"
            ),
            *dots(line, style["color"]),
        ]
    return drawn(
        hv.Overlay(layers),
        480,
        220,
        logy=True,
        xlim=(-0.5, len(names) - 0.5),
        ylim=(low, high),
        xticks=list(enumerate(names)),
        yticks=log_ticks(low, high),
        xlabel="",
        ylabel="error, mm",
        show_legend=True,
        legend_position="right",
    )
