"""What an operator does all day, in a browser: filter, drag, note, two windows, without a mouse."""

from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest

from markermend.assets import demonstration

from .desk_page import DeskPage, Server, until

RAW = "raw_qualisys_walk_zero_gaps_1_1.c3d"
SERIOUS = {"serious", "critical"}


@pytest.fixture(scope="module")
def server(shared: Path, tmp_path_factory: pytest.TempPathFactory) -> Any:
    """Give one server for all of these: each test has a page of its own, and leaves its traces."""
    folder = tmp_path_factory.mktemp("work")
    path = folder / "walk.c3d"
    path.write_bytes((shared / "data" / "public" / RAW).read_bytes())
    started = Server(path, store=folder / "store.sqlite")
    yield started
    started.kill()


def count_settled(desk: DeskPage) -> int:
    return int(desk.page.locator(".header .progress b").inner_text())


def test_a_filter_never_swallows_keys(server: Server, open_page: Any):
    page = open_page(server.url)
    desk = DeskPage(page)
    n_settled = count_settled(desk)
    page.keyboard.press("/")
    page.keyboard.type("shank", delay=20)  # typed at once: none of it may reach the shortcuts
    until(
        lambda: all(
            "SHANK" in name.upper() for name in page.locator(".row .marker").all_inner_texts()
        )
    )
    assert count_settled(desk) == n_settled, "an a in the field accepts nothing"
    page.keyboard.press("Enter")
    before = desk.selected
    page.keyboard.press("j")
    until(lambda: desk.selected != before)
    page.keyboard.press("f")
    until(lambda: count_settled(desk) == n_settled + 1)


def test_dragging_an_edge_moves_it_and_undo_brings_it_back(server: Server, open_page: Any):
    page = open_page(server.url)
    desk = DeskPage(page)

    def tab() -> tuple[float, float]:
        found = page.evaluate(
            """() => { const tab = Bokeh.documents[0].get_model_by_name('ruler').center
                 .find((part) => part.name === 'tab'); return [tab.left, tab.right]; }"""
        )
        return float(found[0]), float(found[1])

    left, right = tab()
    x, y = desk.pixel_of("ruler", right)
    aim, _ = desk.pixel_of("ruler", right - 0.3 * (right - left))
    page.mouse.move(x - 1, y)
    page.mouse.down()
    page.mouse.move((x + aim) / 2, y, steps=4)
    page.mouse.move(aim, y, steps=4)
    page.mouse.up()
    until(
        lambda: (
            page.locator('[data-do="undo"]').first.get_attribute("title").startswith("Undo: Move")
        )
    )
    until(lambda: abs(tab()[1] - (right - 0.3 * (right - left))) < 0.05)
    assert tab()[0] == pytest.approx(left, abs=1e-6), "the other edge stays"
    page.keyboard.press("u")
    until(lambda: tab() == (left, right))


def test_verdicts_are_filtered_and_bones_are_chosen(server: Server, open_page: Any):
    page = open_page(server.url)
    desk = DeskPage(page)
    n_settled, first = count_settled(desk), desk.selected
    marker = page.locator('.row[aria-selected="true"] .marker').inner_text()
    page.keyboard.press("f")
    until(lambda: count_settled(desk) == n_settled + 1)
    page.locator('[data-do="filter_text"]').fill(marker)  # few enough to be all on the screen
    until(lambda: first in desk.rows(settled=True))

    # Of the settled ones only those with the verdict asked for are listed; open ones stay.
    title = page.locator(".title .facts")
    listed, at_hand = desk.rows(), title.inner_text()
    verdicts = page.locator('[data-do="filter_verdict"]')
    verdicts.select_option("accepted")
    until(lambda: first not in desk.rows(settled=True))
    verdicts.select_option("rejected")
    until(lambda: first in desk.rows(settled=True))
    assert (desk.rows(), title.inner_text()) == (listed, at_hand)
    verdicts.select_option("")
    page.locator('[data-do="filter_text"]').fill("")
    until(lambda: len(desk.rows()) > len(listed))
    page.keyboard.press("Escape")  # out of the field; a filter does not keep the keys
    page.keyboard.press("j")
    until(lambda: title.inner_text() != at_hand)

    # Bones as they were inferred, or those of the set of markers that the labels name.
    page.keyboard.press("Control+o")
    page.fill(".dialog input[name=path]", str(demonstration()))
    page.click('.dialog [data-do="open"].primary')
    switch = page.locator('[data-do="bones"]')
    switch.wait_for()
    until(lambda: page.evaluate("window.markermendScene.owner.take.labels.includes('LASI')"))
    bones = "[...window.markermendScene.owner.take.bones].join()"
    inferred = page.evaluate(bones)
    switch.click()
    page.wait_for_selector('[data-do="bones"][aria-pressed="true"]')
    until(lambda: page.evaluate(bones) not in ("", inferred))
    switch.click()
    until(lambda: page.evaluate(bones) == inferred)


def test_a_note_is_typed_without_deciding_anything(server: Server, open_page: Any):
    page = open_page(server.url)
    desk = DeskPage(page)
    n_settled = count_settled(desk)
    page.keyboard.press("n")
    page.wait_for_selector(".dialog textarea")
    page.keyboard.type("fast, far <b>off</b>")
    page.keyboard.press("Enter")
    page.wait_for_selector(".dialog", state="detached")
    assert count_settled(desk) == n_settled
    page.keyboard.press("n")
    page.wait_for_selector(".dialog textarea")
    assert page.locator(".dialog textarea").input_value() == "fast, far <b>off</b>"
    assert page.locator(".dialog b").count() == 0, "what was typed is text"


def test_two_windows_and_a_reload_in_the_middle(server: Server, open_page: Any):
    one, two = open_page(server.url), open_page(server.url)
    first, second = DeskPage(one), DeskPage(two)
    n_settled = count_settled(first)
    one.keyboard.press("f")
    until(lambda: count_settled(first) == n_settled + 1)
    two.keyboard.press("f")  # decided elsewhere already: refused in a sentence, and up to date
    until(lambda: "another window" in two.locator(".message").inner_text())
    until(lambda: count_settled(second) == n_settled + 1)
    two.reload()
    assert count_settled(DeskPage(two)) == n_settled + 1


def test_thresholds_follow_the_slider_while_it_is_moved(server: Server, open_page: Any):
    page = open_page(server.url)
    DeskPage(page)
    page.keyboard.press("t")
    slider = page.locator('[data-do="threshold_noise"]')
    slider.focus()
    n_open = page.locator(".cell-queue .head .num").inner_text()
    for _ in range(12):
        page.keyboard.press("ArrowRight")
    until(lambda: page.locator(".cell-queue .head .num").inner_text() != n_open)
    assert slider.evaluate("(it) => it.matches(':focus')"), "the slider is still held"
    assert float(slider.input_value()) == pytest.approx(1.6)


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_no_serious_fault_of_accessibility(server: Server, open_page: Any, scheme: str):
    page = open_page(server.url, color_scheme=scheme)
    DeskPage(page)
    page.evaluate(files("axe_playwright_python").joinpath("axe.min.js").read_text("utf-8"))

    def faults() -> list[str]:
        found = page.evaluate("axe.run(document, { resultTypes: ['violations'] })")
        return [
            f"{v['id']}: {v['nodes'][0]['target']} {v['nodes'][0]['failureSummary']}"
            for v in found["violations"]
            if v["impact"] in SERIOUS
        ]

    assert faults() == []
    for key in ("?", "t", "p", "n", "Control+o"):
        page.keyboard.press(key)
        page.wait_for_selector(".dialog")
        assert faults() == []
        page.keyboard.press("Escape")
        page.wait_for_timeout(150)
        page.keyboard.press("Escape")
        page.wait_for_selector(".dialog", state="detached")
