"""The table of repairs, why one is recommended, and the verdict."""

from html import escape

from markermend_app.state.desk import Desk
from markermend_app.state.previews import Preview
from markermend_app.views.markup import button, icon, kbd, number

SHOWS = ("previews", "chosen", "selected")
VERDICT_SHOWS = ("previews", "chosen", "selected", "review", "findings")


def render(desk: Desk) -> str:
    """Give the table: one row per method, the ones that do not apply greyed with their reason."""
    rows = "".join(_row(p, p.name == desk.chosen, p.name == desk.best) for p in desk.previews)
    switch = f"Switch {kbd('method_previous')}{kbd('method_next')}"
    return (
        f'<div class="repairs"><div class="head"><h2>Repairs</h2>'
        f'<span class="push tool">{switch}</span></div>'
        '<div class="repair-columns"><span></span><span>Method</span><span>Expected mm</span>'
        "<span>Change mm</span><span>Band mm</span><span>Time s</span></div>"
        f'<div class="list" role="radiogroup" aria-label="Repairs">{rows}</div></div>'
    )


def _row(preview: Preview, chosen: bool, best: bool) -> str:
    star = icon("star", 13, filled=True) if best else ""
    name = f'<span class="name">{escape(preview.title)}</span>'
    repair = preview.repair
    if repair is None:
        reason = escape(preview.reason) or "…"
        return (
            f'<div class="repair off" title="{reason}"><span></span>{name}'
            f'<span class="refused">{reason}</span></div>'
        )
    band = None if repair.band is None else float(repair.band.max())
    cells = (
        number(repair.expected_mm),
        number(preview.change_mm),
        number(band),
        "<0.01" if preview.seconds < 0.01 else f"{preview.seconds:.2f}",
    )
    values = "".join(f"<span>{escape(cell)}</span>" for cell in cells)
    return (
        f'<button type="button" class="repair" role="radio" aria-checked="{str(chosen).lower()}" '
        f'data-do="choose" data-arg="{escape(preview.name)}" title="{escape(repair.note)}">'
        f"<span>{star}</span>{name}{values}</button>"
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
    return (
        '<div class="verdicts">'
        + button("accept", f"{word} {escape(title)}", classes="deed primary", disabled=not ready)
        + button("reject", "False alarm", classes="deed", disabled=finding is None)
        + button("leave", "Leave gap", classes="deed", disabled=finding is None)
        + button("defer", "Set aside", classes="deed", disabled=finding is None)
        + "</div>"
    )


def _in_sentence(title: str) -> str:
    return title if title[:2].isupper() else title[0].lower() + title[1:]


def because(desk: Desk) -> str:
    """Say in one sentence what stands behind the chosen repair."""
    chosen = next((p for p in desk.previews if p.name == desk.chosen), None)
    if chosen is None or chosen.repair is None:
        return '<div class="because small-out"></div>'
    note = chosen.repair.note or chosen.summary
    return f'<div class="because small-out"><b>{escape(chosen.title)}</b>: {escape(note)}</div>'
