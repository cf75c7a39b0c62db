"""A batch over an archive: two jobs against one, memory over many takes, and killed runs.

``python -m tests.bench.batch --recordings FOLDER --json FILE`` is the whole thing: 1,000 takes of
5 s with two jobs while memory is watched, the first 120 of them with one job and with two, and 40
that are killed ten times.  With ``--takes``, ``--compared`` and ``--killed`` it is any part of it.
What is said in CPU seconds does not depend on what else the machine does; the ratio of times does,
so the load is said beside it.
"""

import argparse
import json
import os
import random
import shutil
import signal
import sqlite3
import statistics
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

import psutil
from tests.bench.archive_of_takes import make_archive

KILLS = 10
SAMPLED_S = 1.0


class Run:
    """One batch as a process of its own, with what it and its own processes use."""

    def __init__(self, archive: Path, place: Path, jobs: int) -> None:
        self.out, self.store = place / "out", place / "store.sqlite"
        words = ["batch", archive, "--jobs", jobs, "--out", self.out, "--store", self.store]
        place.mkdir(parents=True, exist_ok=True)
        self._said = place / "said.json"  # of a thousand takes it is more than a pipe holds
        self.began = time.perf_counter()
        with self._said.open("w", encoding="utf-8") as said:
            self.process = psutil.Popen(
                [sys.executable, "-m", "markermend_app", *map(str, words), "--json"], stdout=said
            )
        self.memory: list[tuple[float, float]] = []
        self._cpu: dict[tuple[int, float], float] = {}

    def sample(self) -> None:
        """Note the memory of now, MB, and the CPU seconds of each process so far."""
        total = 0.0
        for process in self._processes():
            try:
                total += process.memory_info().rss / 1e6
                used = process.cpu_times()
            except psutil.NoSuchProcess:
                continue
            # Children that were waited for count with the process that waited.
            spent = used.user + used.system + used.children_user + used.children_system
            self._cpu[process.pid, process.create_time()] = spent
        self.memory.append((time.perf_counter() - self.began, total))

    def _processes(self) -> Iterator[psutil.Process]:
        try:
            yield self.process
            yield from self.process.children()  # not deeper: what these wait for is counted there
        except psutil.NoSuchProcess:
            return

    def finish(self) -> dict[str, Any]:
        """Wait for the end while sampling, and give the figures."""
        while self.process.poll() is None:
            self.sample()
            time.sleep(SAMPLED_S)
        wall = time.perf_counter() - self.began
        said = json.loads(self._said.read_text(encoding="utf-8"))
        assert self.process.returncode == 0, said
        n = len(said["done"])
        return {
            "takes": n,
            "wall_s": round(wall, 1),
            "cpu_s": round(sum(self._cpu.values()), 1),
            "cpu_s_per_take": round(sum(self._cpu.values()) / n, 3),
            "load_1min": round(os.getloadavg()[0], 1),
            "resumed": said["resumed"],
            **self._memory_over_time(wall),
        }

    def _memory_over_time(self, wall: float) -> dict[str, float]:
        """Compare the second tenth of the run, when everything is loaded, with the last."""

        def median(low: float, high: float) -> float:
            part = [mb for at, mb in self.memory if low * wall <= at <= high * wall]
            return round(statistics.median(part), 1) if part else float("nan")

        return {"memory_mb_early": median(0.1, 0.2), "memory_mb_late": median(0.9, 1.0)}


def compare(archive: Path, places: Path) -> dict[str, Any]:
    """Run the same takes with one job and with two."""
    runs = {f"jobs_{n}": Run(archive, places / f"jobs{n}", n).finish() for n in (1, 2)}
    one, two = runs["jobs_1"], runs["jobs_2"]
    same = _findings(places / "jobs1" / "out") == _findings(places / "jobs2" / "out")
    assert same, "two jobs found something else than one"
    return {
        **runs,
        "faster": round(one["wall_s"] / two["wall_s"], 2),
        # What two free cores could make of it: twice as fast, but for what two jobs cost more.
        "faster_by_cpu": round(2 * one["cpu_s"] / two["cpu_s"], 2),
        "same_findings": same,
    }


def kill(archive: Path, places: Path, n_takes: int, seed: int) -> dict[str, Any]:
    """Kill a run ten times, each at a random moment, and compare with one that was let be."""
    rng = random.Random(seed)
    whole = Run(archive, places / "whole", 2).finish()
    done: dict[str, str] = {}
    at, ended = [], []
    for _ in range(KILLS):
        run = Run(archive, places / "killed", 2)
        # A random moment of the work: so many takes later, and then anywhere within one.
        enough = len(done) + rng.randint(0, max(1, 2 * (n_takes - 2) // KILLS))
        while len(kept(run.store)) < enough and run.process.poll() is None:
            time.sleep(0.02)
        time.sleep(rng.uniform(0.0, 2 * whole["wall_s"] / n_takes))
        hands = psutil.Process(run.process.pid).children(recursive=True)
        run.process.send_signal(signal.SIGKILL)
        run.process.wait()
        stopped = time.perf_counter()
        _, alive = psutil.wait_procs(hands, timeout=60)
        assert not alive, "a worker outlived its batch"
        ended.append(time.perf_counter() - stopped)
        found = kept(run.store)
        assert found.items() >= done.items(), "something was lost or done twice"
        done = found
        at.append(len(done))
    last = Run(archive, places / "killed", 2).finish()
    assert last["takes"] == n_takes
    assert last["resumed"] == len(done)
    assert kept(places / "killed" / "store.sqlite").items() >= done.items()
    same = _findings(places / "killed" / "out") == _findings(places / "whole" / "out")
    assert same, "a killed run found something else"
    return {
        "kills": KILLS,
        "done_at_each": at,
        "workers_ended_s_most": round(max(ended), 2),
        "lost_or_twice": 0,
        "same_findings": same,
    }


def kept(store: Path) -> dict[str, str]:
    """When each take was put down as done."""
    if not store.exists():
        return {}
    with closing(sqlite3.connect(store, timeout=30)) as connection:
        try:
            return dict(connection.execute("SELECT take, at FROM scans"))
        except sqlite3.OperationalError:  # its tables are not made yet
            return {}


def _findings(out: Path) -> dict[str, bytes]:
    paths = out.rglob("*.findings.json")
    return {path.relative_to(out).as_posix(): path.read_bytes() for path in paths}


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, print, and write what was asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--recordings", type=Path, help="folder of recordings to cut takes out of")
    parser.add_argument("--takes", type=int, default=1000, help="with two jobs, memory watched")
    parser.add_argument("--compared", type=int, default=120, help="with one job and with two")
    parser.add_argument("--killed", type=int, default=40, help="killed ten times")
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--json", type=Path)
    given = parser.parse_args(arguments)
    figures: dict[str, Any] = {}
    place = Path(tempfile.mkdtemp(prefix="markermend-bench-"))
    try:
        parts = {"many": given.takes, "compared": given.compared, "killed": given.killed}
        for name, n in parts.items():
            if n == 0:
                continue
            archive, places = place / name / "archive", place / name
            make_archive(archive, n, given.recordings, given.seed)
            if name == "many":
                figures[name] = Run(archive, places / "run", 2).finish()
            elif name == "compared":
                figures[name] = compare(archive, places)
            else:
                figures[name] = kill(archive, places, n, given.seed)
            print(json.dumps({name: figures[name]}, indent=1), flush=True)
    finally:
        shutil.rmtree(place, ignore_errors=True)
    if given.json is not None:
        given.json.write_text(json.dumps(figures, indent=1))


if __name__ == "__main__":
    main()
