"""The desk of one visitor: made when the page is asked for, closed when it is gone."""

from collections.abc import Callable
from typing import Any

import panel as pn
from bokeh.document import Document
from tornado.ioloop import IOLoop

from markermend_app.serving.login import PERSON
from markermend_app.serving.metrics import Metrics
from markermend_app.state.intents import perform
from markermend_app.state.jobs import Schedule
from markermend_app.state.people import Person
from markermend_app.state.second_review import Comparing
from markermend_app.state.together import Together
from markermend_app.state.workspace import Workspace
from markermend_app.views.component import at_once
from markermend_app.views.page import build

Who = Callable[[str], Person | None]
Begin = Callable[[Comparing], None]


def on_the_page_of(document: Document) -> Schedule:
    """Give what has a function called on the thread of a page; threads of work use it.

    Bokeh takes a document apart before it tells that the page is gone: what comes in between has
    nobody left to be told to.
    """

    def schedule(task: Callable[[], None]) -> None:
        try:
            document.add_next_tick_callback(at_once(task))
        except (AttributeError, RuntimeError):
            if document.session_context is not None:
                raise

    return schedule


def visit(
    workspace: Workspace, who: Who | None, metrics: Metrics | None, begin: Begin | None = None
) -> Any:
    """Make the page of a new visitor and open the first take.

    Parameters
    ----------
    workspace
        Takes and store.
    who
        Gives the person of a name that was proven; None where nobody logs in.
    metrics
        Counts visitors.
    begin
        Called with the desk once the page is loaded; by default the archive is shown as a whole,
        or the first take is opened.

    Raises
    ------
    PermissionError
        If the visitor may not come in any more.
    """
    document = pn.state.curdoc
    assert document is not None
    person = None
    if who is not None:
        person = who(str(document.session_context.token_payload.get(PERSON)))
        if person is None:
            raise PermissionError("a session belongs to nobody who may come in")

    # What a thread added to the document itself while its changes are held together (`at_once`)
    # would be held with them, out of turn: it is added by the thread that holds them.
    loop, schedule = IOLoop.current(), on_the_page_of(document)
    desk = Together(workspace, lambda task: loop.add_callback(schedule, task), person)
    page = build(desk)
    if metrics is not None:
        metrics.sessions.inc()
        metrics.opened.inc()

    def leave(_: Any) -> None:
        desk.close()
        if metrics is not None:
            metrics.sessions.dec()

    document.on_session_destroyed(leave)
    if begin is not None:
        pn.state.onload(lambda: begin(desk))
    elif workspace.archive is not None:
        pn.state.onload(lambda: perform(desk, "archive"))
    elif workspace.paths:
        pn.state.onload(lambda: desk.open(workspace.paths[0]))
    return page
