"""The header: which take, how far, what can be undone."""

from html import escape

from markermend_app.state.desk import Desk
from markermend_app.state.together import Together
from markermend_app.views.markup import button, icon, kbd

SHOWS = ("opened", "review", "findings", "busy", "searching", "saved", "theme", "thresholds")
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
        subjects = len({label.rpartition(":")[0] for label in take.labels} - {""})
        several = f"{subjects} subjects · " if subjects > 1 else ""
        facts = (
            f"{several}{len(take.measured)} markers · {take.rate:g} Hz · {take.duration_s:.1f} s"
        )
    if counts.total:
        share = 100 * counts.settled / counts.total
        progress = (
            f'<span class="num"><b>{counts.settled}</b> of {counts.total} settled</span>'
            f'<span class="bar" role="progressbar" aria-valuenow="{share:.0f}" '
            f'aria-label="settled"><i style="width:{share:.1f}%"></i></span>'
        )
        left = _time_left(desk.pace_s, counts.open)
        progress += f'<span class="quiet num small-out">{left}</span>' if left else ""
    if desk.searching and not desk.busy:
        progress = (
            f'<span class="num"><b>{counts.settled}</b> of {counts.total} settled</span>'
            f'<span role="status" class="quiet">{escape(desk.searching)} …</span>'
            f'<span class="bar running" role="progressbar" aria-label="{escape(desk.searching)}">'
            f"<i></i></span>{button('cancel', 'Stop', classes='tool boxed', key=False)}"
        )
    if desk.busy:
        cancel = button("cancel", "Cancel", classes="tool boxed", key=False)
        progress = (
            f'<span role="status">{escape(desk.busy)} …</span><span class="bar running" '
            f'role="progressbar" aria-label="{escape(desk.busy)}"><i></i></span>{cancel}'
        )
    saved = ""
    if desk.saved:
        saved = (
            f'<span class="quiet num small-out saved" title="Every decision is on disk at once">'
            f"{icon('saved', 13)}Saved {escape(desk.saved)}</span>"
        )
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
            button("history", icon("down", 12), title="History of decisions", key=False),
            '<span class="rule"></span>',
            button("commands", '<span class="small-out">Commands</span>', title="Find a command"),
            button("help", '<span class="small-out">Help</span>', title="All keys"),
            button("theme", icon("theme"), title="Light or dark"),
            button("export", "Export…", classes="tool boxed", disabled=take is None),
            _leave(desk),
        )
    )  # fmt: skip
    return (
        f'<div class="header"><div><span class="brand">{MARK}MarkerMend</span>'
        + button(
            "takes",
            f'{icon("open", 14)}<span class="name">{name or "Open…"}</span>',
            title=f"Open another take: {desk.opened.name if desk.opened else ''}",
            key=False,
        )
        + f'<span class="quiet num small-out">{facts}</span></div>'
        f'<div class="progress">{progress}</div><div class="tools">{tools}</div></div>'
    )


def _leave(desk: Desk) -> str:
    """Give the way out, where there was a login."""
    if not desk.person.signed_in:
        return ""
    who = f"{desk.person.name}, {desk.person.role}"
    return f'<a class="tool" href="./logout" title="{escape(who)}">Log out</a>'


def _time_left(pace_s: float | None, n_open: int) -> str:
    if pace_s is None or not n_open:
        return "ready to export" if not n_open else ""
    minutes = pace_s * n_open / 60
    left = "under 1 min left" if minutes < 1 else f"about {minutes:.0f} min left"
    return f"{pace_s:.0f} s each · {left}" if pace_s >= 1 else left


def message(desk: Desk) -> str:
    """Give the line under the header that says what failed, until it is dismissed."""
    if not desk.message:
        return ""
    return (
        f'<div class="message" role="alert"><span>{escape(desk.message)}</span>{_ways_out(desk)}'
        f'<span class="push">{button("dismiss", "Dismiss", key=False)}{kbd("close")}</span></div>'
    )


def _ways_out(desk: Desk) -> str:
    """Give buttons for what can be done where several people are at one take."""
    if not isinstance(desk, Together):
        return ""
    ways: tuple[tuple[str, str], ...] = ()
    if desk.conflict is not None:
        ways = (
            ("settle_mine", "Keep mine"),
            ("settle_theirs", "Take theirs"),
            ("settle_both", "Keep both apart"),
        )
    elif desk.unsaved:
        ways = (("save", "Save now"),)
    elif desk.holder:
        watching = () if desk.looking_on else (("look_on", "Look on"),)
        ways = (*watching, ("take_over", "Take over"))
    return "".join(button(action, label, key=False) for action, label in ways)
