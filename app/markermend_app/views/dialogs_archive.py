"""The archive as the page to start from: worst takes first, and what fails in them."""

from html import escape

from markermend_app.plots import archive
from markermend_app.plots.archive_page import archive_body
from markermend_app.state.desk import Desk
from markermend_app.views.markup import button, closing, footer


def overview(desk: Desk) -> str:
    """Give the archive as a whole; a take in it opens at a click."""
    work = desk.workspace.archive
    if work is None:
        return ""
    opened = desk.opened.take.source if desk.opened else None

    def door(name: str, html: str) -> str:
        path = escape(str(work.path(name)), quote=True)
        if html.startswith("<rect"):
            return f'<g data-do="open" data-arg="{path}">{html}</g>'
        here = opened is not None and opened.path == work.path(name)
        return button("open", html, classes="", arg=str(work.path(name)), key=False, current=here)

    at = f"looked at {work.seen.begun.astimezone():%Y-%m-%d %H:%M}"
    if desk.workspace.reach is None:  # on a lab's server, where the archive lies is the lab's own
        at = f"{escape(str(work.seen.folder))} · {at}"
    return (
        f'<header><h1 id="dialog-title">{escape(work.seen.folder.name)}</h1>'
        f"<p>{at}</p></header>"
        f'<div class="body" tabindex="0">{archive.facts(work.seen)}'
        f"{archive_body(work.seen, door)}</div>"
        + footer(
            closing("Close"),
            button(
                "open",
                "Open the worst take",
                classes="deed primary",
                arg=str(work.paths[0]) if work.paths else "",
                key=False,
            ),
        )
    )
