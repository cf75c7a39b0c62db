"""The desk as a person sees it in a browser, and how to ask what is really drawn there."""

import re
import subprocess
import sys
import time
from io import BytesIO
from pathlib import Path
from typing import Any

from PIL import Image
from playwright.sync_api import Page

OPENS_MS = 120_000

VIEW = """(name) => {
  const model = Bokeh.documents[0].get_model_by_name(name);
  return [model, Bokeh.index.find_one(model)];
}"""


class Server:
    """The command ``markermend review``, or another that serves, as a process of its own."""

    def __init__(self, *arguments: str | Path, store: Path, command: str = "review") -> None:
        self.process = subprocess.Popen(
            [
                sys.executable, "-m", "markermend_app", command, *map(str, arguments),
                "--no-browser", "--store", str(store),
            ],
            stdout=subprocess.PIPE,
            text=True,
        )  # fmt: skip
        assert self.process.stdout is not None
        found = re.search(r"http://\S+", self.process.stdout.readline())
        assert found, "the server did not say its address"
        self.url = found[0]

    def kill(self) -> None:
        """End it as a crash would: no goodbye, nothing flushed."""
        self.process.kill()
        self.process.wait()
        if self.process.stdout is not None:
            self.process.stdout.close()


class DeskPage:
    """One page of the application."""

    def __init__(self, page: Page) -> None:
        self.page = page
        page.wait_for_selector(".row", timeout=OPENS_MS)
        # Gaps are there at once, everything else once it is found.
        page.wait_for_selector(".header .bar.running", state="detached", timeout=2 * OPENS_MS)
        self.settled()

    def settled(self) -> None:
        """Wait until the selected finding's repairs are computed and drawn."""
        self.page.wait_for_function(
            "() => Bokeh.documents[0].get_model_by_name('lane-x') && window.markermendScene?.ready",
            timeout=OPENS_MS,
        )
        self.page.wait_for_selector('.repair[aria-checked="true"]', timeout=OPENS_MS)
        self.page.wait_for_timeout(300)

    def press(self, key: str) -> None:
        """Press one key."""
        self.page.keyboard.press(key)

    def wait_for(self, what: str, selector: str, timeout_ms: float = OPENS_MS) -> None:
        """Wait until the element of a selector says `what`."""
        self.page.wait_for_function(
            """([selector, what]) => {
              const find = (node) => {
                const own = node.querySelector(selector);
                if (own) return own;
                for (const child of node.querySelectorAll("*")) {
                  const deep = child.shadowRoot && find(child.shadowRoot);
                  if (deep) return deep;
                }
              };
              return find(document)?.textContent.includes(what);
            }""",
            arg=[selector, what],
            timeout=timeout_ms,
        )

    @property
    def selected(self) -> str:
        """Id of the finding that the queue shows as selected."""
        row = self.page.locator('.row[aria-selected="true"]')
        return str(row.get_attribute("data-id"))

    def wait_selected(self, finding: str) -> None:
        """Wait until a finding is selected and its repairs are there."""
        self.page.wait_for_selector(f'.row[aria-selected="true"][data-id="{finding}"]')
        self.settled()

    def rows(self, settled: bool = False) -> list[str]:
        """Ids of the rows in the order in which they are seen."""
        found = self.page.evaluate(
            """(settled) => {
              const out = [];
              const walk = (node) => {
                for (const child of node.querySelectorAll("*")) {
                  if (child.shadowRoot) walk(child.shadowRoot);
                  if (child.matches(".row") && child.classList.contains("settled") === settled) {
                    out.push([parseFloat(child.style.top), child.dataset.id]);
                  }
                }
              };
              walk(document);
              return out.sort((a, b) => a[0] - b[0]).map((row) => row[1]);
            }""",
            settled,
        )
        return list(found)

    def lane(self, name: str, source: str) -> dict[str, list[float]]:
        """Give the columns that a lane draws under a name."""
        found = self.page.evaluate(
            f"""([name, part]) => {{
              const [model, view] = ({VIEW})(name);
              const drawn = model.renderers.find((r) => r.name === part);
              const data = drawn.data_source.data;
              const out = {{}};
              for (const [key, column] of Object.entries(data instanceof Map
                  ? Object.fromEntries(data) : data)) out[key] = Array.from(column);
              return out;
            }}""",
            [name, source],
        )
        return dict(found)

    def pixel_of(self, name: str, x: float, y: float | None = None) -> tuple[float, float]:
        """Give the place on the page where a lane draws a time (and a value)."""
        found = self.page.evaluate(
            f"""([name, x, y]) => {{
              const [model, view] = ({VIEW})(name);
              const box = view.el.getBoundingClientRect();
              const top = view.frame.bbox.top, height = view.frame.bbox.height;
              return [box.left + view.frame.x_scale.compute(x),
                      box.top + (y === null ? top + height / 2 : view.frame.y_scale.compute(y))];
            }}""",
            [name, x, y],
        )
        return float(found[0]), float(found[1])

    def lane_corner(self, name: str) -> tuple[float, float]:
        """Give a place in the margin of a lane, where nothing but its ground is drawn."""
        found = self.page.evaluate(
            f"""(name) => {{
              const box = ({VIEW})(name)[1].el.getBoundingClientRect();
              return [box.left + 4, box.top + 4];
            }}""",
            name,
        )
        return float(found[0]), float(found[1])

    def colours(self, at: tuple[float, float], width: int = 3, height: int = 3) -> set[Any]:
        """Give the colours on the screen around a place."""
        x, y = at
        clip = {"x": x - width // 2, "y": y - height // 2, "width": width, "height": height}
        picture = Image.open(BytesIO(self.page.screenshot(clip=clip))).convert("RGB")
        return {picture.getpixel((i, j)) for i in range(width) for j in range(height)}

    def marker_pixel(self, index: int) -> tuple[float, float]:
        """Give the place on the page where the 3D view draws a marker."""
        found = self.page.evaluate(f"window.markermendScene.markerPixel({index})")
        return float(found[0]), float(found[1])

    def frame(self) -> int:
        """Give the frame that the 3D view has drawn."""
        return int(self.page.evaluate("window.markermendScene.frame"))

    def cursor(self) -> float:
        """Give the time at which the first lane draws its playhead."""
        return float(
            self.page.evaluate(
                """() => Bokeh.documents[0].get_model_by_name('lane-x').center
                     .find((part) => part.name === 'playhead').location"""
            )
        )


def until(check: Any, seconds: float = 60.0) -> Any:
    """Wait until `check` gives something true, and give it."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        found = check()
        if found:
            return found
        time.sleep(0.05)
    raise AssertionError("it did not happen in time")
