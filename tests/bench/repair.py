"""What repairs cost in CPU, in short and in long takes: a gap of 100 frames among 53 markers.

``python -m tests.bench.repair --json FILE`` writes milliseconds of CPU (all threads together) of
the methods named, and of the comparison of all that apply, in takes of two lengths, and the ratios
of the longer to the shorter. Other work on the machine does not count, but its caches do: the
median of several runs is given.
"""

import argparse
import json
import os
import statistics
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from markermend.model import Span, Take
from markermend.repairing import repair
from markermend.repairing.compare import compare
from markermend.simulate import simulate

FRAMES = (2_000, 200_000)
LENGTH = 100
MARKER = "RKNE"


def played(take: Take, n_frames: int) -> Take:
    """Play a take to and fro until it is long."""
    there = take.positions
    both = np.concatenate([there, there[-2:0:-1]])
    repeats = -(-n_frames // len(both))
    return Take(np.tile(both, (repeats, 1, 1))[:n_frames], take.rate, take.labels)


def with_gap(take: Take, label: str) -> tuple[Take, Span]:
    """Hide one marker in the middle."""
    span = Span(take.n_frames // 2, take.n_frames // 2 + LENGTH)
    positions = take.positions.copy()
    positions[span.frames, take.index(label)] = np.nan
    return take.with_positions(positions), span


def cpu_ms(work: Callable[[], object], runs: int) -> float:
    """Give the median CPU time of several runs after one that warms up."""
    work()
    spent = []
    for _ in range(runs):
        began = time.process_time()
        work()
        spent.append(1000 * (time.process_time() - began))
    return round(statistics.median(spent), 1)


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", type=Path)
    parser.add_argument("--methods", default="pchip,rigid,rlk,wpca,auto")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--no-comparison", action="store_true")
    options = parser.parse_args(arguments)
    walk = simulate("walk", 0)
    label = MARKER if MARKER in walk.labels else walk.labels[int(walk.measured[0])]
    takes = {n: with_gap(played(walk, n), label) for n in FRAMES}
    found: dict[str, dict[str, float]] = {}

    def measure(name: str, work: Callable[[Take, Span], object], runs: int) -> None:
        spent = {
            str(n): cpu_ms(lambda take=take, span=span: work(take, span), runs)
            for n, (take, span) in takes.items()
        }
        short, long = spent.values()
        found[name] = {**spent, "ratio": round(long / max(short, 1e-9), 2)}
        print(name, found[name], flush=True)

    for name in options.methods.split(","):
        measure(name, lambda take, span, name=name: repair(take, label, span, name), options.runs)
    if not options.no_comparison:
        measure("comparison", lambda take, span: compare(take, label, span), 1)
    record = {
        "version": 1,
        "markers": walk.n_markers,
        "gap_frames": LENGTH,
        "runs": options.runs,
        "load_1min": round(os.getloadavg()[0], 2),
        "cpu_ms": found,
    }
    if options.json:
        options.json.write_text(json.dumps(record, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
