"""Many operators on one server at once: are their decisions kept, and how long does each take?

``python -m tests.bench.serve [--operators 20] [--seconds 300] [--pause 1.0] [--processes 1]``

Every operator logs in, opens the demonstration take in a window of its own, and decides and takes
back by the websocket as a browser would, with a pause between. The time of a decision is from the
message to the page that shows it, on this machine. At the end the store must hold exactly what was
acknowledged: nothing lost, nothing twice. ``--postgres`` keeps the reviews in a PostgreSQL server
of its own that waits for its disk at every commit, else they lie in a file. ``--until 500`` adds
operators until that many ms are not kept by 95 of 100 decisions, and says how many it held.
"""

import argparse
import asyncio
import json
import os
import random
import shutil
import statistics
import tempfile
import time
from contextlib import ExitStack
from dataclasses import asdict, dataclass, field
from pathlib import Path

import psutil
from tests.bench.team import server
from tests.visitor import Served, Visitor, free_ports

from markermend.assets import demonstration
from markermend.review.store import Store
from markermend_app.serving.accounts import hashed

PASSWORD = "many operators at once"
SEED = 20


@dataclass
class Operator:
    """What one operator did, as far as the page acknowledged it."""

    name: str
    done: int = 0
    seconds: list[float] = field(default_factory=list)


@dataclass(frozen=True)
class Figures:
    """What one run showed."""

    operators: int
    decisions: int
    lost: int
    doubled: int
    median_ms: float
    p95_ms: float
    most_ms: float
    cpu_ms_each: float
    load: float


class Bench:
    """One server and its operators."""

    def __init__(self, folder: Path, store: str, most: int, processes: int) -> None:
        archive, people = folder / "archive", folder / "people.json"
        archive.mkdir()
        shutil.copy(demonstration(), archive)
        self.store = store
        kept = hashed(PASSWORD)
        names = [f"operator-{i:02}" for i in range(most)]
        people.write_text(json.dumps({name: {"password": kept} for name in names}))
        self.names = iter(names)
        self.served = Served(
            "serve", archive, "--store", self.store, "--port", free_ports(processes),
            "--login", f"basic:{people}", "--processes", processes, log=folder / "log.txt",
        )  # fmt: skip
        self.at_work: list[tuple[Operator, Visitor]] = []

    async def add(self, n: int) -> None:
        """Let more operators come in and open the take."""
        for _ in range(n):
            operator = Operator(next(self.names))
            visitor = Visitor(self.served.url)
            assert (await visitor.log_in(operator.name, PASSWORD)).code == 302
            answer = await visitor.get()
            if answer.code == 302:  # to the process that is this operator's
                visitor.url = str(answer.headers["Location"])
            await visitor.open()
            await visitor.until(lambda _, visitor=visitor: visitor.settled, 300)
            self.at_work.append((operator, visitor))

    async def work(self, seconds: float, pause: float) -> Figures:
        """Let all decide for a time."""
        before, spent = {o.name: o.done for o, _ in self.at_work}, self._cpu()
        for operator, _ in self.at_work:
            operator.seconds.clear()
        until = time.monotonic() + seconds
        await asyncio.gather(*(decide(o, v, until, pause) for o, v in self.at_work))
        cpu = self._cpu() - spent
        took = sorted(1000 * s for o, _ in self.at_work for s in o.seconds)
        n = sum(o.done - before[o.name] for o, _ in self.at_work)
        lost, doubled = self._compare()
        return Figures(
            len(self.at_work), n, lost, doubled, statistics.median(took),
            took[int(0.95 * len(took))], took[-1], 1000 * cpu / max(1, n), os.getloadavg()[0],
        )  # fmt: skip

    def _compare(self) -> tuple[int, int]:
        with Store(self.store) as store:
            kept = {r.operator: len(store.entries(r.id)) for r in store.reviews()}
        off = [kept.get(o.name, 0) - o.done for o, _ in self.at_work]
        return -sum(d for d in off if d < 0), sum(d for d in off if d > 0)

    def _cpu(self) -> float:
        parent = psutil.Process(self.served.process.pid)
        times = [p.cpu_times() for p in (parent, *parent.children(recursive=True))]
        return sum(t.user + t.system for t in times)

    async def close(self) -> None:
        """Let everybody go home."""
        for _, visitor in self.at_work:
            await visitor.close()


async def decide(operator: Operator, visitor: Visitor, until: float, pause: float) -> None:
    """Reject findings, and take each third decision back, until the time is over."""
    drawn = random.Random(f"{SEED} {operator.name}")
    while time.monotonic() < until:
        assert visitor.settled is not None
        settled, total = visitor.settled
        back = settled > 0 and (settled == total or drawn.random() < 1 / 3)
        wanted = settled - 1 if back else settled + 1
        began = time.monotonic()
        await visitor.do("undo" if back else "reject")
        await visitor.until(lambda _, n=wanted: visitor.settled and visitor.settled[0] == n, 120)
        operator.seconds.append(time.monotonic() - began)
        operator.done += 1
        await asyncio.sleep(drawn.uniform(0.5, 1.5) * pause)


async def run(options: argparse.Namespace) -> list[Figures]:
    """Run what the command line asks for."""
    found: list[Figures] = []
    most = options.operators if options.until is None else options.most
    with tempfile.TemporaryDirectory() as folder, ExitStack() as held:
        kept = str(Path(folder) / "store.sqlite")
        store = held.enter_context(server()) if options.postgres else kept
        bench = Bench(Path(folder), store, most, options.processes)
        try:
            await bench.add(options.operators)
            found.append(await bench.work(options.seconds, options.pause))
            say(found[-1])
            while options.until is not None and found[-1].p95_ms < options.until:
                if len(bench.at_work) + options.step > most:
                    break
                await bench.add(options.step)
                found.append(await bench.work(options.seconds, options.pause))
                say(found[-1])
            await bench.close()
        finally:
            bench.served.stop()
    return found


def say(figures: Figures) -> None:
    """Print one row."""
    print(
        f"{figures.operators} operators: {figures.decisions} decisions, {figures.lost} lost, "
        f"{figures.doubled} doubled; median {figures.median_ms:.0f} ms, 95 % under "
        f"{figures.p95_ms:.0f} ms, slowest {figures.most_ms:.0f} ms; "
        f"{figures.cpu_ms_each:.0f} ms of CPU each; load {figures.load:.1f}",
        flush=True,
    )


def main() -> int:
    """Run the bench; 1 when a decision was lost or doubled."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--operators", type=int, default=20)
    parser.add_argument("--seconds", type=float, default=300.0)
    parser.add_argument("--pause", type=float, default=1.0)
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("--postgres", action="store_true")
    parser.add_argument("--until", type=float, metavar="MS")
    parser.add_argument("--step", type=int, default=5)
    parser.add_argument("--most", type=int, default=80)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    found = asyncio.run(run(options))
    if options.json:
        options.json.write_text(json.dumps([asdict(one) for one in found], indent=2) + "\n")
    return int(any(one.lost or one.doubled for one in found))


if __name__ == "__main__":
    raise SystemExit(main())
