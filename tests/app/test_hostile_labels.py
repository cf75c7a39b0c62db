"""Every piece of the page shows hostile labels as text."""

from collections.abc import Callable, Iterator
from html.parser import HTMLParser
from pathlib import Path

import pytest

import markermend as mm
from markermend_app.state.desk import Desk
from markermend_app.state.intents import perform
from markermend_app.views import dialogs, header, queue, repairs, title, transport

from .conftest import Ticks, made_take, settle

LABELS = (
    "<img src=x onerror=alert(1)>", "\"'><script>alert(2)</script>", "' onclick='alert(3)' x='",
    "=cmd|' /C calc'!A0", "../../etc/passwd", "x" * 200, "</div></button><marquee>",
    "\u202egnp.exe", "&lt;img src=x&gt;",
)  # fmt: skip
MakeDesk = Callable[..., tuple[Desk, Ticks]]


class Looking(HTMLParser):
    """Collects the tags, the handlers and the text of a piece of the page."""

    def __init__(self) -> None:
        super().__init__()
        self.tags: set[str] = set()
        self.handlers: list[str] = []
        self.text = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        self.handlers += [name for name, _ in attrs if name.startswith("on")]
        self.text += " ".join(value or "" for _, value in attrs)

    def handle_data(self, data: str) -> None:
        self.text += data


@pytest.fixture
def hostile(take_path: Path, make_desk: MakeDesk) -> tuple[Desk, Ticks]:
    take = made_take()
    mm.write(mm.Take(take.positions, take.rate, (*LABELS, "*10")), take_path, overwrite=True)
    return make_desk()


def pieces(desk: Desk, ticks: Ticks) -> Iterator[str]:
    for finding in desk.findings:
        desk.select(finding)
        settle(desk, ticks)
        for view in (title, header, repairs, transport, dialogs):
            yield view.render(desk)
    for intent in ("takes", "note", "help", "export"):
        perform(desk, intent)
        settle(desk, ticks)
        yield dialogs.render(desk)
        perform(desk, "close")


def test_no_label_becomes_a_tag_or_a_handler(hostile: tuple[Desk, Ticks]) -> None:
    desk, ticks = hostile
    assert {f.marker for f in desk.findings} & set(LABELS)
    looking = Looking()
    for piece in pieces(desk, ticks):
        looking.feed(piece)
    assert not looking.tags & {"img", "script", "marquee", "iframe"}
    assert not looking.handlers
    assert "\u202e" not in looking.text


def test_rows_of_the_queue_escape_their_marker(hostile: tuple[Desk, Ticks]) -> None:
    looking = Looking()
    for label in LABELS:
        looking.feed(queue._marker(mm.Finding(label, mm.Span(0, 1), "peak")))
    assert looking.tags <= {"span", "small"}
    assert not looking.handlers
    assert LABELS[0] in looking.text
