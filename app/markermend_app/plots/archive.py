"""An archive as HTML: takes by damage, markers and kinds that fail, and a picture of where.

Pure functions of an `Overview`; they draw with HTML and SVG alone, so that the same pieces stand in
the application and in a page of its own that needs nothing else.
"""

from collections.abc import Callable, Mapping
from html import escape
from itertools import pairwise

import numpy as np

from markermend.batch.overview import MOST_COLUMNS, MarkerLine, Overview, Picture, Sum
from markermend.batch.records import Line
from markermend.model import KINDS, FloatArray, Kind
from markermend_app.style.kinds import KIND_STYLES, glyph

LEVELS_MM = (0.01, 0.1, 1.0, 10.0)
"""Bounds of the shades, in mm of mean error over a take."""
MOST_TAKES = 2000
MOST_MARKERS = 15
MOST_NOT_DONE = 200
WIDEST_CELL = 26
ROW = 15

Door = Callable[[str, str], str]
"""``(take, html)``: puts a way to the take around some HTML."""


def facts(seen: Overview) -> str:
    """Give the archive in one line of numbers."""
    done = seen.worst_first
    seconds = sum(line.summary["duration_s"] for line in done)
    n_findings = sum(line.summary["n_findings"] for line in done)
    parts = [
        (f"{len(done):,}", "takes"),
        (f"{seconds / 60:,.0f} min" if seconds >= 120 else f"{seconds:.0f} s", "recorded"),
        (f"{n_findings:,}", "findings"),
        (_size(sum(line.summary["damage"] for line in done)), "mm s of damage"),
    ]
    for ended in ("refused", "failed"):
        n = sum(line.ended == ended for line in seen.lines)
        if n:
            parts.append((f"{n:,}", ended))
    told = "".join(f"<div><b>{n}</b><span>{word}</span></div>" for n, word in parts)
    return f'<div class="facts-row">{told}</div>'


def kinds(seen: Overview) -> str:
    """Give the kinds with their takes, findings and damage."""
    sums = seen.kinds
    most = max((one.damage for one in sums.values()), default=0.0)
    rows = "".join(
        f"<tr><td>{glyph(kind)}</td><th scope='row'>{style.title}</th>"
        f"<td class='bar-cell'>{_bar({kind: sums[kind]}, most)}</td>"
        f"<td>{_size(sums[kind].damage)}</td><td>{sums[kind].n_findings:,}</td>"
        f"<td>{_share(sums[kind].n_takes, len(seen.worst_first))}</td></tr>"
        for kind, style in KIND_STYLES.items()
    )
    return _table(("", "Kind", "", "Damage", "Findings", "Takes"), rows, "kinds")


def markers(seen: Overview, most: int = MOST_MARKERS) -> str:
    """Give the markers that fail most, their damage by kind."""
    shown = [one for one in seen.markers[:most] if one.total.n_findings]
    largest = max((one.total.damage for one in shown), default=0.0)
    rows = "".join(_marker_row(one, largest) for one in shown)
    if not rows:
        return '<p class="quiet">No marker has a finding.</p>'
    return _table(("Marker", "", "Damage", "Findings", "Takes"), rows, "markers")


def _marker_row(one: MarkerLine, largest: float) -> str:
    return (
        f"<tr><th scope='row' title='{escape(one.marker)}'>{escape(one.marker)}</th>"
        f"<td class='bar-cell'>{_bar(one.by, largest)}</td>"
        f"<td>{_size(one.total.damage)}</td><td>{one.total.n_findings:,}</td>"
        f"<td>{_share(one.total.n_takes, one.n_takes)}</td></tr>"
    )


def takes(seen: Overview, door: Door, most: int = MOST_TAKES) -> str:
    """Give the takes by expected damage, with the marker that is worst in each."""
    shown = seen.worst_first[:most]
    largest = max((line.summary["damage"] for line in shown), default=0.0)
    rows = "".join(_take_row(n, line, largest, door) for n, line in enumerate(shown, 1))
    left = len(seen.worst_first) - len(shown)
    more = f'<p class="quiet">{left:,} takes with less damage are not listed.</p>' if left else ""
    head = ("", "Take", "", "Damage", "Findings", "Seconds", "Worst marker")
    return f'<div class="scrolls" tabindex="0">{_table(head, rows, "takes")}{more}</div>'


def _take_row(n: int, line: Line, largest: float, door: Door) -> str:
    summary = line.summary
    by: dict[Kind, Sum] = {}
    for row in summary["by"].values():
        for kind in KINDS:
            if kind in row:
                known = by.get(kind, Sum())
                by[kind] = Sum(known.n_findings, known.n_takes, known.damage + row[kind][1])
    worst = max(
        summary["by"].items(),
        key=lambda item: sum(size for _, size in item[1].values()),
        default=("", {}),
    )[0]
    name = door(line.name, f"<span>{escape(line.name)}</span>")
    return (
        f"<tr><td class='quiet'>{n}</td><th scope='row' title='{escape(line.name)}'>{name}</th>"
        f"<td class='bar-cell'>{_bar(by, largest)}</td><td>{_size(summary['damage'])}</td>"
        f"<td>{summary['n_findings']:,}</td><td>{summary['duration_s']:.1f}</td>"
        f"<td class='text'>{escape(worst)}</td></tr>"
    )


def not_done(seen: Overview, most: int = MOST_NOT_DONE) -> str:
    """Give the takes that failed or were refused, with the reason; nothing where there are none."""
    if not seen.not_done:
        return ""
    rows = "".join(
        f"<tr><th scope='row'>{escape(line.name)}</th><td class='text'>{line.ended}</td>"
        f"<td class='text'>{escape(line.reason)}</td></tr>"
        for line in seen.not_done[:most]
    )
    left = len(seen.not_done) - most
    more = f'<p class="quiet">{left:,} more are in summary.json.</p>' if left > 0 else ""
    return _table(("Take", "", "Why"), rows, "not-done") + more


def picture(seen: Overview, door: Door) -> str:
    """Draw markers by takes, shaded by the mean error that is to be expected over the take."""
    drawn = seen.picture
    n_rows, n_columns = drawn.mm.shape
    if not n_rows or not n_columns:
        return '<p class="quiet">There is nothing to draw.</p>'
    labels = "".join(f"<span>{escape(marker)}</span>" for marker in drawn.markers)
    width = f"min(100%, {WIDEST_CELL * n_columns}px)"
    doors = "".join(
        door(
            names[0],
            f'<rect class="column" x="{x}" y="0" width="1" height="{n_rows}">'
            f"<title>{escape(_told(drawn, x))}</title></rect>",
        )
        for x, names in enumerate(drawn.takes)
    )
    several = "" if len(seen.worst_first) <= MOST_COLUMNS else " (several takes a column)"
    return (
        '<div class="marker-takes">'
        f'<div class="names" style="grid-auto-rows:{ROW}px">{labels}</div>'
        f'<svg viewBox="0 0 {n_columns} {n_rows}" preserveAspectRatio="none" role="img" '
        f'aria-label="Markers by takes" style="width:{width};height:{ROW * n_rows}px">'
        f"{_cells(drawn.mm)}{doors}</svg>"
        f'<div></div><p class="quiet">{escape(_ends(drawn))}{several}</p></div>{_legend()}'
    )


def _cells(mm: FloatArray) -> str:
    known = ~np.isnan(mm)
    level = np.where(known, np.digitize(np.nan_to_num(mm), LEVELS_MM) + 1, 0)
    level[known & (mm == 0)] = 0
    parts = [f'<path class="none" d="{_squares(known & (level == 0))}"/>']
    parts += [
        f'<path class="level{n}" d="{_squares(level == n)}"/>' for n in range(1, len(LEVELS_MM) + 2)
    ]
    return "".join(parts)


def _squares(where: "np.ndarray[tuple[int, ...], np.dtype[np.bool_]]") -> str:
    return "".join(f"M{x} {y + 0.06:g}h1v.88h-1z" for y, x in np.argwhere(where).tolist())


def _told(drawn: Picture, x: int) -> str:
    """Name the takes of a column and its worst markers."""
    names = drawn.takes[x]
    title = names[0] if len(names) == 1 else f"{names[0]} and {len(names) - 1} more"
    order = np.argsort(-np.nan_to_num(drawn.mm[:, x]), kind="stable")[:3]
    worst = [
        f"{drawn.markers[i]} {_size(float(drawn.mm[i, x]))} mm" for i in order if drawn.mm[i, x] > 0
    ]
    return f"{title}: {', '.join(worst) or 'no damage'}"


def _ends(drawn: Picture) -> str:
    first, last = drawn.takes[0][0], drawn.takes[-1][-1]
    return first if first == last else f"{first}  …  {last}"


def _legend() -> str:
    bounds = [f"{bound:g}" for bound in LEVELS_MM]
    words = ["none", f"< {bounds[0]}"]
    words += [f"{a} – {b}" for a, b in pairwise(bounds)]
    words += [f"> {bounds[-1]} mm"]
    classes = ["none", *(f"level{n}" for n in range(1, len(LEVELS_MM) + 2))]
    boxes = "".join(
        f'<span><svg width="14" height="12" aria-hidden="true"><rect class="{name}" width="14" '
        f'height="12"/></svg>{escape(word)}</span>'
        for name, word in zip(classes, words, strict=True)
    )
    return (
        f'<div class="shades"><b>Expected mean error of the marker over the take</b>{boxes}'
        "<span>blank: not in the take</span></div>"
    )


def _bar(by: Mapping[Kind, Sum], largest: float) -> str:
    if largest <= 0:
        return ""
    parts = "".join(
        f'<i style="width:{100 * one.damage / largest:.2f}%;background:var(--{kind})" '
        f'title="{KIND_STYLES[kind].title}: {_size(one.damage)} mm s"></i>'
        for kind, one in by.items()
        if one.damage > 0
    )
    return f'<span class="stack">{parts}</span>'


def _share(n: int, of: int) -> str:
    return f"{n:,} <span class='quiet'>of {of:,}</span>"


def _size(value: float) -> str:
    if value >= 9.95:
        return f"{value:,.0f}"
    if value >= 0.095:
        return f"{value:.1f}"
    return f"{value:.1g}" if value > 0 else "0"


def _table(head: tuple[str, ...], rows: str, name: str) -> str:
    titles = "".join(f"<th scope='col'>{word}</th>" for word in head)
    return (
        f'<table class="archive-{name}"><thead><tr>{titles}</tr></thead>'
        f"<tbody>{rows}</tbody></table>"
    )
