"""Coverage-guided fuzzing of every parser of our own, in process (atheris on libFuzzer).

Every input ends in a take, in one sentence, or in a failure of this table: any other exception, a
warning of NumPy, more than 20 s, more than 3 GB.
"""

import json
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

from tests.trust._frame import ROOT, Budget, Outcome, Tally, child_environment

MINUTES = 30.0
INPUTS = 24_000
"""Per target; with ten targets 240,000."""
TARGETS = (
    *("c3d", "trc", "qtm_tsv", "nexus_csv", "motive_csv", "plain_csv", "npz", "openpose"),
    *("decisions", "recipe"),
)


def run(budget: Budget) -> Iterator[Outcome]:
    """Yield a row for each parser; in the short version for two of them."""
    targets = ("qtm_tsv", "decisions") if budget.short else TARGETS
    for i, name in enumerate(targets):
        yield fuzz(name, budget.of(INPUTS, 300), budget.share(1 / (len(targets) - i)))


def fuzz(name: str, runs: int, budget: Budget) -> Outcome:
    """Fuzz one parser in a process of its own."""
    tally = Tally(f"fuzzed in process: {name}", None if find_spec("atheris") is None else runs)
    if find_spec("atheris") is None:
        # It has wheels for Linux on x86-64 alone; Hypothesis does its part everywhere.
        return Outcome(tally.subject, 0, note="atheris is not installed here")
    with tempfile.TemporaryDirectory(prefix="markermend-fuzz-") as scratch:
        folder = Path(scratch)
        seconds = min(max(budget.left, 1.0), 3600.0)  # to libFuzzer 0 is for ever
        command = [sys.executable, "-m", "tests.trust._fuzzed", name, str(runs)]
        done = subprocess.run(
            [*command, str(budget.seed), str(seconds), str(folder)],
            cwd=ROOT, env=child_environment(), capture_output=True, text=True, errors="replace",
        )  # fmt: skip
        record = folder / "count.json"
        said = json.loads(record.read_text("utf-8")) if record.is_file() else {}
        tally.tried = said.get("count", 0)
        for fault in said.get("faults", ()):
            tally.failed += 1
            tally.faults.append(fault)
        for artefact in folder.iterdir():
            if artefact.name.startswith(("timeout", "oom", "crash", "leak", "slow-unit")):
                tally.case(f"{artefact.name[:20]}, {artefact.stat().st_size} bytes")
        if done.returncode and not tally.faults:
            tally.case(f"ended with {done.returncode}: {done.stderr[-200:]!r}")
    return tally.outcome()
