"""The overview of an archive: on a page of its own, and as the page to start from."""

from collections.abc import Iterator
from datetime import UTC, datetime
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest

import markermend as mm
from markermend.batch import records
from markermend.batch.overview import Overview
from markermend.batch.records import Line
from markermend.batch.settings import Settings
from markermend.batch.work import Task, work
from markermend.review.store import Store
from markermend_app.plots import archive as pictures
from markermend_app.plots.archive_page import archive_page
from markermend_app.state.archive import Archive, find_archive
from markermend_app.state.desk import Desk
from markermend_app.state.intents import perform
from markermend_app.state.reach import Reach
from markermend_app.state.workspace import Workspace
from markermend_app.views import dialogs, dialogs_takes

from .conftest import Ticks, made_take, settle

HOSTILE = "<img src=x onerror=alert(1)>.c3d"


def line(name: str, damage: float, marker: str = "A") -> Line:
    by = {marker: {"gap": [1, damage], "peak": [2, 0.0]}} if damage else {}
    summary = {
        "duration_s": 10.0,
        "markers": list(dict.fromkeys(("A", "B", marker))),
        "n_findings": 3 if damage else 0,
        "damage": damage,
        "by": by,
    }
    return Line(name, "done", "", summary)


def seen(*lines: Line) -> Overview:
    return Overview(
        Path("/labs/archive"), lines, {"detector": "likelihood"}, datetime(2026, 1, 1, tzinfo=UTC)
    )


class Seen(HTMLParser):
    """Collects what a page is made of."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, Any]]] = []
        self.text = ""
        self.feed(html)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))

    def handle_data(self, data: str) -> None:
        self.text += f"{data}\n"

    def all(self, tag: str) -> list[dict[str, Any]]:
        return [attributes for name, attributes in self.tags if name == tag]


def as_it_is(_: str, html: str) -> str:
    return html


def test_takes_stand_worst_first_and_those_not_done_below():
    page = archive_page(
        seen(line("calm.c3d", 0.0), line("bad.c3d", 30.0), Line("x.c3d", "failed", "it died", {}))
    )
    places = [page.index(name) for name in ("bad.c3d</span>", "calm.c3d</span>", "it died")]
    assert places == sorted(places)


def test_names_and_labels_are_shown_and_never_done():
    reason = "<script>alert(2)</script>"
    page = Seen(
        archive_page(
            seen(line(HOSTILE, 1.0, "<b>M</b>"), Line("y", "refused", reason, {}), line("z", 0.0))
        )
    )
    assert not page.all("img")
    assert not page.all("script")
    for text in (HOSTILE, "<b>M</b>", reason):
        assert text in page.text


def test_the_picture_has_a_column_a_take_and_a_row_a_marker():
    drawn = Seen(
        pictures.picture(seen(line("1", 50.0), line("2", 0.0), line("3", 0.005)), as_it_is)
    )
    (svg, *_) = drawn.all("svg")
    assert svg["viewbox"] == "0 0 3 2"
    columns = [one for one in drawn.all("rect") if one["class"] == "column"]
    assert [one["x"] for one in columns] == ["0", "1", "2"]
    cells = {one["class"]: one["d"] for one in drawn.all("path")}
    # 50 mm s over 10 s are 5 mm in the first take; 0.5 um in the third; all else is calm.
    assert {name: d.count("M") for name, d in cells.items()} == {
        "none": 4, "level1": 1, "level2": 0, "level3": 0, "level4": 1, "level5": 0,
    }  # fmt: skip
    assert cells["level4"].startswith("M0 0.06")
    assert cells["level1"].startswith("M2 0.06")
    assert "1: A 5.0 mm\n" in drawn.text


def test_long_lists_end_and_say_so():
    html = pictures.takes(seen(*(line(f"{n}", 1.0) for n in range(5))), as_it_is, most=3)
    assert html.count("<tr>") == 1 + 3
    assert "2 takes with less damage are not listed" in html


@pytest.fixture
def archive(tmp_path: Path) -> Iterator[tuple[Store, Path]]:
    """Two takes as a batch leaves them in the store, the second the worse one, and one gone."""
    folder = tmp_path / "archive"
    (folder / "sub").mkdir(parents=True)
    take = made_take()
    calm = take.positions.copy()
    calm[200:240, 2] = calm[199, 2]
    mm.write(take.with_positions(calm), folder / "calm.npz")
    mm.write(take, folder / "sub" / "worse.npz")
    settings = Settings(kinds=("gap",), units="m")
    with Store(tmp_path / "store.sqlite") as store:
        number = records.begin(store, folder, settings)
        for name in ("calm.npz", "sub/worse.npz", "gone.npz"):
            path = folder / name.replace("gone", "calm")
            result = work(Task(path, name, settings))
            assert result.ended == "done", result
            records.keep(store, number, settings.key, result)
        yield store, folder


def test_a_folder_that_a_batch_looked_at_is_a_work_list(archive: tuple[Store, Path]):
    store, folder = archive
    found = find_archive(store, [folder])
    assert found is not None
    assert found.paths == (folder / "sub" / "worse.npz", folder / "calm.npz")
    assert (found.units, found.rate) == ("m", None)
    assert find_archive(store, [folder / "sub"]) is None
    assert find_archive(store, [folder, folder]) is None


def test_the_archive_opens_as_a_dialog_and_a_take_in_it_by_a_click(archive: tuple[Store, Path]):
    store, folder = archive
    found = find_archive(store, [folder])
    assert isinstance(found, Archive)
    ticks = Ticks()
    workspace = Workspace(store, found.paths, methods=("linear",), ahead=0, archive=found)
    desk = Desk(workspace, ticks)
    try:
        perform(desk, "archive")
        assert str(folder) in Seen(dialogs.render(desk)).text
        workspace.reach = Reach(folder)  # as on a lab's server
        assert str(folder) not in Seen(dialogs.render(desk)).text
        workspace.reach = None
        buttons = Seen(dialogs.render(desk)).all("button")
        paths = [one["data-arg"] for one in buttons if one.get("data-do") == "open"]
        worst = str(folder / "sub" / "worse.npz")
        assert paths[:2] == [worst, str(folder / "calm.npz")]
        assert paths[-1] == worst
        perform(desk, "open", paths[0])
        settle(desk, ticks)
        assert desk.opened is not None
        assert desk.opened.name == "worse.npz"
        assert desk.dialog == ""
        desk.show_takes()
        assert 'data-do="archive"' in dialogs_takes.choose(desk)
    finally:
        desk.close()


def test_without_a_batch_there_is_no_overview(tmp_path: Path):
    with Store(tmp_path / "store.sqlite") as store:
        desk = Desk(Workspace(store, (), methods=("linear",), ahead=0), Ticks())
        try:
            perform(desk, "archive")
            assert desk.dialog == ""
            assert "markermend batch" in desk.message
        finally:
            desk.close()
