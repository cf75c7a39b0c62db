"""The table of repairs, why one is recommended, and the verdict."""

from html import escape
from math import log10

from markermend.model import short
from markermend.repairing.checks import Checks
from markermend_app.state.desk import Desk
from markermend_app.state.previews import Preview
from markermend_app.style.kinds import glyph
from markermend_app.views.markup import button, icon, kbd, number

SHOWS = ("previews", "chosen", "best", "why", "selected", "comparing", "refused_shown")
VERDICT_SHOWS = ("previews", "chosen", "repair", "selected", "review", "findings")
LOW_MM, HIGH_MM = 0.1, 300.0
"""Ends of the logarithmic scale of expected errors."""


def render(desk: Desk) -> str:
    """Give the table: one row per method that applies, the others behind one line."""
    here = [p for p in desk.previews if not p.reason]
    refused = [p for p in desk.previews if p.reason]
    rows = "".join(_row(p, desk) for p in here)
    if refused:
        word = "does" if len(refused) == 1 else "do"
        sign = icon("down" if desk.refused_shown else "right", 12)
        rows += button(
            "refused",
            f"{sign}{len(refused)} {word} not apply here",
            classes="fold",
            key=False,
            title="Show the methods that do not apply, and why",
        ).replace("<button ", f'<button aria-expanded="{str(desk.refused_shown).lower()}" ', 1)
        if desk.refused_shown:
            rows += "".join(_refused(p) for p in refused)
    switch = f"Switch {kbd('method_previous')}{kbd('method_next')}"
    busy = '<i class="hairline" role="status" aria-label="Comparing"></i>' if desk.comparing else ""
    return (
        f'<div class="repairs"><div class="head"><h2>Repairs</h2>'
        f'<span class="push tool">{switch}</span>{busy}</div>'
        '<div class="repair-columns" aria-hidden="true"><span></span><span>Method</span>'
        '<span class="wide">Expected here, mm</span><span>Edge mm</span>'
        "<span>Cluster mm</span><span>New</span><span>Time s</span></div>"
        '<div class="list" role="group" aria-label="Repairs" '
        f'data-steady="{escape(desk.selected)}">{rows}</div></div>'
    )


def _row(preview: Preview, desk: Desk) -> str:
    chosen, best = preview.name == desk.chosen, preview.name == desk.best
    star = icon("star", 13, filled=True) if best else ""
    name = f'<span class="name">{escape(preview.title)}</span>'
    if preview.repair is None:
        if preview.slow:
            again = '<span class="refused">takes long: try it</span>'
            return (
                f'<button type="button" class="repair off" {_key(preview)} data-do="try_slow" '
                f'data-arg="{escape(preview.name)}" title="{escape(preview.summary)}"'
                f"{' disabled' if desk.comparing else ''}><span></span>{name}{again}</button>"
            )
        return (
            f'<div class="repair off" {_key(preview)} title="{escape(preview.summary)}">'
            f"<span></span>{name}"
            '<span class="refused">…</span></div>'
        )
    trust, checks = preview.trust, preview.checks
    leaves = preview.name == "leave"
    waits = "–" if preview.compared or leaves else "…"
    cells = (
        number(trust.expected_mm) if trust else waits,
        _scale(trust.expected_mm, trust.nine_in_ten_mm) if trust else "",
        number(checks.step_mm) if checks else waits,
        number(checks.distance_mm) if checks else waits,
        artefacts(checks) if checks else waits,
        "–" if leaves else "&lt;0.01" if preview.seconds < 0.01 else f"{preview.seconds:.2f}",
    )
    escaped = [cell if cell.startswith(("<", "&")) else escape(cell) for cell in cells]
    values = "".join(f"<span>{cell}</span>" for cell in escaped)
    return (
        f'<button type="button" class="repair" {_key(preview)} role="radio" '
        f'aria-checked="{str(chosen).lower()}" data-do="choose" data-arg="{escape(preview.name)}" '
        f'title="{escape(_tip(preview))}">'
        f"<span>{star}</span>{name}{values}</button>"
    )


def _key(preview: Preview) -> str:
    """Give what the row is known by, wherever it comes to stand."""
    return f'data-key="{escape(preview.name)}"'


def _tip(preview: Preview) -> str:
    """Say everything that the row has no room for."""
    said = [preview.repair.note if preview.repair and preview.repair.note else preview.summary]
    if preview.trust:
        t = preview.trust
        said.append(
            f"Expected error {number(t.expected_mm)} mm, 9 in 10 under {number(t.nine_in_ten_mm)} "
            f"mm, from {t.n_pseudo_gaps} trial gaps."
        )
    if preview.checks:
        c = preview.checks
        said.append(
            f"Edges: {number(c.step_mm)} mm step and {number(c.slope_mm)} mm a frame in slope; "
            f"usual {number(c.usual_step_mm)}."
        )
        if not c.detected:
            said.append(c.unlooked)
    return " ".join(said)


def _scale(mean: float, most: float) -> str:
    """Draw the expected error: a dot, and a whisker to the 90 % value, logarithmic."""
    width = 50

    def at(value: float) -> float:
        share = log10(max(value, LOW_MM) / LOW_MM) / log10(HIGH_MM / LOW_MM)
        return 4 + (width - 8) * min(1.0, share)

    dot, end = at(mean), at(most)
    return (
        f'<svg class="scale" width="{width}" height="12" viewBox="0 0 {width} 12" '
        f'aria-hidden="true"><path d="M0 6h{width}" stroke="var(--line)"/>'
        f'<path d="M{dot:.1f} 6H{end:.1f}M{end:.1f} 3v6" stroke="currentColor" stroke-width="1.5" '
        f'fill="none"/><circle cx="{dot:.1f}" cy="6" r="3" fill="currentColor"/></svg>'
    )


def artefacts(checks: Checks) -> str:
    """Give how many artefacts the repair brings and their kinds; a dash where nobody looked."""
    found = checks.artefacts
    if not checks.detected:
        return "–"
    if not found:
        return "0"
    kinds = "".join(glyph(kind, 12) for kind in dict.fromkeys(f.kind for f in found))
    return f'<span class="new">{len(found)}{kinds}</span>'


def _refused(preview: Preview) -> str:
    reason = escape(preview.reason)
    return (
        f'<div class="repair off" {_key(preview)} title="{reason}"><span></span><span class="name">'
        f'{escape(preview.title)}</span><span class="refused">{reason}</span></div>'
    )


def verdict(desk: Desk) -> str:
    """Give the four deeds; the primary one says what it will do."""
    finding = desk.current
    chosen = next((p for p in desk.previews if p.name == desk.chosen), None)
    ready = chosen is not None and chosen.repair is not None
    title = _in_sentence(chosen.title) if chosen is not None else "a repair"
    decision = desk.judged(finding).decision if finding else None
    word = "Accept"
    if decision and decision.verdict == "accepted":
        word = "Accepted: again with"
    said = f"{word} {title}"
    if finding is not None and desk.repair is not None and desk.repair.also:
        names = " and ".join(short(m) for m in (finding.marker, *(m for m, _ in desk.repair.also)))
        said = f"Swap {names} back"
    return (
        f'<div class="verdicts" data-steady="{escape(desk.selected)}">'
        + button("accept", escape(said), classes="deed primary", disabled=not ready)
        + button("reject", "False alarm", classes="deed", disabled=finding is None)
        + button("leave", "Leave gap", classes="deed", disabled=finding is None)
        + button("defer", "Set aside", classes="deed", disabled=finding is None)
        + "</div>"
    )


def _in_sentence(title: str) -> str:
    return title if title[:2].isupper() else title[0].lower() + title[1:]


def because(desk: Desk) -> str:
    """Say in one sentence what is recommended and why."""
    chosen = next((p for p in desk.previews if p.name == desk.chosen), None)
    if chosen is None:
        return '<div class="because small-out"></div>'
    if desk.why:
        # The sentence begins with the method's title, which is set in bold.
        title, colon, rest = desk.why.partition(":")
        said = f"<b>{escape(title)}</b>{colon}{escape(rest)}" if colon else escape(desk.why)
        star = icon("star", 12, filled=True)
        return f'<div class="because small-out"><span>{star}{said}</span></div>'
    note = (chosen.repair.note if chosen.repair else "") or chosen.summary
    return (
        f'<div class="because small-out"><span><b>{escape(chosen.title)}</b>: {escape(note)}</span>'
        "</div>"
    )
