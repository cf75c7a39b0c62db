"""Pictures of the recovery of gaps from a training set, and what they share with other fills."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import holoviews as hv
import numpy as np
from bokeh.palettes import Colorblind

from markermend.evaluate.li_tables import Li, Row
from markermend_app.plots.picture import INK, Panel, Picture, drawn, log_range, log_ticks, words

LOST = ("#F0E442", "#0072B2")
"""Yellow is lost on white, and blue beside the accent."""
COLOURS = tuple(colour for colour in Colorblind[8] if colour not in LOST)
DASHES = ("solid", "dashed", "dotted", "dotdash")
HEIGHT = 300
LINE = 15
"""Height in px of a name beside a curve."""
Style = dict[str, Any]


def li(result: Li, source: str) -> Picture:
    """Draw the error of every method over the lengths or numbers of gaps, one panel a table."""
    groups: dict[tuple[str, int, str], list[Row]] = {}
    for row in result.rows:
        groups.setdefault((row.figure, row.dims, row.given), []).append(row)
    look = styles(row.method for rows in groups.values() if _curved(rows) for row in rows)
    panels = [
        Panel(f"{figure}, {dims}D\ngiven {given}", by_condition(rows, look))
        for (figure, dims, given), rows in groups.items()
    ]
    projected = f" Two dimensions: {result.projected}." if result.projected else ""
    return Picture(
        f"Gaps and blackouts in {source}, filled with and without learning",
        f"Mean distance over the frames of a gap (Eq. 17), mean of n = {result.pieces} pieces of "
        f"{result.piece_frames} frames at {result.rate:g} Hz, seed {result.seed}. ○ some gaps were "
        "refused, and the mean is over the others; no point: all were. As in Li et al. 2020, "
        f"Tables 1 to 3 and Figs. 3 to 11.{projected}",
        tuple((panel,) for panel in panels),
    )


def by_condition(rows: Sequence[Row], look: Mapping[str, Style]) -> Any:
    """Draw the error per method over the conditions of one table; beneath each other if it is one.

    Curves carry their names at the right, in the order of their last points.
    """
    unit = "error, mm" if rows[0].dims == 3 else "error, px"
    low, high = log_range([row.mean for row in rows if row.mean is not None])
    methods = list(dict.fromkeys(row.method for row in rows))
    if not _curved(rows):
        points = [(row.mean, i, row.refused) for i, row in enumerate(rows) if row.mean is not None]
        setting = rows[0].setting
        return lying(dots(points, INK["ink"]), methods, (low, high), f"{unit}, {setting}")
    settings = {row.x: _in_two_lines(row.setting) for row in rows}
    at = sorted(settings)
    wide = at[-1] - at[0]
    layers, ends = [], []
    for method in methods:
        points = sorted(
            (r.x, r.mean, r.refused) for r in rows if r.method == method and r.mean is not None
        )
        if not points:
            continue
        style = look[method]
        layers.append(
            hv.Curve([p[:2] for p in points], "x", "error", label=method).opts(
                **style, backend="bokeh"
            )
        )
        layers += dots(points, style["color"])
        ends.append((points[-1][1], points[-1][0], method))
    beside = at[-1] + 0.07 * wide
    names = []
    ends.sort()
    for (y, x, method), place in zip(ends, apart(ends, (low, high)), strict=True):
        style = {**look[method], "line_width": 0.8}  # told apart also where names crowd
        layers.append(hv.Segments([(x, y, beside, place)]).opts(**style, backend="bokeh"))
        names.append((beside + 0.01 * wide, place, method))
    layers.append(words(names, text_align="left"))
    return drawn(
        hv.Overlay(layers),
        720,
        HEIGHT,
        logy=True,
        xlim=(at[0] - 0.05 * wide, at[-1] + 0.3 * wide),
        ylim=(low, high),
        xticks=[(x, settings[x]) for x in at],
        yticks=log_ticks(low, high),
        xlabel="",
        ylabel=unit,
        grid="y",
    )


def _curved(rows: Sequence[Row]) -> bool:
    return len({row.x for row in rows}) > 1


def _in_two_lines(setting: str) -> str:
    first, bracket, second = setting.partition(" (")
    return f"{first}\n({second}" if bracket else "\n".join(setting.rsplit(" ", 1))


def apart(ends: Sequence[tuple[float, float, str]], limits: tuple[float, float]) -> list[float]:
    """Give places on a logarithmic axis, as near to sorted ends as names can stand."""
    bottom, top = np.log(limits)
    step = min(LINE / HEIGHT * (top - bottom), (top - bottom) / max(1, len(ends)))
    places: list[float] = []
    for value, _, _ in ends:
        places.append(max([np.log(value), *(place + step for place in places[-1:])]))
    ceiling = top - step / 2
    for i in range(len(places) - 1, -1, -1):
        places[i] = min(places[i], ceiling)
        ceiling = places[i] - step
    return [float(np.exp(place)) for place in places]


def styles(methods: Iterable[str]) -> dict[str, Style]:
    """Give every method a colour and a dash that it keeps in all panels; ``auto`` is the accent."""
    names = list(dict.fromkeys(methods))
    look: dict[str, Style] = {}
    for i, name in enumerate(name for name in names if name != "auto"):
        turn, colour = divmod(i, len(COLOURS))
        dash = DASHES[turn % len(DASHES)]
        look[name] = {"color": COLOURS[colour], "line_dash": dash, "line_width": 1.6}
    look["auto"] = {"color": INK["accent"], "line_dash": "solid", "line_width": 3.0}
    return look


def dots(points: Sequence[tuple[float, float, int]], colour: str) -> list[Any]:
    """Draw (x, y, refused) as dots, hollow where something was refused."""
    return [
        hv.Points([p[:2] for p in points if bool(p[2]) == hollow], ["x", "y"]).opts(
            size=7, line_color=colour, fill_color=INK["panel"] if hollow else colour,
            line_width=1.4, backend="bokeh",
        )
        for hollow in (False, True)
    ]  # fmt: skip


def lying(
    layers: Sequence[Any], names: Sequence[str], limits: tuple[float, float], label: str
) -> Any:
    """Lay named rows beneath each other on a logarithmic axis."""
    return drawn(
        hv.Overlay(layers),
        420,
        24 * len(names) + 16,
        logx=True,
        xlim=limits,
        ylim=(-0.8, len(names) - 0.2),
        xticks=log_ticks(*limits),
        yticks=list(enumerate(names)),
        invert_yaxis=True,
        xlabel=label,
        ylabel="",
        grid="x",
    )
