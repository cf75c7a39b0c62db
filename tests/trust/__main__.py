"""Run the subjects and print their table; see the package's docstring.

Exits with 1 when anything failed or was lost.
"""

import argparse
import contextlib
import importlib
import json
import os
import pkgutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict
from pathlib import Path

from tests import trust
from tests.trust._frame import ROOT, Budget, Outcome, child_environment

LONG_MINUTES = 76.0
"""Of the whole long version with two processes: what the subjects share out among themselves."""
GRACE_S = 300.0
"""A subject that is this much over its time hangs; it is ended and has failed."""


def main() -> int:
    """Run what the command line asks for, and give the exit status."""
    given = _arguments()
    if given.worker:
        _work(given.worker, Budget(given.short, given.seconds, given.seed), Path(given.json))
        return 0
    names = [name for name in subjects() if not given.only or name in given.only]
    unknown = set(given.only) - set(names)
    if unknown:
        sys.exit(f"There is no subject {', '.join(sorted(unknown))}; known are {subjects()}.")
    began = time.monotonic()
    # Called directly and not in a pool: a subject may crash, and its processes are its own.
    weights = {name: importlib.import_module(f"tests.trust.{name}").MINUTES for name in names}
    names.sort(key=weights.__getitem__, reverse=True)
    minutes = LONG_MINUTES if given.minutes is None else given.minutes
    side_by_side = max(1, given.processes)
    factor = _factor(list(weights.values()), side_by_side, minutes)

    def run(name: str) -> list[Outcome]:
        seconds = float("inf") if given.short else 60.0 * weights[name] * factor
        if given.processes:
            rows = _in_a_process(name, seconds, given)
        else:
            rows = list(_rows(name, Budget(given.short, seconds, given.seed)))
        for row in rows:
            print(_line(row), flush=True)
        return rows

    print(_line(None), flush=True)
    with ThreadPoolExecutor(side_by_side) as pool:
        try:
            rows = [row for some in pool.map(run, names) for row in some]
        except KeyboardInterrupt:
            pool.shutdown(wait=False, cancel_futures=True)
            for child in list(_running):
                _end(child)
            raise
    print(f"{time.monotonic() - began:.0f} s in all, {given.processes} processes side by side.")
    tried, failed, lost = (sum(getattr(r, what) for r in rows) for what in _COUNTS)
    print(f"{tried} tried, {failed} failed, {lost} lost")
    return 1 if failed or lost or not tried else 0


_running: set[subprocess.Popen[bytes]] = set()
_COUNTS = ("tried", "failed", "lost")


def subjects() -> list[str]:
    """Name the modules of this folder that are subjects."""
    found = (module.name for module in pkgutil.iter_modules(trust.__path__))
    return sorted(name for name in found if not name.startswith("_"))


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m tests.trust", description=__doc__)
    parser.add_argument("--short", action="store_true", help="the version of the fast tests")
    parser.add_argument("--only", nargs="+", default=[], metavar="SUBJECT")
    parser.add_argument("--minutes", type=float, help="wall-clock minutes for all of it")
    parser.add_argument(
        "--processes", type=int, default=2, help="subjects side by side; 0: all in this process"
    )
    parser.add_argument("--seed", type=int, default=20)
    for hidden in ("--worker", "--json"):
        parser.add_argument(hidden, help=argparse.SUPPRESS)
    parser.add_argument("--seconds", type=float, default=float("inf"), help=argparse.SUPPRESS)
    return parser.parse_args()


def _factor(weights: list[float], processes: int, minutes: float) -> float:
    """Shrink the subjects' times, by no more than it takes, until they fit side by side."""
    lanes = [1e-9] * processes
    for weight in sorted(weights, reverse=True):
        lanes[lanes.index(min(lanes))] += weight
    return min(1.0, minutes / max(lanes))


def _in_a_process(name: str, seconds: float, given: argparse.Namespace) -> list[Outcome]:
    """Run one subject in a process of its own, so that no crash of it goes unseen."""
    began = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="markermend-trust-") as folder:
        answer = Path(folder) / "rows.json"
        command = [sys.executable, "-m", "tests.trust", "--worker", name, "--json", str(answer)]
        command += ["--seconds", str(seconds), "--seed", str(given.seed)]
        command += ["--short"] * given.short
        limit = GRACE_S + (GRACE_S if given.short else seconds)
        rows: list[Outcome] = []
        with (Path(folder) / "said.txt").open("w+b") as said:
            child = subprocess.Popen(
                command, cwd=ROOT, env=child_environment(), stdout=said, stderr=said,
                start_new_session=True,
            )  # fmt: skip
            _running.add(child)
            try:
                child.wait(limit)
                said.seek(0)
                trouble = said.read().decode("utf-8", "replace").strip()[-2000:]
            except subprocess.TimeoutExpired:
                trouble = f"not at its end after {limit:.0f} s"
            finally:
                _end(child)
                _running.discard(child)
        if answer.is_file():
            rows = [Outcome(**row) for row in json.loads(answer.read_text("utf-8"))]
        if answer.with_suffix(".done").is_file():
            return rows
    print(f"{name}: {trouble}", file=sys.stderr, flush=True)
    taken = time.monotonic() - began
    fault = f"FAULT {' '.join(trouble.split())[-200:]}"
    return [*rows, Outcome(name, 1, 1, 0, taken, fault)]


def _end(child: subprocess.Popen[bytes]) -> None:
    """End a subject and everything that it started."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(child.pid, signal.SIGKILL)
    child.wait()


def _rows(name: str, budget: Budget) -> Iterator[Outcome]:
    given = importlib.import_module(f"tests.trust.{name}").run(budget)
    return iter((given,) if isinstance(given, Outcome) else given)


def _work(name: str, budget: Budget, answer: Path) -> None:
    done: list[Outcome] = []
    for row in _rows(name, budget):  # each at once: should a later one never end, this one is known
        done.append(row)
        draft = answer.with_suffix(".part")
        draft.write_text(json.dumps([asdict(one) for one in done]), encoding="utf-8")
        draft.replace(answer)
    answer.with_suffix(".done").touch()


def _line(row: Outcome | None) -> str:
    if row is None:
        return f"{'subject':58} {'tried':>8} {'failed':>7} {'lost':>5} {'s':>6}  note"
    counts = f"{row.tried:8d} {row.failed:7d} {row.lost:5d} {row.seconds:6.0f}"
    return f"{row.subject[:58]:58} {counts}  {row.note}".rstrip()


if __name__ == "__main__":
    sys.exit(main())
