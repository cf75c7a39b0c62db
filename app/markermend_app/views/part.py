"""A part of the page: HTML made by a pure function of the state, and intentions sent back."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import param

from markermend_app.style.sheet import STYLESHEET
from markermend_app.views.component import Component
from markermend_app.views.javascript import joined

Intent = Callable[[str, Any, Mapping[str, Any]], None]
"""Called with the name of the intention, its argument, and the fields of the form around it."""


class Part(Component):
    """Shows `html`; a click on an element with ``data-do`` is sent to `intent`.

    Parameters
    ----------
    render
        Pure function of the state that gives the HTML.
    state, on
        The view-model and the names of the values of it that this part shows.
    intent
        Where intentions go.
    """

    html = param.String(default="")

    _esm = joined(Path(__file__).with_name("part.js"))
    _stylesheets = [STYLESHEET]  # noqa: RUF012  (Panel's own convention)

    def __init__(
        self,
        render: Callable[[Any], str],
        state: param.Parameterized,
        on: tuple[str, ...],
        intent: Intent,
        **params: Any,
    ) -> None:
        super().__init__(html=render(state), **params)
        self._intent, self._state = intent, state

        def redraw(*_: object) -> None:
            html = render(state)
            if html != self.html:
                self.html = html

        state.param.watch(redraw, list(on))

    def _handle_msg(self, msg: Mapping[str, Any]) -> None:
        of = msg.get("of")
        if of and of != self._state.selected:
            return  # said of a finding that is no longer at hand
        self._intent(str(msg["do"]), msg.get("arg"), msg.get("fields") or {})
