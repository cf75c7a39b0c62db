"""The document around the parts: its theme and title, and the clock of the transport."""

from base64 import b64decode
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import param

from markermend_app.state.desk import Desk
from markermend_app.views.component import Component
from markermend_app.views.part import Intent


class Document(Component):
    """Carries what no part of the page owns; it shows nothing itself."""

    theme = param.Selector(default="light", objects=["light", "dark"])
    title = param.String(default="MarkerMend")
    first_frame = param.Integer(default=1)
    adding = param.Boolean(default=False)
    most_upload = param.Integer(default=0)

    _esm = Path(__file__).with_name("document.js")

    def __init__(self, desk: Desk, intent: Intent, **params: Any) -> None:
        super().__init__(theme=desk.theme, most_upload=desk.workspace.most_upload, **params)
        self._desk, self._intent = desk, intent
        desk.param.watch(self._follow, ["theme", "opened", "adding"])
        self._file = bytearray()
        self._follow()

    def _follow(self, *_: object) -> None:
        opened = self._desk.opened
        self.param.update(
            theme=self._desk.theme,
            adding=self._desk.adding,
            title=f"{opened.name} – MarkerMend" if opened else "MarkerMend",
            first_frame=opened.take.first_frame if opened else 1,
        )

    def _handle_msg(self, msg: Mapping[str, Any]) -> None:
        if "file" in msg:
            self._receive(msg)
        else:
            self._intent(str(msg["do"]), msg.get("arg"), {})

    def _receive(self, msg: Mapping[str, Any]) -> None:
        """Put a dropped file together from its parts; of one that is too large, none are sent."""
        name, workspace = str(msg["file"]), self._desk.workspace
        if msg["first"]:
            self._file = bytearray()
        if "too_large" in msg:
            self._desk.fail(str(workspace.too_large(name, int(msg["too_large"]))))
            return
        if len(self._file) <= workspace.most_upload:  # whatever the browser was told
            self._file += b64decode(str(msg["data"]))
        if msg["last"]:
            data, self._file = bytes(self._file), bytearray()
            self._desk.receive(name, data)
