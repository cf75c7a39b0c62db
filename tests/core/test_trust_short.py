"""The short version of `make trust`, as a command: what `tests/trust` does in full."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from markermend.repairing.run import REPAIRS

ROOT = Path(__file__).resolve().parents[2]
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


@pytest.mark.timeout(600)
def test_nothing_fails_and_nothing_is_lost(shared: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "tests.trust", "--short", "--processes", "0"],
        cwd=ROOT, capture_output=True, text=True, env=os.environ | ONE_THREAD,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    last = done.stdout.splitlines()[-1]
    found = re.fullmatch(r"(\d+) tried, 0 failed, 0 lost", last)
    assert found, last
    assert int(found.group(1)) > 300


def test_a_fault_is_counted_and_ends_with_1(tmp_path: Path) -> None:
    """A subject that crashes its process is a row that failed, and the command says so."""
    code = (
        "import sys, types, os; from tests.trust import __main__ as trust\n"
        "trust.subjects = lambda: ['_crashes']\n"
        "sys.modules['tests.trust._crashes'] = types.SimpleNamespace(MINUTES=1.0)\n"
        "sys.argv = ['trust', '--short', '--processes', '1']\n"
        "sys.exit(trust.main())\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 1
    assert done.stdout.splitlines()[-1] == "1 tried, 1 failed, 0 lost"


def test_no_exception_to_a_law_is_of_a_method_that_is_gone() -> None:
    code = (
        "from tests.trust import _promises as p; print(*(n for e in p.REPAIRS.values() for n in e))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert set(done.stdout.split()) <= set(REPAIRS.names())
