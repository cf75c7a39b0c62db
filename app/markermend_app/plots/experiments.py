"""Pictures of the experiments: detection (E1), operators (E2), reconstruction (E3)."""

from collections.abc import Sequence
from typing import Any

import holoviews as hv
import numpy as np
from bokeh.palettes import interp_palette

from markermend.evaluate.classification import Cell, Classification
from markermend.evaluate.operators import Comparison
from markermend.evaluate.reconstruction import KINDS, Reconstruction, Reconstructions
from markermend.evaluate.scores import CLASSES
from markermend.model import Kind
from markermend_app.plots.picture import (
    INK,
    Panel,
    Picture,
    drawn,
    log_range,
    log_ticks,
    words,
)
from markermend_app.style.kinds import KIND_STYLES

DARK = 77.0
"""Per cent of a row from which on a cell is so dark that its numbers are white."""
MEASURES = ("human", "algorithm", "approved", "rejected", "missed")
SYMBOLS = (
    ("circle", True, "●"),
    ("circle", False, "○"),
    ("triangle", True, "▲"),
    ("triangle", False, "△"),
    ("square", True, "■"),
    ("square", False, "□"),
)
"""Marker, filled or not, and the sign for it in a text; taken in turn by detectors."""


def classification(result: Classification, source: str) -> Picture:
    """Draw E1: what is found and what is called in vain, and the confusion behind it."""
    amplitudes = sorted({cell.amplitude_mm for cell in result.cells})
    detectors = list(dict.fromkeys(cell.detector for cell in result.cells))
    signs = ", ".join(f"{SYMBOLS[i % len(SYMBOLS)][2]} {d}" for i, d in enumerate(detectors))
    rows = [
        tuple(
            Panel(
                f"{title}, {amplitude:g} mm\n{signs}",
                by_kind([c for c in result.cells if c.amplitude_mm == amplitude], measure, title),
            )
            for amplitude in amplitudes
        )
        for measure, title in (("tpr", "Sensitivity"), ("fpr", "False discovery rate"))
    ]
    for detector in detectors:
        for amplitude in amplitudes:
            cells = [
                cell
                for cell in result.cells
                if (cell.detector, cell.amplitude_mm) == (detector, amplitude)
            ]
            rows.append(
                tuple(
                    Panel(
                        f"{detector}, {amplitude:g} mm, {100 * cell.share:g} % of the time",
                        confusion(cell),
                    )
                    for cell in cells
                )
            )
    n = sorted({cell.simulations for cell in result.cells})
    return Picture(
        f"Detection of artefacts put into {source}",
        f"Means of n = {', '.join(map(str, n))} simulations per amplitude and share on "
        f"{result.n_markers} markers × {result.n_frames} frames at {result.rate:g} Hz, "
        f"seed {result.seed}. Sensitivity and false discovery rate (FPR in Eq. 33) are of "
        "samples, a sample being a marker in a frame; a point is missing where nothing was "
        "called. Confusion matrices as in Skurowski & Pawlyta, Figs. 12 and 13: rows are what "
        "was put in, columns what was found; mean number of samples, and below it the share of "
        "the row, which is the shade too.",
        tuple(rows),
    )


def by_kind(cells: Sequence[Cell], measure: str, title: str) -> Any:
    """Draw a measure in % per kind and detector over the shares, one group of shares a kind."""
    shares = sorted({cell.share for cell in cells})
    detectors = list(dict.fromkeys(cell.detector for cell in cells))
    step = len(shares) + 1
    layers = []
    for k, kind in enumerate(KINDS):
        colour = KIND_STYLES[kind].light
        for d, detector in enumerate(detectors):
            symbol, filled, _ = SYMBOLS[d % len(SYMBOLS)]
            points = sorted(
                (k * step + shares.index(cell.share), getattr(cell.classes[kind], measure))
                for cell in cells
                if cell.detector == detector and getattr(cell.classes[kind], measure) is not None
            )
            labelled = f"{kind}, {detector}"
            curve = hv.Curve(points, "place", "per cent", label=labelled)
            dots = hv.Scatter(points, "place", "per cent", label=labelled)
            layers += [
                curve.opts(
                    color=colour,
                    line_width=1.6,
                    line_dash="solid" if filled else "dashed",
                    backend="bokeh",
                ),
                dots.opts(
                    marker=symbol,
                    size=8,
                    line_color=colour,
                    line_width=1.6,
                    fill_color=colour if filled else INK["panel"],
                    backend="bokeh",
                ),
            ]
    middle = (len(shares) - 1) / 2
    names = [(k * step + middle, 109.0, KIND_STYLES[kind].title) for k, kind in enumerate(KINDS)]
    layers.append(words(names, text_font_style="bold", text_color=INK["ink"]))
    ticks = [
        (k * step + s, f"{100 * share:g}")
        for k in range(len(KINDS))
        for s, share in enumerate(shares)
    ]
    return drawn(
        hv.Overlay(layers),
        max(360, 30 * step * len(KINDS)),
        220,
        xlim=(-1, step * len(KINDS) - 1),
        ylim=(-4, 117),
        xticks=ticks,
        yticks=[0, 20, 40, 60, 80, 100],
        xlabel="share of the time, %",
        ylabel=f"{title.lower()}, %",
        grid="y",
    )


def confusion(cell: Cell) -> Any:
    """Draw an averaged confusion matrix, truth by finding, with its numbers (Figs. 12, 13)."""
    total = np.maximum(cell.matrix.sum(axis=1, keepdims=True), 1e-12)
    per_cent = 100.0 * cell.matrix / total
    entries = [
        (CLASSES[j], CLASSES[i], per_cent[i, j], cell.matrix[i, j])
        for i in range(len(CLASSES))
        for j in range(len(CLASSES))
    ]
    shades = hv.HeatMap(entries, ["found", "put in"], ["per cent", "samples"]).opts(
        cmap=interp_palette([INK["panel"], INK["ink2"]], 101),
        clim=(0, 100),
        line_color=INK["line2"],
        line_width=0.5,
        backend="bokeh",
    )
    numbers = [
        hv.Labels(
            [(x, y, text(p, n)) for x, y, p, n in entries if (p >= DARK) == dark],
            ["found", "put in"],
            "text",
        ).opts(
            text_color=INK["panel"] if dark else INK["ink"],
            text_font_size=size,
            yoffset=offset,
            backend="bokeh",
        )
        for text, size, offset in ((_samples, "12px", 0.12), (_share, "10px", -0.22))
        for dark in (False, True)
    ]
    return drawn(
        hv.Overlay([shades, *numbers]),
        290,
        240,
        xlabel="found",
        ylabel="put in",
        grid="",
        invert_yaxis=True,
    )


def _samples(_per_cent: float, samples: float) -> str:
    return f"{samples:,.0f}".replace(",", "\N{THIN SPACE}")


def _share(per_cent: float, _samples: float) -> str:
    return f"{per_cent:.1f} %"


def operators(results: Sequence[Comparison], source: str) -> Picture:
    """Draw E2: what operators leave and detectors find, per detector (Table 2)."""
    top = max(getattr(row, name) for result in results for row in result.rows for name in MEASURES)
    first = results[0]
    return Picture(
        f"Simulated operators clean {source}",
        f"Means of n = {first.simulations} simulations, seed {first.seed}. Human: errors that the "
        "operator pointed out (none: artefacts put in); algorithm: findings of the detector "
        "afterwards; approved, rejected, missed: what an expert who knows the truth says of them. "
        "As in Skurowski & Pawlyta, Table 2, with operators of known skill.",
        tuple((Panel(result.detector, verdicts(result, top)),) for result in results),
    )


def verdicts(result: Comparison, top: float) -> Any:
    """Draw the rows of Table 2 as groups of bars up to `top`, each with its number."""
    step = len(MEASURES) + 1
    bars = [
        (o * step + m, getattr(row, name))
        for o, row in enumerate(result.rows)
        for m, name in enumerate(MEASURES)
    ]
    names = [
        (o * step + (len(MEASURES) - 1) / 2, 1.17 * top, row.operator)
        for o, row in enumerate(result.rows)
    ]
    layers = hv.Overlay(
        [
            hv.Bars(bars, "place", "number").opts(
                color=INK["ink3"], line_color=None, bar_width=0.75, backend="bokeh"
            ),
            words(
                ((x, y, f"{y:.1f}") for x, y in bars), text_baseline="bottom", yoffset=0.02 * top
            ),
            words(names, text_font_style="bold", text_color=INK["ink"]),
        ]
    )
    ticks = [
        (o * step + m, name) for o in range(len(result.rows)) for m, name in enumerate(MEASURES)
    ]
    return drawn(
        layers,
        30 * step * len(result.rows),
        240,
        xlim=(-1, step * len(result.rows) - 1),
        ylim=(0, 1.25 * max(top, 1.0)),
        xticks=ticks,
        xrotation=90,
        xlabel="",
        ylabel="errors",
        grid="y",
    )


def reconstruction(result: Reconstructions, source: str) -> Picture:
    """Draw E3: what repairs leave of artefacts, one panel a share (Tables 3 to 5)."""
    shares = sorted({cell.share for cell in result.cells})
    n = sorted({cell.simulations for cell in result.cells})
    limits = log_range(
        [cell.rmse_mm for cell in result.cells] + [cell.distorted_mm for cell in result.cells], 1.8
    )
    return Picture(
        f"What repairs leave of artefacts in {source}",
        f"Root mean square error over all coordinates and frames (Eq. 38), mean and standard "
        f"deviation of n = {', '.join(map(str, n))} simulations on {result.n_markers} markers × "
        f"{result.n_frames} frames at {result.rate:g} Hz, {result.amplitude_mm:g} mm, seed "
        f"{result.seed}. ● at the true spans, ○ at those found by {result.detector}; dashed: "
        "before the repair. A whisker that reaches the frame goes on beyond it.",
        tuple(
            (
                Panel(
                    f"{100 * share:g} % of the time",
                    remaining([cell for cell in result.cells if cell.share == share], limits),
                ),
            )
            for share in shares
        ),
    )


def remaining(cells: Sequence[Reconstruction], limits: tuple[float, float]) -> Any:
    """Draw the error per kind and method with its spread, on a logarithmic axis."""
    kinds: list[Kind] = list(dict.fromkeys(cell.kind for cell in cells))
    methods = list(dict.fromkeys(cell.method for cell in cells))
    step = len(methods) + 1
    low, high = limits[0], limits[1] * 4.0
    layers = []
    for k, kind in enumerate(kinds):
        colour = KIND_STYLES[kind].light
        some = [cell for cell in cells if cell.kind == kind]
        before = some[0].distorted_mm
        layers.append(
            hv.Segments([(k * step - 0.6, before, k * step + step - 1.4, before)]).opts(
                color=INK["ink3"], line_dash="dashed", line_width=1.2, backend="bokeh"
            )
        )
        for spans, shift in (("perfect", -0.17), ("detected", 0.17)):
            points = [
                (k * step + methods.index(cell.method) + shift, cell.rmse_mm, cell.sd_mm)
                for cell in some
                if cell.spans == spans
            ]
            whiskers = [(x, max(y - sd, low), x, min(y + sd, high)) for x, y, sd in points]
            layers += [
                hv.Segments(whiskers).opts(color=colour, line_width=1.4, backend="bokeh"),
                hv.Scatter(points, "place", ["rmse", "sd"], label=f"{kind}, {spans}").opts(
                    marker="circle",
                    size=8,
                    line_color=colour,
                    line_width=1.6,
                    fill_color=colour if spans == "perfect" else INK["panel"],
                    backend="bokeh",
                ),
            ]
    middle = (len(methods) - 1) / 2
    names = [
        (k * step + middle, high / 1.7, KIND_STYLES[kind].title) for k, kind in enumerate(kinds)
    ]
    layers.append(words(names, text_font_style="bold", text_color=INK["ink"]))
    return drawn(
        hv.Overlay(layers),
        max(360, 34 * step * len(kinds)),
        260,
        logy=True,
        xlim=(-1, step * len(kinds) - 1),
        ylim=(low, high),
        yticks=log_ticks(*limits),
        xticks=[
            (k * step + m, method or "default")
            for k in range(len(kinds))
            for m, method in enumerate(methods)
        ],
        xrotation=90,
        xlabel="",
        ylabel="RMSE, mm",
        grid="y",
    )
