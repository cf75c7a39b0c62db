"""A lab's server for half an hour: people come, decide and go; memory and file handles stay."""

import asyncio
import json
import re
import statistics
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import psutil
from tests.trust._frame import Budget, Outcome, Tally, child_environment
from tests.visitor import Served, Visitor, free_ports

import markermend as mm
from markermend.review.store import Store
from markermend_app.serving.accounts import hashed

MINUTES = 30.0
PASSWORD = "people come and people go"
PEOPLE = 4
WARM_SHARE = 0.3
"""Of the time, before which memory still fills: caches, the pages that wait to be let go."""
MOST_GROWTH = 0.10
"""Of the memory at the beginning, over the whole measured time; more is a leak."""
MOST_HANDLES = 6
GONE_WITHIN_S = 40.0
"""In which the server forgets a page that was closed."""


@dataclass(frozen=True)
class Sample:
    """How the server was at one moment, no page being open."""

    at: float
    megabytes: float
    handles: int
    threads: int


def run(budget: Budget) -> Iterator[Outcome]:
    """Open, decide, close, over and over; nothing in the short version, which tells no growth.

    What the fast tests try of a server they try in `tests.app.test_serving`.
    """
    if budget.short:
        return
    tally = Tally("a server that people come to and leave for long keeps its size")
    with tempfile.TemporaryDirectory() as folder:
        note = asyncio.run(_soak(budget, tally, Path(folder)))
    yield tally.outcome(note)


async def _soak(budget: Budget, tally: Tally, folder: Path) -> str:
    archive, people = folder / "archive", folder / "people.json"
    archive.mkdir()
    mm.write(_take(), archive / "walk.c3d")
    kept = hashed(PASSWORD)
    people.write_text(json.dumps({f"p{i}": {"password": kept} for i in range(PEOPLE)}))
    served = Served(
        "serve", archive, "--store", folder / "store.sqlite", "--port", free_ports(),
        "--login", f"basic:{people}", log=folder / "log.txt", env=child_environment(),
    )  # fmt: skip
    process = psutil.Process(served.process.pid)
    acknowledged = dict.fromkeys((f"p{i}" for i in range(PEOPLE)), 0)
    samples, began, visits = [_sample(process, 0.0)], time.monotonic(), 0
    until = began + max(0.0, budget.left - GONE_WITHIN_S - 20.0)
    try:
        while time.monotonic() < until:
            name = f"p{visits % PEOPLE}"
            try:
                acknowledged[name] += await _visit(served.url, name)
                tally.case()
            except (OSError, TimeoutError, AssertionError) as error:
                tally.case(f"a visit failed: {type(error).__name__} {str(error)[:80]}")
            visits += 1
            samples.append(_sample(process, time.monotonic() - began))
        gone = await _all_gone(served.url)
        tally.case("" if gone else "pages that were closed are still there")
        samples.append(_sample(process, time.monotonic() - began))
    finally:
        served.stop()
    with Store(folder / "store.sqlite") as store:
        for record in store.reviews():
            kept_lines = len(store.entries(record.id))
            wanted = acknowledged[record.operator]
            fault = f"{record.operator}: {wanted} acknowledged, {kept_lines} kept"
            tally.case("" if kept_lines == wanted else fault, lost=kept_lines < wanted)
    for entry in re.split(r"\n(?=\d{4}-\d\d-\d\d )", served.said):
        if " ERROR " in entry.partition("\n")[0]:
            first, *trace = entry.strip().splitlines()
            tally.case(f"the log says: {first[:120]} {trace[-1][:200] if trace else ''}")
    return f"{visits} visits; {_judge(samples, tally)}"


def _take() -> mm.Take:
    """Give two stiff groups of markers that swing, with gaps and spikes to decide on."""
    rng, t = np.random.default_rng(3), np.arange(600) / 100
    centre = np.column_stack([300 * np.sin(2 * t), 100 * np.cos(3 * t), 900 + 40 * np.sin(4 * t)])
    positions = np.stack([centre + rng.normal(0, 90, 3) for _ in range(10)], axis=1)
    positions += rng.normal(0, 0.1, positions.shape)
    for i in range(4):
        positions[80 + 110 * i : 100 + 110 * i, i] = np.nan
        positions[130 + 100 * i, 5 + i] += (25, -10, 5)
    return mm.Take(positions, 100, [f"M{i}" for i in range(10)])


async def _visit(url: str, name: str) -> int:
    """Come, decide twice, take one back, go; give how many of these the page acknowledged."""
    visitor = Visitor(url)
    assert (await visitor.log_in(name, PASSWORD)).code == 302
    await visitor.open()
    try:
        settled, total = await visitor.until(lambda _: visitor.settled, 240)
        done = 0
        for step in ("reject", "reject", "undo"):
            back = step == "undo" or settled == total
            wanted = settled - 1 if back else settled + 1
            await visitor.do("undo" if back else step)
            await visitor.until(lambda _, n=wanted: visitor.settled[0] == n, 240)
            settled, done = wanted, done + 1
        return done
    finally:
        await visitor.close()


async def _all_gone(url: str) -> bool:
    """Say whether the server has let go of all pages but for the one that asks."""
    visitor = Visitor(url)
    await visitor.log_in("p0", PASSWORD)
    end = time.monotonic() + GONE_WITHIN_S
    while time.monotonic() < end:
        text = (await visitor.get("metrics")).body.decode()
        if "markermend_sessions 0.0" in text:
            return True
        await asyncio.sleep(1.0)
    return False


def _sample(process: psutil.Process, at: float) -> Sample:
    handles = process.num_handles() if hasattr(process, "num_handles") else process.num_fds()
    return Sample(at, process.memory_info().rss / 1e6, handles, process.num_threads())


def _judge(samples: list[Sample], tally: Tally) -> str:
    """Fit lines through memory and handles, and say whether they rise."""
    whole = samples[-1].at
    late = [s for s in samples if s.at >= WARM_SHARE * whole]
    grown = samples[-1].handles - samples[0].handles
    tally.case("" if grown <= MOST_HANDLES else f"{grown} more file handles at the end")
    if len(late) < 8:
        return f"{samples[-1].megabytes:.0f} MB, {grown:+} handles"
    minutes = [s.at / 60 for s in late]
    memory = statistics.linear_regression(minutes, [s.megabytes for s in late])
    handles = statistics.linear_regression(minutes, [float(s.handles) for s in late])
    span = minutes[-1] - minutes[0]
    growth = memory.slope * span / statistics.mean(s.megabytes for s in late[:5])
    tally.case("" if growth <= MOST_GROWTH else f"memory grew by {growth:.0%}")
    tally.case("" if handles.slope * span <= MOST_HANDLES else "file handles rise")
    return (
        f"{span:.1f} min: {memory.slope:+.2f} MB and {handles.slope:+.2f} handles a minute, at "
        f"{statistics.mean(s.megabytes for s in late):.0f} MB, {late[-1].threads} threads"
    )
