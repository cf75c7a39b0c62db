"""Many operators at once on one PostgreSQL: what is lost or doubled, and how long a decision takes.

    python -m tests.bench.team --operators 20 --seconds 300 --kills 10
    python -m tests.bench.team --ramp --seconds 20

Operators work in several processes, as on a lab's server, through the sessions that the application
uses. Most have a take of their own, claimed and renewed; every fifth pair shares one review in two
windows, so that conflicts happen and are settled. With ``--kills`` a process is killed at a random
moment, and another goes on with its operators. Every decision carries a number of its own: those
that were acknowledged must be in the journals, and none may be there twice.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from markermend.errors import Conflict
from markermend.model import Finding, Span, Take
from markermend.review import Accept, Reject
from markermend.review.claims import HEARTBEAT_S, claim
from markermend.review.conflicts import resolve
from markermend.review.session import ReviewSession
from markermend.review.store import Store
from markermend.review.upkeep import check

ROOT = Path(__file__).resolve().parents[2]
ANY_NUMBER = 10**9
LIMIT_MS = 500.0
SAFE = ("fsync=on", "synchronous_commit=on", "full_page_writes=on", "max_connections=400")


@dataclass(frozen=True)
class Outcome:
    """What a run of many operators showed; times of one decision in ms."""

    operators: int
    seconds: float
    kills: int
    acknowledged: int
    lost: int
    doubled: int
    unanswered: int
    conflicts: int
    median_ms: float
    p95_ms: float
    most_ms: float
    faults: tuple[str, ...]
    load: float

    @property
    def holds(self) -> bool:
        """Whether nothing was lost or doubled, and decisions were quick enough."""
        return self.safe and self.p95_ms < LIMIT_MS

    @property
    def safe(self) -> bool:
        """Whether nothing was lost or doubled, and every journal can be read."""
        return not (self.lost or self.doubled or self.faults)


def take_of(number: int) -> Take:
    """Make a take like no other."""
    return Take(np.full((2, 1, 3), float(number)), 100.0, ("A",))


def seat_of(operator: int) -> tuple[int, str]:
    """Give the take and the name of an operator; some share both, in two windows."""
    number = operator - 1 if operator % 10 == 1 else operator
    return number, f"operator {number}"


class Operator(threading.Thread):
    """One person who decides at a pace, and writes down what was acknowledged."""

    def __init__(self, store: Store, number: int, options: argparse.Namespace, log: int) -> None:
        super().__init__(daemon=True)
        self.store, self.number, self.log = store, number, log
        self.seconds, self.most, self.pace_s = options.seconds, options.most, options.pace
        self.rng = np.random.default_rng((options.seed, number))
        self.prefix = f"{number}.{os.getpid()}"
        self.finished = False

    def say(self, what: str, identity: str, ms: float = 0.0) -> None:
        """Write a line at once: what is said outlives a kill."""
        os.write(self.log, f"{what} {identity} {ms:.3f}\n".encode())

    def run(self) -> None:
        """Decide until the time is over, or so many decisions are made."""
        number, name = seat_of(self.number)
        session = ReviewSession.open(self.store, take_of(number), name)
        claim(self.store, session.record, name, self.prefix)
        self.say("ready", self.prefix)
        begun = renewed = time.monotonic()
        time.sleep(float(self.rng.uniform(0, self.pace_s)))
        for n in range(self.most):
            if time.monotonic() > begun + self.seconds:
                break
            if time.monotonic() - renewed > HEARTBEAT_S:
                claim(self.store, session.record, name, self.prefix)
                renewed = time.monotonic()
            session = self.decide(session, f"{self.prefix}.{n}")
            time.sleep(float(self.rng.exponential(self.pace_s)))
        self.finished = True

    def decide(self, session: ReviewSession, identity: str) -> ReviewSession:
        """Make one decision, settle a conflict, and now and then go a step back and on."""
        start = int(self.rng.integers(0, 1000))
        finding = Finding("A", Span(start, start + 3), "peak")
        command = Accept((finding,), "pchip", {"id": identity})
        self.say("try", identity)
        begun = time.perf_counter()
        while True:
            try:
                session.do(command)
                break
            except Conflict as conflict:
                self.say("conflict", identity)
                try:
                    session = resolve(session, conflict, "mine")
                    break
                except Conflict:
                    continue
        self.say("done", identity, 1000 * (time.perf_counter() - begun))
        if self.rng.random() < 0.1:
            try:
                session.undo()
                session.redo()
                session.do(Reject((finding,)))
            except Conflict:
                session.refresh()
        return session


def work(options: argparse.Namespace) -> None:
    """Be a process of the server: some operators on one store."""
    log = os.open(options.log, os.O_WRONLY | os.O_APPEND | os.O_CREAT)
    with Store(os.environ["MARKERMEND_STORE"]) as store:
        people = [Operator(store, int(number), options, log) for number in options.work.split(",")]
        for one in people:
            one.start()
        for one in people:
            one.join()
    if not all(one.finished for one in people):
        raise SystemExit(1)


def measure(
    address: str,
    operators: int,
    seconds: float,
    *,
    processes: int = 4,
    kills: int = 0,
    pace_s: float = 1.0,
    most: int = ANY_NUMBER,
    seed: int = 0,
) -> Outcome:
    """Let them decide, and look at what is in the store afterwards.

    Parameters
    ----------
    address
        A server's database in which nobody has reviewed anything.
    operators, processes
        How many people, on how many processes.
    seconds, pace_s
        How long, and how long each thinks between two decisions, in s.
    most
        Decisions of one operator, after which the time is over for that one.
    kills
        How often a process is killed and another goes on.
    """
    Store(address).close()
    rng = np.random.default_rng(seed)
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder) / "log"
        log.touch()
        shares = [range(operators)[i::processes] for i in range(min(processes, operators))]

        def start(share: range, left: float, seed: int) -> subprocess.Popen[bytes]:
            said = {"seconds": left, "most": most, "pace": pace_s, "log": log, "seed": seed}
            return _start(address, share, said)

        def progress() -> float:
            lines = log.read_text().splitlines()
            if sum(line.startswith("ready") for line in lines) < operators:
                return 0.0
            begun.append(time.monotonic())
            done = sum(line.startswith("done") for line in lines) / (operators * most)
            return max(done, (time.monotonic() - begun[0]) / seconds)

        begun: list[float] = []
        crew = [start(share, seconds, seed) for share in shares]
        for moment in sorted(rng.uniform(0.1, 0.8, kills)):
            while (at := progress()) < moment and crew[0].poll() is None:
                time.sleep(0.1)
            which = int(rng.integers(len(crew)))
            crew[which].kill()
            crew[which].wait()
            crew[which] = start(shares[which], max(1.0, seconds * (1 - at)), seed + 1)
        codes = [one.wait() for one in crew]
        said = [line.split() for line in log.read_text().splitlines()]
    if any(codes):
        raise SystemExit(f"A process of operators failed: {codes}")
    return _outcome(address, operators, seconds, kills, said)


def _start(address: str, share: range, said: Mapping[str, object]) -> subprocess.Popen[bytes]:
    arguments = [part for name, value in said.items() for part in (f"--{name}", str(value))]
    arguments += ["--work", ",".join(str(number) for number in share)]
    return subprocess.Popen(
        [sys.executable, "-m", "tests.bench.team", *arguments],
        cwd=ROOT,
        env={**os.environ, "MARKERMEND_STORE": address},
    )


def _outcome(
    address: str, operators: int, seconds: float, kills: int, said: list[list[str]]
) -> Outcome:
    done = {line[1]: float(line[2]) for line in said if line[0] == "done"}
    tried = {line[1] for line in said if line[0] == "try"}
    written: Counter[str] = Counter()
    with Store(address) as store:
        faults = check(store).faults
        for record in store.reviews():
            for entry in store.entries(record.id):
                given = (entry.command or {}).get("parameters", {})
                written.update([given["id"]] if "id" in given else [])
    times = np.array(list(done.values()) or [0.0])
    return Outcome(
        operators=operators,
        seconds=seconds,
        kills=kills,
        acknowledged=len(done),
        lost=len(done.keys() - written.keys()),
        doubled=sum(n - 1 for n in written.values()),
        unanswered=len(tried - done.keys()),
        conflicts=sum(line[0] == "conflict" for line in said),
        median_ms=round(float(np.median(times)), 1),
        p95_ms=round(float(np.percentile(times, 95)), 1),
        most_ms=round(float(times.max()), 1),
        faults=faults,
        load=round(os.getloadavg()[0], 1),
    )


@contextmanager
def server() -> Iterator[str]:
    """Give the address of a server of our own that keeps every commit, as a lab's does."""
    with subprocess.Popen(
        [sys.executable, ROOT / "tests" / "postgres.py", *SAFE],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as child:
        assert child.stdout is not None
        assert child.stdin is not None
        said = json.loads(child.stdout.readline())
        if "why" in said:
            raise SystemExit(said["why"])
        try:
            yield said["address"]
        finally:
            child.stdin.close()
            child.wait(timeout=60)


def main() -> None:
    """Measure, print a line for each run, and fail where a decision was lost or doubled."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--operators", type=int, default=20)
    parser.add_argument("--seconds", type=float, default=300.0)
    parser.add_argument("--processes", type=int, default=4)
    parser.add_argument("--pace", type=float, default=1.0, help="s between two decisions of one")
    parser.add_argument("--kills", type=int, default=0)
    parser.add_argument("--ramp", action="store_true", help="double them until it breaks")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", type=Path)
    parser.add_argument("--most", type=int, default=ANY_NUMBER, help="decisions of one operator")
    parser.add_argument("--work", help=argparse.SUPPRESS)
    parser.add_argument("--log", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.work:
        work(options)
        return
    found: list[Outcome] = []
    people = options.operators
    while True:
        with server() as address:
            seen = measure(
                address,
                people,
                options.seconds,
                processes=options.processes,
                kills=options.kills,
                pace_s=options.pace,
                seed=options.seed,
            )
        found.append(seen)
        print(json.dumps(seen.__dict__), flush=True)
        if not options.ramp or not seen.holds or people >= 1280:
            break
        people *= 2
    if options.json:
        options.json.write_text(json.dumps([one.__dict__ for one in found], indent=1))
    if not all(one.safe for one in found):
        raise SystemExit("A decision was lost or doubled.")


if __name__ == "__main__":
    main()
