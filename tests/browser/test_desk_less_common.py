"""What an operator does now and then, in a browser: drop a file, sweep, walk the history."""

from base64 import b64encode
from pathlib import Path
from typing import Any

import pytest

from .desk_page import DeskPage, Server, until

RAW = "raw_qualisys_walk_zero_gaps_1_1.c3d"
DROP = """([name, text]) => {
  const bytes = Uint8Array.from(atob(text), (sign) => sign.charCodeAt(0));
  const dataTransfer = new DataTransfer();
  dataTransfer.items.add(new File([bytes], name));
  const events = ["dragover", "drop"].map(
    (type) => new DragEvent(type, { dataTransfer, bubbles: true, cancelable: true }));
  for (const event of events) document.body.dispatchEvent(event);
  return events.map((event) => event.defaultPrevented);
}"""


@pytest.fixture
def server(shared: Path, tmp_path: Path) -> Any:
    path = tmp_path / "walk.c3d"
    path.write_bytes((shared / "data" / "public" / RAW).read_bytes())
    started = Server(path, store=tmp_path / "store.sqlite")
    yield started
    started.kill()


def test_sweep_history_and_a_dropped_file_without_motion(
    server: Server, open_page: Any, shared: Path
):
    page = open_page(server.url, reduced_motion="reduce")
    desk = DeskPage(page)

    # With reduced motion nothing is animated.
    moving = page.evaluate(
        """() => document.getAnimations().filter((a) => a.playState === "running").length"""
    )
    assert moving == 0
    bar = page.locator(".header .bar i")
    assert bar.evaluate("(it) => getComputedStyle(it).transitionDuration") == "0s"

    # A span that was missed is swept out over a lane.
    before = set(desk.rows())
    page.locator('[data-do="adding"]').click()
    page.wait_for_selector('[data-do="adding"][aria-pressed="true"]')
    start, stop = page.evaluate(
        "() => { const r = Bokeh.documents[0].get_model_by_name('lane-x').x_range;"
        " const w = r.end - r.start; return [r.start + 0.05 * w, r.start + 0.15 * w]; }"
    )
    left, y = desk.pixel_of("lane-x", start)
    right, _ = desk.pixel_of("lane-x", stop)
    page.wait_for_function(
        """() => Bokeh.documents[0].get_model_by_name('lane-x').toolbar.tools
             .find((tool) => tool.name === 'sweep').active"""
    )
    page.mouse.move(left, y)
    page.mouse.down()
    page.mouse.move((left + right) / 2, y, steps=3)
    page.mouse.move(right, y, steps=3)
    page.mouse.up()
    page.wait_for_selector('[data-do="remove"]')
    added = desk.selected
    assert added not in before

    # The history is read and walked, back to the beginning and on again.
    page.locator('[data-do="history"]').click()
    page.wait_for_selector('.dialog [data-do="history_go"]')
    lines = page.locator('.dialog [data-do="history_go"]')
    assert lines.count() == 2
    lines.last.click()
    until(lambda: added not in desk.rows())
    assert lines.last.get_attribute("aria-current") == "true"
    lines.first.click()
    until(lambda: added in desk.rows())
    page.keyboard.press("Escape")
    page.wait_for_selector(".dialog", state="detached")

    # A file that is dropped is opened; what cannot be a take is refused in a sentence.
    data = b64encode((shared / "data" / "public" / RAW).read_bytes()).decode()
    assert page.evaluate(DROP, ["notes.docx", b64encode(b"no take").decode()]) == [True, True]
    page.wait_for_selector(".message")
    assert "notes.docx" in page.locator(".message").inner_text()
    assert page.evaluate(DROP, ["dropped walk.c3d", data]) == [True, True]
    desk.wait_for("dropped walk.c3d", ".header")
