"""The main job in a real browser, on a raw recording: look, decide, undo, come back, export."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import markermend as mm
from markermend.repairing import repair
from markermend_app.style.kinds import KIND_STYLES
from markermend_app.style.tokens import TOKENS

from .desk_page import DeskPage, Server, until

RAW = "raw_qualisys_walk_zero_gaps_1_1.c3d"


def rgb(colour: str) -> tuple[int, ...]:
    return tuple(int(colour[i : i + 2], 16) for i in (1, 3, 5))


def near(found: set[Any], wanted: tuple[int, ...], off: int = 40) -> bool:
    return any(max(abs(a - b) for a, b in zip(c, wanted, strict=True)) <= off for c in found)


@pytest.fixture
def raw(shared: Path, tmp_path: Path) -> Path:
    path = tmp_path / "walk.c3d"
    path.write_bytes((shared / "data" / "public" / RAW).read_bytes())
    return path


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Any]:
    servers: list[Server] = []

    def begin(*paths: Path) -> Server:
        servers.append(Server(*paths, store=tmp_path / "store.sqlite"))
        return servers[-1]

    yield begin
    for server in servers:
        server.kill()


@pytest.mark.timeout(900)
def test_the_main_job_on_a_raw_take(raw: Path, start: Any, open_page: Any, tmp_path: Path):
    take = mm.read(raw)
    findings = {f.id: f for f in mm.detect(take)}
    server = start(raw)
    page = open_page(server.url)
    desk = DeskPage(page)

    # The queue is the library's findings, the worst first, and nothing is cut off at the side.
    shown = desk.rows()
    assert set(shown) <= set(findings)
    desk.wait_for(f"of {len(findings)} settled", ".header")
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")

    # Walk to an inner gap by keys.
    def inner(id_: str) -> bool:
        f = findings[id_]
        return f.kind == "gap" and f.span.start > 0 and f.span.stop < take.n_frames

    walked = 0
    while not (inner(desk.selected) and len(findings[desk.selected].span) > 5):
        before = desk.selected
        desk.press("j")
        until(lambda before=before: desk.selected != before)
        desk.settled()
        walked += 1
        assert walked < len(findings)
    gap = findings[desk.selected]
    gap_at = take.index(gap.marker)

    # The span is drawn where it is, in the colour of its kind.
    marks = desk.lane("lane-x", "spans")
    at = marks["id"].index(gap.id)
    assert marks["left"][at] == pytest.approx((gap.span.start - 0.5) / take.rate)
    assert marks["right"][at] == pytest.approx((gap.span.stop - 0.5) / take.rate)
    edge = desk.pixel_of("lane-x", marks["left"][at])
    colour = rgb(KIND_STYLES["gap"].light)
    column = desk.colours(edge, width=5, height=41)
    assert near(column, colour), "the edge of the span has the colour of its kind"

    # Another repair: what is drawn as chosen is what the library computes.
    first = page.locator('.repair[aria-checked="true"] .name').inner_text()
    desk.press("d")
    until(lambda: page.locator('.repair[aria-checked="true"] .name').inner_text() != first)
    page.locator('.repair[data-arg="linear"]').click()
    page.wait_for_selector('.repair[data-arg="linear"][aria-checked="true"]')
    values = repair(take, gap.marker, gap.span, "linear").values

    def chosen_is_linear() -> bool:
        drawn = desk.lane("lane-y", "chosen")
        inside = np.array(drawn["y"])[1:-1]
        return len(inside) == len(values) and np.allclose(inside, values[:, 1], atol=1e-6)

    until(chosen_is_linear)
    middle = gap.span.start + len(gap.span) // 2
    point = desk.pixel_of("lane-y", middle / take.rate, float(values[len(values) // 2, 1]))
    desk.press(".")  # the playhead stands on the middle: move it off the curve
    desk.press(".")
    until(lambda: desk.frame() == middle + 2)
    assert near(desk.colours(point, 5, 5), rgb(TOKENS["light"]["accent"])), "the repair is drawn"

    # The cursor of the curves and the 3D view are one; the marker moves in the canvas.
    assert desk.cursor() == pytest.approx((middle + 2) / take.rate, abs=1e-6)
    seen = np.flatnonzero(take.seen[gap.span.start - 30 : gap.span.stop + 30].all(axis=0))
    way = take.positions[middle + 22, seen] - take.positions[middle + 2, seen]
    fastest = seen[np.argmax(np.linalg.norm(way, axis=1))]
    desk.press("w")  # the camera stays where it is, so that all movement is the marker's
    page.wait_for_selector('[data-do="follow"][aria-pressed="false"]')
    here = desk.marker_pixel(int(fastest))
    assert (
        not near(desk.colours(here, 7, 7), rgb(TOKENS["light"]["view"]), 3)
        or len(desk.colours(here, 7, 7)) > 1
    ), "something is drawn where the marker is said to be"
    for _ in range(20):
        desk.press(".")
    until(lambda: desk.frame() >= middle + 20)
    there = desk.marker_pixel(int(fastest))
    assert np.hypot(here[0] - there[0], here[1] - there[1]) > 2

    # Play: frames are drawn and the cursor goes along.
    desk.press(" ")
    begun = desk.frame()
    until(lambda: desk.frame() != begun)
    desk.press(" ")
    until(lambda: not page.evaluate("window.markermendScene.playing"))
    assert desk.cursor() == pytest.approx(desk.frame() / take.rate, abs=1e-6)

    # Accept: one key decides and goes on.
    desk.press("a")
    until(lambda: desk.selected != gap.id)
    desk.settled()
    desk.wait_for(f"1 of {len(findings)} settled", ".header")
    rejected = desk.selected
    desk.press("f")
    until(lambda: desk.selected != rejected)
    desk.wait_for(f"2 of {len(findings)} settled", ".header")

    # Undo brings the last one back; redo settles it again.
    desk.press("u")
    desk.wait_selected(rejected)
    desk.wait_for(f"1 of {len(findings)} settled", ".header")
    desk.press("y")
    desk.wait_for(f"2 of {len(findings)} settled", ".header")

    # The server dies, another one starts: everything is there.
    server.kill()
    page.close()
    again = open_page(start(raw).url)
    desk = DeskPage(again)
    desk.wait_for(f"2 of {len(findings)} settled", ".header")
    again.reload()
    desk = DeskPage(again)
    desk.wait_for(f"2 of {len(findings)} settled", ".header")

    # Export, and compare the bytes.
    desk.press("Control+s")
    again.wait_for_selector(".dialog input[name=target]", timeout=60_000)
    desk.wait_for(f"{len(gap.span)} of", ".dialog header")
    target = tmp_path / "out.c3d"
    again.fill(".dialog input[name=target]", str(target))
    again.click("[data-do=export_write]")
    desk.wait_for("Exported and verified", ".dialog header")
    patched, original = target.read_bytes(), raw.read_bytes()
    assert len(patched) == len(original)
    differs = np.flatnonzero(np.frombuffer(patched, np.uint8) != np.frombuffer(original, np.uint8))
    assert 0 < differs.size <= len(gap.span) * 16, "three coordinates and a residual a frame"
    back = mm.read(target)
    np.testing.assert_allclose(back.positions[gap.span.frames, gap_at], values, atol=1e-2)
    decisions = json.loads(Path(f"{target}.decisions.json").read_text())
    verdicts = {f["id"]: f["decision"]["verdict"] for f in decisions["findings"]}
    assert verdicts == {gap.id: "accepted", rejected: "rejected"}
    again.close()


def test_dark_and_help(raw: Path, start: Any, open_page: Any):
    page = open_page(start(raw).url, color_scheme="dark")
    desk = DeskPage(page)
    until(lambda: page.evaluate("document.documentElement.dataset.theme") == "dark")
    corner = desk.lane_corner("lane-x")
    until(lambda: near(desk.colours(corner, 3, 3), rgb(TOKENS["dark"]["panel"]), 12))
    desk.press("?")
    page.wait_for_selector(".dialog .keys")
    before = desk.rows(settled=True)
    desk.press("a")  # a dialog is open: nothing is decided behind it
    desk.press("Escape")
    page.wait_for_selector(".dialog", state="detached")
    assert desk.rows(settled=True) == before


def test_a_file_without_a_unit_asks_for_it(shared: Path, raw: Path, start: Any, open_page: Any):
    lacking = shared / "data" / "public" / "labelled_prone_to_run_240hz.c3d"
    page = open_page(start(raw).url)
    desk = DeskPage(page)
    desk.press("Control+o")
    page.fill(".dialog input[name=path]", str(lacking))
    page.click('.dialog [data-do="open"].primary')
    page.wait_for_selector('.dialog [data-do="answer_units"]', timeout=60_000)
    page.click('.dialog [data-arg="mm"]')
    desk.wait_for(lacking.name, ".header", 120_000)
    assert desk.rows()
