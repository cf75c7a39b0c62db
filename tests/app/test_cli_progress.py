"""A terminal shows how far long work is; nothing else hears of it, nor of short work."""

import io
from pathlib import Path

import pytest

from markermend_app.cli import common, main


class Stream(io.StringIO):
    def __init__(self, terminal: bool) -> None:
        super().__init__()
        self.terminal = terminal

    def isatty(self) -> bool:
        return self.terminal


@pytest.mark.parametrize(("terminal", "long"), [(True, True), (True, False), (False, True)])
def test_progress_of_detect(
    terminal: bool, long: bool, take_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stream = Stream(terminal)
    monkeypatch.setattr("sys.stderr", stream)
    monkeypatch.setattr(common, "_SHORT_S", 0.0 if long else 1e9)
    monkeypatch.setattr(common, "_LARGE_BYTES", 0 if long else 10**12)
    assert main(["detect", str(take_path)]) == 0
    shown = stream.getvalue()
    for words in ("Detecting: 100%", f"Reading {take_path.name}"):
        assert (words in shown) == (terminal and long), shown
