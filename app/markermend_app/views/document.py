"""The document around the parts: its theme and title, and the clock of the transport."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import param
from panel.custom import JSComponent

from markermend_app.state.desk import Desk
from markermend_app.views.part import Intent


class Document(JSComponent):
    """Carries what no part of the page owns; it shows nothing itself."""

    theme = param.Selector(default="light", objects=["light", "dark"])
    title = param.String(default="MarkerMend")
    first_frame = param.Integer(default=1)

    _esm = Path(__file__).with_name("document.js")

    def __init__(self, desk: Desk, intent: Intent, **params: Any) -> None:
        super().__init__(theme=desk.theme, **params)
        self._desk, self._intent = desk, intent
        desk.param.watch(self._follow, ["theme", "opened"])
        self._follow()

    def _follow(self, *_: object) -> None:
        opened = self._desk.opened
        self.param.update(
            theme=self._desk.theme,
            title=f"{opened.name} – MarkerMend" if opened else "MarkerMend",
            first_frame=opened.take.first_frame if opened else 1,
        )

    def _handle_msg(self, msg: Mapping[str, Any]) -> None:
        self._intent(str(msg["do"]), msg.get("arg"), {})
