"""Pictures of how well markers can be predicted: correlation, residuals, sweeps, replicas."""

from collections.abc import Iterator, Sequence
from typing import Any

import holoviews as hv
import numpy as np
from bokeh.palettes import interp_palette

from markermend.evaluate.prediction_tables import (
    Correlation,
    Lagged,
    Predictors,
    RegressorScore,
    ReplicaResidual,
    ResidualFit,
    SweepPoint,
)
from markermend_app.plots.picture import INK, Panel, Picture, drawn, log_range, log_ticks

DASHES = ("solid", "dashed", "dotted", "dotdash")
A_ROW = 4
"""Histograms beside each other: two markers, each without and with its own past."""
CELL = 13
"""Edge in px of one pair of markers."""


def predictors(result: Predictors, source: str) -> Picture:
    """Draw the tables that were made."""
    return Picture(
        f"Prediction of markers in {source}",
        f"n = {len(result.markers)} markers ({', '.join(result.markers)}; the correlation is of "
        f"all) × {result.n_frames} frames at {result.rate:g} Hz, seed {result.seed}. As in "
        "Skurowski & Pawlyta, Figs. 3, 6, 7 and 9. Held out: contiguous folds with a pause beside "
        "them that is not learnt from.",
        tuple(_rows(result)),
    )


def _rows(result: Predictors) -> Iterator[tuple[Panel, ...]]:
    if result.correlation is not None:
        matrix = Panel(
            "Correlation of x, markers in the order of the body", correlation(result.correlation)
        )
        curves = Panel("Correlation of x over lags", lagged(result.correlation, result.rate))
        yield matrix, curves
    fits = [
        Panel(
            f"{fit.marker}, {fit.variant}\nσ = {fit.sigma:.3g} mm, b = {fit.b:.3g} mm", laplace(fit)
        )
        for fit in result.residuals
    ]
    for start in range(0, len(fits), A_ROW):
        yield tuple(fits[start : start + A_ROW])
    if result.sweep:
        orders = [point for point in result.sweep if point.parameter == "order"]
        contexts = [point for point in result.sweep if point.parameter == "context"]
        yield (
            Panel(
                f"Order L at context k = {orders[0].context}\n● learnt, ○ held out", sweep(orders)
            ),
            Panel(
                f"Context k at order L = {contexts[0].order}\n● learnt, ○ held out", sweep(contexts)
            ),
        )
    if result.replicas:
        yield (
            Panel(
                "Residual of the network\n○ each replica, ● mean of all", replicas(result.replicas)
            ),
        )
    if result.regressors:
        yield (
            Panel(
                "Residual of each regressor\n● learnt, ○ held out", regressors(result.regressors)
            ),
            Panel(
                "Share of an artefact that the residual shows\n1: all of it",
                shown(result.regressors),
            ),
        )


def correlation(table: Correlation) -> Any:
    """Draw the correlation of all pairs of markers, from -1 (ink) to 1 (accent) (Fig. 3a)."""
    names = _short(table.labels)
    entries = [
        (names[j], names[i], value)
        for i, row in enumerate(table.matrix)
        for j, value in enumerate(row)
    ]
    size = max(300, CELL * len(names))
    return drawn(
        hv.HeatMap(entries, ["marker", "with"], "correlation"),
        size,
        size,
        grid="",
        cmap=interp_palette([INK["ink"], INK["panel"], INK["accent"]], 201),
        clim=(-1, 1),
        colorbar=True,
        colorbar_opts={"width": 12},
        clabel="",
        invert_yaxis=True,
        xrotation=90,
        xlabel="",
        ylabel="",
    )


def lagged(table: Correlation, rate: float) -> Any:
    """Draw the correlation of a marker with itself and with others over lags in s (Fig. 3b)."""
    curves = [_lag_curve(one, rate, dash) for one, dash in zip(table.lagged, DASHES, strict=False)]
    return drawn(
        hv.Overlay(curves),
        420,
        300,
        ylim=(-1.05, 1.05),
        xlabel="lag, s",
        ylabel="correlation",
        show_legend=True,
        legend_position="bottom",
    )


def _lag_curve(one: Lagged, rate: float, dash: str) -> Any:
    own = one.relation == "itself"
    label = one.first if own else f"{one.second} ({one.relation})"
    points = [(lag / rate, value) for lag, value in zip(one.lags, one.values, strict=True)]
    return hv.Curve(points, "lag", "correlation", label=label).opts(
        color=INK["line2"] if own else INK["ink"],  # others lie on it and have to be seen
        line_dash=dash,
        line_width=4 if own else 1.6,
        backend="bokeh",
    )


def laplace(fit: ResidualFit) -> Any:
    """Draw the histogram of a residual, and the Laplace density of its spread (Fig. 6, Eq. 5)."""
    edges = np.array(fit.edges)
    middle = 0.5 * (edges[1:] + edges[:-1])
    layers = hv.Overlay(
        [
            hv.Histogram((edges, np.array(fit.density)), kdims="residual", vdims="density").opts(
                fill_color=INK["line2"], line_color=INK["panel"], line_width=0.5, backend="bokeh"
            ),
            hv.Curve((middle, np.array(fit.laplace)), "residual", "density").opts(
                color=INK["accent"], line_width=1.8, backend="bokeh"
            ),
        ]
    )
    return drawn(
        layers,
        225,
        150,
        grid="y",
        xlim=(edges[0], edges[-1]),
        ylim=(0, 1.08 * max(*fit.density, *fit.laplace)),
        xlabel="residual, mm",
        ylabel="density, 1/mm",
        xticks=5,
        yticks=4,
    )


def sweep(points: Sequence[SweepPoint]) -> Any:
    """Draw the residual over orders or contexts, learnt and held out (Fig. 7)."""
    name = points[0].parameter
    at = [getattr(point, name) for point in points]
    low, high = log_range([p.learnt_mm for p in points] + [p.held_out_mm for p in points])
    layers = []
    for which, filled in (("learnt_mm", True), ("held_out_mm", False)):
        curve = [
            (x, getattr(p, which))
            for x, p in zip(at, points, strict=True)
            if np.isfinite(getattr(p, which))
        ]
        layers += [
            hv.Curve(curve, name, "residual", label=which).opts(
                color=INK["ink"],
                line_dash="solid" if filled else "dashed",
                line_width=1.6,
                backend="bokeh",
            ),
            _dots(curve, name, filled=filled),
        ]
    return drawn(
        hv.Overlay(layers),
        360,
        220,
        logy=True,
        xlim=(min(at) - 0.5, max(at) + 0.5),
        ylim=(low, high),
        xticks=at,
        yticks=log_ticks(low, high),
        xlabel="order L" if name == "order" else "context k, frames",
        ylabel="residual, mm",
    )


def replicas(table: Sequence[ReplicaResidual]) -> Any:
    """Draw the residual of each replica of the network's output, and of their mean (Fig. 9)."""
    each = [(i, value) for i, one in enumerate(table) for value in one.replicas]
    means = [(i, one.mean) for i, one in enumerate(table)]
    return drawn(
        hv.Overlay([_dots(each, "marker", filled=False), _dots(means, "marker", filled=True)]),
        max(300, 60 * len(table)),
        220,
        grid="y",
        xlim=(-0.6, len(table) - 0.4),
        ylim=(0, 1.1 * max(value for _, value in each + means)),
        xticks=list(enumerate(_short([one.marker for one in table]))),
        xlabel="",
        ylabel="standard deviation, mm",
    )


def regressors(table: Sequence[RegressorScore]) -> Any:
    """Draw the residual of each regressor, learnt and held out."""
    learnt = [(one.learnt_mm, i) for i, one in enumerate(table) if np.isfinite(one.learnt_mm)]
    held_out = [(one.held_out_mm, i) for i, one in enumerate(table) if np.isfinite(one.held_out_mm)]
    low, high = log_range([value for value, _ in learnt + held_out])
    layers = [_points(learnt, filled=True), _points(held_out, filled=False)]
    return _lying(
        layers,
        [one.name for one in table],
        logx=True,
        xlim=(low, high),
        xticks=log_ticks(low, high),
        xlabel="residual, mm",
    )


def shown(table: Sequence[RegressorScore]) -> Any:
    """Draw how much of an artefact each regressor leaves in its residual."""
    points = [(one.shown, i) for i, one in enumerate(table) if np.isfinite(one.shown)]
    values = [value for value, _ in points]
    layers = [
        hv.VLine(1.0).opts(color=INK["ink3"], line_dash="dashed", line_width=1.2, backend="bokeh"),
        _points(points, filled=True),
    ]
    return _lying(
        layers,
        [one.name for one in table],
        xlim=(min([0.0, *values]) - 0.05, max([1.0, *values]) + 0.05),
        xlabel="share",
    )


def _lying(layers: Sequence[Any], names: Sequence[str], **options: Any) -> Any:
    return drawn(
        hv.Overlay(layers),
        360,
        24 * len(names) + 16,
        grid="x",
        ylim=(-0.8, len(names) - 0.2),
        yticks=list(enumerate(names)),
        ylabel="",
        invert_yaxis=True,
        **options,
    )


def _dots(points: Sequence[tuple[float, float]], name: str, *, filled: bool) -> Any:
    return hv.Scatter(points, name, "residual").opts(**_ring(filled), backend="bokeh")


def _points(points: Sequence[tuple[float, int]], *, filled: bool) -> Any:
    return hv.Points(points, ["value", "row"]).opts(**_ring(filled), backend="bokeh")


def _ring(filled: bool) -> dict[str, Any]:
    fill = INK["ink"] if filled else INK["panel"]
    return {"size": 7, "line_color": INK["ink"], "line_width": 1.4, "fill_color": fill}


def _short(labels: Sequence[str]) -> list[str]:
    """Leave out the subject where all labels have the same."""
    subjects = {label.rpartition(":")[0] for label in labels}
    return [label.rpartition(":")[2] if len(subjects) == 1 else label for label in labels]
