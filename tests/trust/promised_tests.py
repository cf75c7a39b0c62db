"""Promises that tests of the ordinary suite hold, run again and counted here."""

import re
import subprocess
import sys
from collections.abc import Iterator

from tests.trust._frame import ROOT, Budget, Outcome, Tally, child_environment

MINUTES = 6.0
ROWS = {
    "stores of every schema so far open and keep their reviews": (
        "tests/core/review/test_migrations.py",
    ),
    "backups and restore": (
        "tests/core/review/test_store.py::test_a_backup_is_a_store",
        "tests/core/review/test_store.py::test_a_backup_that_cannot_be_written_is_refused",
    ),
    "hostile labels, sizes and refusals": (
        "tests/core/io/test_hostile.py",
        "tests/core/test_errors.py",
        "tests/core/review/test_hostile_words.py",
    ),
}


def run(budget: Budget) -> Iterator[Outcome]:
    """Yield a row for each promise; the short version leaves them to the suite it runs in."""
    for subject, places in {} if budget.short else ROWS.items():
        tally = Tally(subject)
        done = subprocess.run(
            [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *places],
            cwd=ROOT, env=child_environment(), capture_output=True, text=True, errors="replace",
        )  # fmt: skip
        counts = {
            word: int(n) for n, word in re.findall(r"(\d+) (passed|failed|error)", done.stdout)
        }
        tally.tried = counts.get("passed", 0)
        for _ in range(counts.get("failed", 0) + counts.get("error", 0)):
            tally.case("a test failed: " + " ".join(done.stdout.split())[-150:])
        if done.returncode and not tally.failed:
            tally.case(f"pytest ended with {done.returncode}: {done.stdout[-150:]!r}")
        yield tally.outcome()
