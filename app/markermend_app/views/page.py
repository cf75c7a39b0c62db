"""The page: every part in its place, all fed from one desk."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import panel as pn

from markermend_app.keys import in_force
from markermend_app.state.intents import perform
from markermend_app.state.second_review import Comparing
from markermend_app.style.sheet import PAGE_STYLESHEET
from markermend_app.views import (
    adjudication,
    dialogs,
    exercise,
    exercise_feedback,
    header,
    queue,
    repairs,
    title,
    transport,
)
from markermend_app.views.document import Document
from markermend_app.views.keyboard import KeyListener
from markermend_app.views.lanes import LanesView, OverviewView
from markermend_app.views.part import Part
from markermend_app.views.playheads import Playheads
from markermend_app.views.stage import Stage

TEMPLATE = Path(__file__).with_name("page.html")


class _Page(pn.Template):  # type: ignore[misc]
    """A template whose parts come into the document together.

    Bokeh looks through all models again for every part that is added, which for this page costs
    more than to make it; held back, it looks once.
    """

    def _init_doc(self, doc: Any = None, *given: Any, **options: Any) -> Any:
        if doc is None:
            return super()._init_doc(doc, *given, **options)
        with doc.models.freeze():
            return super()._init_doc(doc, *given, **options)


def build(desk: Comparing) -> pn.Template:
    """Give the page of one desk."""

    def intent(name: str, arg: Any, fields: Mapping[str, Any]) -> None:
        perform(desk, name, arg, fields)

    lanes, overview, stage = LanesView(desk, intent), OverviewView(desk), Stage(desk)
    keys = in_force()
    keyboard = KeyListener(
        keys=list(keys.actions),
        repeating=keys.repeating,
        local={k: {"event": f"markermend:{do}", "detail": {}} for k, do in keys.at_once.items()},
    )
    keyboard.on_key(lambda key: perform(desk, keys.actions[key]))
    page = _Page(TEMPLATE.read_text(encoding="utf-8"))
    page.add_variable("css", PAGE_STYLESHEET)
    parts = {
        "header": (header.render, header.SHOWS),
        "message": (header.message, ("message",)),
        "queue_head": (queue.head, queue.HEAD_SHOWS),
        "queue_foot": (queue.foot, queue.HEAD_SHOWS),
        "evidence_head": (title.evidence_head, title.EVIDENCE_SHOWS),
        "title": (title.render, title.SHOWS),
        "legend": (title.legend, title.LEGEND_SHOWS),
        "overview_head": (title.overview_head, ()),
        "views": (transport.views, transport.VIEW_SHOWS),
        "transport": (transport.render, transport.SHOWS),
        "repairs": (repairs.render, repairs.SHOWS),
        "because": (repairs.because, repairs.SHOWS),
        "verdict": (repairs.verdict, repairs.VERDICT_SHOWS),
        "dialog": (dialogs.render, dialogs.SHOWS),
        "strip": (exercise.strip, exercise.STRIP_SHOWS),
        "opinions": (adjudication.opinions, adjudication.SHOWS),
        "sheet": (exercise_feedback.sheet, exercise_feedback.SHOWS),
    }
    for name, (render, shows) in parts.items():
        page.add_panel(
            name, Part(render, desk, shows, intent, sizing_mode="stretch_width", margin=0)
        )
    page.add_panel("queue", queue.Queue(desk, intent, sizing_mode="stretch_both", margin=0))
    page.add_panel("lanes", lanes.panel)
    page.add_panel("evidence", lanes.evidence)
    page.add_panel("overview", overview.panel)
    page.add_panel("scene", stage.panel)
    page.add_panel("document", Document(desk, intent))
    page.add_panel("clock", exercise.Clock(desk, margin=0))
    page.add_panel("keyboard", keyboard)
    page.add_panel("playheads", Playheads())
    return page
