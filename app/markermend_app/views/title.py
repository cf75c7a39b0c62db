"""The title of the finding at hand, and the legend of the lanes."""

from html import escape

from markermend.model import short
from markermend.review.explain import why
from markermend_app.state.curves import is_relative
from markermend_app.state.desk import SIGNALS, Desk
from markermend_app.state.evidence import TITLES
from markermend_app.style.kinds import KIND_STYLES, glyph
from markermend_app.views.markup import button, icon, kbd, number

SHOWS = ("opened", "review", "selected", "findings", "marker")
EVIDENCE_SHOWS = ("opened", "selected", "marker", "signal")
SIGNAL_WORDS = {
    "residual": "Residual", "speed": "Speed", "acceleration": "Accel.", "distance": "Distance",
}  # fmt: skip
LEGEND_SHOWS = (
    "opened", "previews", "chosen", "raw_only", "zoom", "selected", "relative", "signal", "window",
    "review",
)  # fmt: skip


def render(desk: Desk) -> str:
    """Give the title: what it is, where, how large, and why."""
    if desk.current is None or desk.opened is None:
        name = escape(short(desk.marker)) or "&nbsp;"
        said = "No finding at hand; I and O add one." if desk.marker else ""
        return (
            f'<div class="title"><div class="what"><h1>{name}</h1></div>'
            f'<p class="why">{said}</p></div>'
        )
    finding = desk.judged(desk.current).as_judged
    take, span = desk.opened.take, finding.span
    facts = [
        f"{span.start / take.rate:.2f}–{span.stop / take.rate:.2f} s",
        f"{len(span)} frames" if len(span) > 1 else "1 frame",
    ]
    if finding.amplitude is not None:
        facts.append(f"{number(finding.amplitude)} {take.units}")
        facts.append(", ".join(finding.axes))
    classes = "".join(
        button(
            f"kind_{kind}",
            glyph(kind) + (f"<span>{style.title}</span>" if kind == finding.kind else ""),
            classes="",
            pressed=kind == finding.kind,
            title=f"It is {style.title.lower()}",
        )
        for kind, style in KIND_STYLES.items()
    )
    sentence = escape(why(take, desk.opened.mesh, finding))
    return (
        f'<div class="title"><div class="what"><h1>{glyph(finding.kind, 20)}'
        f"{escape(short(finding.marker))} <span>{finding.kind}</span></h1>"
        f'<span class="facts num">{" · ".join(facts)}'
        f'<span class="small-out"> · score {finding.score:.2f}</span></span></div>'
        f'<div class="choice" role="group" aria-label="Kind">{classes}</div>'
        f'<p class="why" title="{sentence}">{sentence}</p>'
        f'<div class="tools">{_tools(desk)}</div></div>'
    )


def _tools(desk: Desk) -> str:
    """Give what else can be done with the finding at hand."""
    assert desk.current is not None
    judged = desk.judged(desk.current)
    note = judged.decision.note
    parts = []
    if judged.decision.verdict:
        parts.append(button("reopen", "Reopen", title="Take the verdict back and stay"))
    if judged.added:
        parts.append(button("remove", "Remove", title="Remove this span, which was added by hand"))
    parts.append(button("similar", "Similar", title="Decide similar findings together"))
    parts.append(
        button(
            "note",
            icon("note", 13) + ("Note" if not note else "Read note"),
            title=note or "Leave a note",
        )
    )
    return "".join(parts)


def legend(desk: Desk) -> str:
    """Give the legend of the lanes and their switches."""
    if desk.current is None:
        return '<div class="legend"></div>'
    kind = desk.judged(desk.current).kind
    relative = is_relative(desk)
    chosen = next((p.title for p in desk.previews if p.name == desk.chosen), "")

    def stroke(style: str) -> str:
        return (
            '<svg width="26" height="8" viewBox="0 0 26 8" aria-hidden="true">'
            f'<path d="M1 4h24" {style}/></svg>'
        )

    raw = stroke(f'stroke="var(--{kind})" stroke-width="2"')
    line = stroke('stroke="var(--accent)" stroke-width="2.5"')
    dashed = stroke('stroke="var(--ink3)" stroke-width="1.1" stroke-dasharray="5 4"')
    on = "tool on" if desk.raw_only else "tool"
    raw_only = button("raw_only", "Raw only", pressed=desk.raw_only, classes=on)
    zoom = button("zoom", f"Zoom: {escape(desk.zoom)}")
    position = (
        '<span class="choice" role="group" aria-label="Lanes">'
        + button("relative", "Position", classes="", pressed=not relative, key=False)
        + button("relative", "Relative", classes="", pressed=relative,
                 title="Without the neighbours’ motion")
        + "</span>"
    )  # fmt: skip
    others = f'<span class="small-out">{dashed}Other repairs</span>'
    partner = desk.current.partner
    if partner is not None:
        other = stroke('stroke="var(--ink3)" stroke-width="1.2"')
        others = f"<span>{other}{escape(short(partner))}</span>"
    return (
        f'<div class="legend"><span>{raw}Recorded</span>'
        f"<span>{line}<b>{escape(chosen)}</b></span>{others}"
        f'<span class="push">{position}{raw_only}{zoom}</span></div>'
    )


def evidence_head(desk: Desk) -> str:
    """Give the head of the evidence lane: what it shows, and the switch."""
    if desk.opened is None or not desk.marker:
        return '<div class="evidence-head"></div>'
    finding = desk.current
    own = finding.evidence if finding is not None and desk.signal == "residual" else None
    title = TITLES[desk.signal] if own is None else own.name[:1].upper() + own.name[1:]
    choices = "".join(
        button(
            "signal",
            SIGNAL_WORDS[name] + (kbd("signal_next") if name == SIGNALS[-1] else ""),
            classes="",
            arg=name,
            pressed=name == desk.signal,
            title=TITLES[name],
            key=False,
        )
        for name in SIGNALS
    )
    return (
        f'<div class="evidence-head"><b>{escape(title)}</b>'
        f'<span class="choice push" role="group" aria-label="Evidence">{choices}</span></div>'
    )


def overview_head(desk: Desk) -> str:
    """Give the legend of the overview."""
    del desk
    kinds = "".join(f"<span>{glyph(k)}{s.title}</span>" for k, s in KIND_STYLES.items())
    return (
        '<div class="overview-head"><b>All markers</b><span class="small-out">shade: speed</span>'
        f'<span class="push"></span>{kinds}<span>'
        '<svg width="14" height="9" viewBox="0 0 14 9" aria-hidden="true"><rect x="1" y="1" '
        'width="12" height="7" fill="none" stroke="currentColor"/></svg>Settled</span></div>'
    )
