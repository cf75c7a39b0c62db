"""The one listener for single keys, wherever on the page they are pressed.

A key has the name that browsers give it, letters in lower case, with ``Ctrl+`` and ``Shift+``
before it: ``a``, ``?``, ``Escape``, ``ArrowLeft``, a space, ``Ctrl+Shift+z``. Command is Ctrl on a
Mac. Signs that need Shift or AltGr on some keyboards, such as ``?`` and ``[``, go by the sign
alone.
"""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, ClassVar

import param

from markermend_app.views.component import Component

KeyCallback = Callable[[str], None]


class KeyListener(Component):
    """Sends listed keys to Python, unless they are typed into a field; Escape leaves a field.

    Parameters
    ----------
    keys
        Names of the keys that are taken; all others are left to the browser.
    repeating
        Those of them that count again while they are held down. Repeats are sent only as fast as
        they are handled, so that nothing runs on after the key is let go.
    local
        Keys that never reach Python: name of the key -> ``{"event": name, "detail": {...}}``, sent
        as an event on ``window``.
    """

    keys = param.List(default=[], item_type=str)
    repeating = param.List(default=[], item_type=str)
    local = param.Dict(default={})

    _esm: ClassVar[Path] = Path(__file__).with_name("keyboard.js")

    def __init__(self, **params: Any) -> None:
        super().__init__(**{"width": 0, "height": 0, "margin": 0} | params)
        self._on_key: list[KeyCallback] = []

    def on_key(self, callback: KeyCallback) -> None:
        """Call `callback` with the name of every key that is pressed."""
        self._on_key.append(callback)

    def _handle_msg(self, msg: Mapping[str, Any]) -> None:
        key = str(msg["key"])
        if key not in self.keys:
            return
        try:
            for callback in self._on_key:
                callback(key)
        finally:
            self._send_msg({"handled": msg["number"]})
