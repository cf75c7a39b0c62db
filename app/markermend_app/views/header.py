"""The header: which take, how far, what can be undone."""

from html import escape

from markermend_app.state.desk import Desk
from markermend_app.views.markup import button, icon, kbd

SHOWS = ("opened", "review", "findings", "busy", "saved", "theme")
MARK = (
    '<svg width="22" height="22" viewBox="0 0 22 22" aria-hidden="true">'
    '<path d="M2 16 6.500 6l3.500 7" fill="none" stroke="var(--ink)" stroke-width="2"/>'
    '<path d="m10 13 3.500-7L20 16" fill="none" stroke="var(--accent)" stroke-width="2" '
    'stroke-dasharray="2.500 2"/></svg>'
)


def render(desk: Desk) -> str:
    """Give the header."""
    counts = desk.review.counts(desk.findings)
    take = desk.opened.take if desk.opened else None
    facts = name = progress = ""
    if desk.opened and take:
        name = escape(desk.opened.name)
        facts = f"{len(take.measured)} markers · {take.rate:g} Hz · {take.duration_s:.1f} s"
    if counts.total:
        share = 100 * counts.settled / counts.total
        progress = (
            f'<span class="num"><b>{counts.settled}</b> of {counts.total} settled</span>'
            f'<span class="bar" role="progressbar" aria-valuenow="{share:.0f}" '
            f'aria-label="settled"><i style="width:{share:.1f}%"></i></span>'
        )
    if desk.busy:
        progress = f'<span role="status">{escape(desk.busy)} …</span>'
    saved = f'<span class="quiet num small-out">{icon("saved", 13)}</span>' if desk.saved else ""
    saved += f'<span class="quiet num small-out">Saved {escape(desk.saved)}</span>' if saved else ""
    past, future = desk.steps
    undo_title = f"Undo: {past[-1]}" if past else "Nothing to undo"
    redo_title = f"Redo: {future[0]}" if future else "Nothing to redo"
    tools = "".join(
        (
            saved,
            button("undo", icon("undo") + '<span class="small-out">Undo</span>',
                   title=undo_title, disabled=not past),
            button("redo", icon("redo") + '<span class="small-out">Redo</span>',
                   title=redo_title, disabled=not future),
            button("help", "Help"),
            button("theme", icon("theme"), title="Light or dark"),
            button("export", "Export…", classes="tool boxed", disabled=take is None),
        )
    )  # fmt: skip
    return (
        f'<div class="header"><div><span class="brand">{MARK}MarkerMend</span>'
        f'<span class="name" title="{name}">{name}</span>'
        f'<span class="quiet num small-out">{facts}</span></div>'
        f'<div class="progress">{progress}</div><div class="tools">{tools}</div></div>'
    )


def message(desk: Desk) -> str:
    """Give the line under the header that says what failed, until it is dismissed."""
    if not desk.message:
        return ""
    return (
        f'<div class="message" role="alert"><span>{escape(desk.message)}</span>'
        f'<span class="push">{button("dismiss", "Dismiss", key=False)}{kbd("close")}</span></div>'
    )
