"""A process that works on takes may crash or hang, and ends with whoever asked it."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

import psutil
import pytest

from markermend.batch import pool
from markermend.batch.hand import Hand
from markermend.batch.work import Result, Task, work
from markermend.errors import BadInput

from .conftest import GAPS

ENDS_S = 100.0
ASK = """
import sys
from pathlib import Path
from markermend.batch.hand import Hand
from markermend.batch.settings import Settings
from markermend.batch.work import Task
Hand().work(Task(Path(sys.argv[1]), "x", Settings(kinds=("gap",))))
"""


@pytest.fixture
def hand() -> Iterator[Hand]:
    with closing(Hand()) as hand:
        yield hand


def task(path: Path) -> Task:
    return Task(path, path.name, GAPS)


def test_gives_what_working_here_gives(hand: Hand, archive: Path):
    for name in ("a.npz", "monday/d.trc", "broken.c3d", "gone.c3d"):
        assert hand.work(task(archive / name)) == work(task(archive / name))


@pytest.mark.skipif(os.name != "posix", reason="names of signals")
def test_a_take_that_crashes_or_hangs_has_failed_and_the_next_is_done(
    hand: Hand, archive: Path, trap: Callable[[Path, str], None]
):
    trap(archive / "x.trap", "crash")
    assert hand.work(task(archive / "x.trap")) == Result(
        "x.trap", "failed", "the process that worked on it died (SIGSEGV)"
    )
    trap(archive / "x.trap", "fault")
    fault = hand.work(task(archive / "x.trap"))
    assert (fault.ended, fault.reason.split(" in ")[0]) == (
        "failed",
        "ZeroDivisionError: a fault of the format",
    )
    trap(archive / "x.trap", "hang")
    hand.limit_s = 8.0
    assert "took longer than 8 s" in hand.work(task(archive / "x.trap")).reason
    hand.limit_s = 1800.0
    assert hand.work(task(archive / "a.npz")).ended == "done"


def test_one_that_died_while_idle_is_no_fault_of_the_next_take(hand: Hand, archive: Path):
    assert hand.work(task(archive / "a.npz")).ended == "done"
    assert hand._process is not None
    hand._process.kill()
    assert hand.work(task(archive / "b.npz")).ended == "done"


def test_another_version_of_the_program_is_no_help(archive: Path):
    result = work(Task(archive / "a.npz", "a.npz", GAPS, version="0.0"))
    assert result.ended == "failed"
    assert "install the same version" in result.reason


@pytest.mark.skipif(os.name != "posix", reason="SIGKILL")
def test_ends_when_whoever_asked_is_killed(archive: Path, trap: Callable[[Path, str], None]):
    trap(archive / "x.trap", "hang")
    with subprocess.Popen([sys.executable, "-c", ASK, str(archive / "x.trap")]) as asking:
        until = time.monotonic() + ENDS_S
        while not (hands := psutil.Process(asking.pid).children()):
            assert time.monotonic() < until
            time.sleep(0.02)
        asking.send_signal(signal.SIGKILL)
        asking.wait()
    gone, alive = psutil.wait_procs(hands, timeout=ENDS_S)
    assert (len(gone), alive) == (1, [])


def test_a_cluster_that_is_not_there_is_refused(archive: Path, monkeypatch: pytest.MonkeyPatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr(pool, "_CONNECT_S", 0.5)
    with pytest.raises(BadInput, match=r"There is no Dask scheduler at tcp://127\.0\.0\.1:9 "):
        list(pool.results([task(archive / "a.npz")], dask="tcp://127.0.0.1:9"))
