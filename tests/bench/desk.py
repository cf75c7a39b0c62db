"""How fast the desk is, measured in a headless Chromium without a GPU: what is drawn, not sent.

``python -m tests.bench.desk --json FILE`` writes, for each figure, how often it was counted, the
median and the 95th percentile, and how disturbed the machine was meanwhile.
"""

import argparse
import json
import os
import statistics
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import psutil
from playwright.sync_api import Browser, Page, sync_playwright
from tests.browser.conftest import FLAGS, find_chromium
from tests.browser.desk_page import Server

import markermend as mm
from markermend.assets import demonstration

HELPERS = Path(__file__).with_name("desk_page.js")
WORST_MS = 120_000
COMPARISONS = 10
DECISIONS = 500
"""Between the first and the last look at the memory, with those that take them back."""


def summary(values: Sequence[float]) -> dict[str, float]:
    """Give how many, the median and the 95th percentile."""
    if not values:
        return {"n": 0, "median": float("nan"), "p95": float("nan")}
    return {
        "n": len(values),
        "median": round(statistics.median(values), 3),
        "p95": round(float(np.quantile(values, 0.95)), 3),
    }


def calibration() -> dict[str, float]:
    """Time the same small piece of work again and again: what varies is the machine."""
    times = []
    for _ in range(40):
        began = time.perf_counter()
        sum(i * i for i in range(100_000))
        times.append(1000 * (time.perf_counter() - began))
    return {
        "loop_ms_best": round(min(times), 3),
        "loop_ms_median": round(statistics.median(times), 3),
        "load_1min": round(os.getloadavg()[0], 2),
        "cores": os.cpu_count() or 0,
    }


def long_take(folder: Path, n_frames: int, n_markers: int = 60) -> Path:
    """Repeat the demonstration to and fro until it is long; artefacts and gaps come with it."""
    demo = mm.read(demonstration())
    there = demo.positions[:, demo.measured]
    there = np.concatenate([there, there[:, : n_markers - there.shape[1]] + 40.0], axis=1)
    both = np.concatenate([there, there[::-1]])
    times = -(-n_frames // len(both))
    positions = np.tile(both, (times, 1, 1))[:n_frames]
    labels = [f"M{i:02}" for i in range(positions.shape[1])]
    path = folder / "long.npz"
    mm.write(mm.Take(positions, demo.rate, labels), path)
    return path


class Bench:
    """One server, one page, and what is measured on them."""

    def __init__(self, browser: Browser, take: Path, folder: Path) -> None:
        self.server = Server(take, store=folder / f"{take.stem}.sqlite")
        self.process = psutil.Process(self.server.process.pid)
        began = time.perf_counter()
        self.page: Page = browser.new_page(viewport={"width": 1600, "height": 1000})
        self.page.set_default_timeout(WORST_MS * 8)
        self.page.goto(self.server.url)
        self.page.wait_for_selector(".row")
        self.page.wait_for_function(
            "() => window.markermendScene?.ready && Bokeh.documents[0].get_model_by_name('lane-x')"
            "?.renderers.find((r) => r.name === 'raw').data_source.get_length() > 0"
        )
        self.open_s = time.perf_counter() - began
        self.page.evaluate(HELPERS.read_text(encoding="utf-8"))
        self.page.wait_for_selector('.repair[aria-checked="true"]')

    def close(self) -> None:
        """End page and server."""
        self.page.close()
        self.server.kill()

    def timed(self, key: str, what: str) -> float:
        """Press a key and wait until what it asks for is painted; ms, for a comparison s."""
        self.page.evaluate("bench.remember()")
        waiting = self.page.evaluate_handle(f"() => ({{ done: bench.{what}() }})")
        self.page.keyboard.press(key)
        return float(waiting.evaluate("(it) => it.done"))

    def wait_for_search(self) -> None:
        """Wait until everything that is in the take has been found."""
        self.page.wait_for_selector(".header .bar.running", state="detached")

    def server_mb(self) -> float:
        """Memory of the server and what it started; what they share is counted once."""
        processes = [self.process, *self.process.children(recursive=True)]
        return sum(_own_bytes(p) for p in processes) / 1e6

    def browser_mb(self) -> float:
        """Memory of the page's own objects after collecting what is no longer used."""
        session = self.page.context.new_cdp_session(self.page)
        session.send("HeapProfiler.collectGarbage")
        return float(session.send("Runtime.getHeapUsage")["usedSize"]) / 1e6


def _own_bytes(process: psutil.Process) -> int:
    try:
        told = process.memory_full_info()
    except psutil.NoSuchProcess:
        return 0
    return int(getattr(told, "pss", told.rss))


def on_a_real_take(bench: Bench, events: int) -> dict[str, dict[str, float]]:
    """Decide, preview, compare, slide and play."""
    page = bench.page
    bench.wait_for_search()
    comparisons = [bench.timed("k", "compared") for _ in range(COMPARISONS)]
    sys.stderr.write(f"comparisons {summary(comparisons)} s\n")
    # A take has fewer findings than are decided on here: each decision is taken back.
    keys = []
    for _ in range(events):
        keys.append(bench.timed("f", "next"))
        bench.timed("u", "next")
        page.wait_for_timeout(100)
    memory = [bench.server_mb()]
    for _ in range(DECISIONS // 2 - events):
        bench.timed("f", "next")
        bench.timed("u", "next")
    memory.append(bench.server_mb())
    sys.stderr.write(f"keys {summary(keys)} server {memory} MB\n")
    previews = [bench.timed("j", "preview") for _ in range(events)]
    last = int(page.evaluate("window.markermendScene.frame"))
    slides = [float(page.evaluate(f"bench.slid({last + 3 + i % 40})")) for i in range(events)]
    sys.stderr.write(f"previews {summary(previews)} slider {summary(slides)}\n")
    page.keyboard.press(" ")
    page.wait_for_timeout(1000)
    heap = [bench.browser_mb()]
    plays = [float(page.evaluate("bench.played(1000)")) for _ in range(max(10, events // 5))]
    heap.append(bench.browser_mb())
    page.keyboard.press(" ")
    sys.stderr.write(f"play {summary(plays)} heap {heap} MB\n")
    return {
        "key_to_next_ms": summary(keys),
        "first_preview_ms": summary(previews),
        "comparison_s": summary(comparisons),
        "slider_ms": summary(slides),
        "play_fps": summary(plays),
        "server_mb": summary([memory[0]]),
        "server_growth_pct": summary([100 * (memory[1] / memory[0] - 1)]),
        "browser_growth_pct": summary([100 * (heap[1] / heap[0] - 1)]),
    }


def on_a_long_take(bench: Bench, events: int) -> dict[str, dict[str, float]]:
    """Switch markers and pan."""
    switches = [bench.timed("j", "next") for _ in range(events)]
    for _ in range(2):
        bench.page.keyboard.press("z")
        bench.page.wait_for_timeout(1500)
    pans = [float(bench.page.evaluate("bench.panned(1000)")) for _ in range(10)]
    return {
        "open_s": summary([bench.open_s]),
        "marker_switch_ms": summary(switches),
        "pan_paints_s": summary(pans),
    }


def main() -> None:
    """Measure and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", type=Path, help="where the figures go")
    parser.add_argument("--take", type=Path, default=demonstration(), help="a real take")
    parser.add_argument("--events", type=int, default=50, help="how often each is counted")
    parser.add_argument("--frames", type=int, default=200_000, help="of the long take")
    parser.add_argument("--only", choices=("take", "long"), help="one of the two parts")
    options = parser.parse_args()
    found: dict[str, Any] = {"machine": calibration()}
    with tempfile.TemporaryDirectory() as name, sync_playwright() as playwright:
        folder = Path(name)
        as_root = ["--no-sandbox"] if getattr(os, "geteuid", lambda: 1)() == 0 else []
        browser = playwright.chromium.launch(
            executable_path=find_chromium(playwright), args=[*FLAGS, *as_root]
        )
        parts = {
            "take": lambda: (options.take.absolute(), on_a_real_take),
            "long": lambda: (long_take(folder, options.frames), on_a_long_take),
        }
        for part, make in parts.items():
            if options.only in (None, part):
                take, measure = make()
                bench = Bench(browser, take, folder)
                try:
                    found |= measure(bench, options.events)
                finally:
                    bench.close()
        browser.close()
    found["machine_after"] = calibration()
    text = json.dumps(found, indent=2)
    if options.json:
        options.json.write_text(text + "\n", encoding="utf-8")
    sys.stdout.write(text + "\n")


if __name__ == "__main__":
    main()
