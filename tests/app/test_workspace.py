"""What can be opened: work lists, folders, dropped files, takes opened before; and the report."""

from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path

import pytest

from markermend.errors import BadInput
from markermend_app.state.desk import Desk
from markermend_app.state.intents import perform
from markermend_app.state.places import work_list

from .conftest import Ticks, settle

MakeDesk = Callable[..., tuple[Desk, Ticks]]


def test_a_folder_is_a_work_list(take_path: Path, tmp_path: Path):
    folder = tmp_path / "day"
    folder.mkdir()
    for name in ("b.c3d", "A.c3d", "notes.pdf"):
        (folder / name).write_bytes(take_path.read_bytes())
    assert [p.name for p in work_list([folder, take_path])] == ["A.c3d", "b.c3d", take_path.name]


def test_what_can_be_opened_is_listed(make_desk: MakeDesk, take_path: Path):
    (take_path.parent / "other.c3d").write_bytes(take_path.read_bytes())
    desk, _ = make_desk()
    perform(desk, "takes")
    assert desk.dialog == "open"
    assert [p.path for p in desk.takes.given] == [take_path]
    assert [p.path.name for p in desk.takes.beside] == ["other.c3d"]
    assert [p.path for p in desk.takes.recent] == [take_path]


def test_a_dropped_file_is_kept_and_opened(make_desk: MakeDesk, take_path: Path):
    desk, ticks = make_desk()
    first = desk.opened
    desk.receive("dropped.c3d", take_path.read_bytes())
    settle(desk, ticks)
    assert desk.opened is not first
    assert desk.opened.name == "dropped.c3d"


@pytest.mark.parametrize("name", ["../../evil.c3d", "..\\evil.c3d", "/etc/evil.c3d"])
def test_a_dropped_file_stays_in_its_folder(make_desk: MakeDesk, name: str):
    desk, _ = make_desk()
    kept = desk.workspace.keep(name, b"data")
    assert kept.name == "evil.c3d"
    assert kept.parent.parent.name == "dropped"


def test_a_dropped_file_that_is_no_take_is_refused(make_desk: MakeDesk):
    desk, _ = make_desk()
    with pytest.raises(BadInput, match="no take"):
        desk.workspace.keep("holiday.mp4", b"")


class Tags(HTMLParser):
    """Collects what a page refers to and says."""

    def __init__(self) -> None:
        super().__init__()
        self.references: list[str] = []
        self.tags: list[str] = []
        self.text = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.references += [v or "" for k, v in attrs if k in ("src", "href")]

    def handle_data(self, data: str) -> None:
        self.text += data


def test_the_report_is_one_page_with_every_decision(make_desk: MakeDesk, take_path: Path):
    desk, ticks = make_desk()
    gap = next(f for f in desk.findings if f.kind == "gap")
    desk.select(gap)
    settle(desk, ticks)
    perform(desk, "note_keep", None, {"note": "<script>alert(1)</script>"})
    perform(desk, "accept")
    settle(desk, ticks)
    perform(desk, "report")
    settle(desk, ticks)
    (page,) = take_path.parent.glob("*.report.html")
    tags = Tags()
    tags.feed(page.read_text())
    assert tags.references == [], "nothing has to be fetched"
    assert "script" not in tags.tags
    assert "<script>alert(1)</script>" in tags.text, "a note is shown as it was typed"
    assert tags.tags.count("svg") == 1
    assert gap.marker in tags.text
    assert "Accepted" in tags.text
