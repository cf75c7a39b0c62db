"""``markermend batch`` as a process: its contract, and that it can be killed at any moment."""

import json
import os
import random
import re
import signal
import sqlite3
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import psutil
import pytest
from filelock import FileLock

import markermend as mm

from .conftest import Command

CLUSTER = """
import sys
from distributed import LocalCluster
if __name__ == "__main__":
    with LocalCluster(2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None) as cluster:
        print(cluster.scheduler_address, flush=True)
        sys.stdin.read()
"""
N_TAKES = 10
WAIT_S = 200.0


def small_take(seed: int) -> mm.Take:
    rng = np.random.default_rng(seed)
    t = np.arange(120) / 100
    path = np.column_stack([300 * np.sin(2 * t), 100 * np.cos(3 * t), 900 + 40 * np.sin(4 * t)])
    positions = path[:, None] + rng.normal(0, 90, (5, 3)) + rng.normal(0, 0.1, (120, 5, 3))
    positions[30 : 34 + seed, seed % 5] = np.nan
    return mm.Take(positions, 100, [f"M{i}" for i in range(5)])


@pytest.fixture
def archive(tmp_path: Path) -> Path:
    folder = tmp_path / "archive"
    (folder / "sub").mkdir(parents=True)
    for seed in range(N_TAKES):
        mm.write(small_take(seed), folder / ("sub" if seed % 3 else "") / f"t{seed:02}.npz")
    return folder


def words(archive: Path, out: Path, *more: object) -> list[str]:
    store = out.with_suffix(".sqlite")
    given = ("batch", archive, "--out", out, "--store", store, *more)
    return [str(word) for word in given]


@pytest.fixture
def cheap(tmp_path: Path) -> tuple[str, ...]:
    """Options that cost little: what is tested here is who does the work, and when."""
    rules = {"gap": {"method": "pchip"}}
    policy = {"schema": "markermend/policy", "version": 1, "repair": rules}
    (tmp_path / "policy.json").write_text(json.dumps(policy))
    return "--kinds", "gap", "--repair", str(tmp_path / "policy.json")


def start(*arguments: str, **settings: Any) -> "subprocess.Popen[str]":
    return subprocess.Popen(
        [sys.executable, "-m", "markermend_app", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        **settings,
    )


def contents(out: Path) -> dict[str, bytes]:
    """Everything that has to be the same however it came about."""
    names = (p for p in out.rglob("*") if p.is_file())
    return {
        p.relative_to(out).as_posix(): p.read_bytes()
        for p in names
        if p.suffix in (".json", ".npz")
        and p.name != "summary.json"
        and not p.name.endswith(".decisions.json")  # it says when it was written
    }


def test_its_files_are_what_detect_prints(command: Command, archive: Path, tmp_path: Path):
    (archive / "broken.c3d").write_bytes(b"no recording")
    out = tmp_path / "out"
    ended = command(*words(archive, out, "--jobs", 2))
    assert (ended.code, ended.out) == (
        0, f"11 takes: 10 done, 1 refused, 0 failed; see {out}\n"
    )  # fmt: skip
    assert ended.warnings == [
        "broken.c3d refused: This is no C3D file: its first block is missing or has another mark."
    ]
    for name in ("t00", "sub/t01"):
        printed = command("detect", archive / f"{name}.npz", "--json").out
        assert (out / f"{name}.findings.json").read_text("ascii") == printed
    summary = json.loads((out / "summary.json").read_text("ascii"))
    assert (len(summary["done"]), summary["failed"], summary["resumed"]) == (N_TAKES, [], 0)
    again = command(*words(archive, out, "--json"))
    assert json.loads(again.out) == {**summary, "resumed": N_TAKES}
    page = (out / "summary.html").read_text("utf-8")
    assert "sub/t08.npz" in page
    assert "default-src 'none'" in page
    # Nothing in the page asks anybody for anything.
    assert not re.search(r"""(src|href)\s*=|url\((?!"data:)|@import|<script""", page)


@pytest.mark.parametrize(
    ("more", "says"),
    [
        (["--repair", "holes"], "--repair takes some of gap"),
        (["--most-mm", "3"], "--most-mm limits repairs"),
        (["--detector", "magic"], "There is no detector 'magic'"),
        (["--kinds", "hole"], "--kinds takes some of gap"),
        (["--jobs", "0"], "must be a whole number from 1"),
        (["--jobs", "2", "--dask", "tcp://127.0.0.1:1"], "leave one of them out"),
        (["--time-limit", "-1"], "must be a positive number of s"),
    ],
)
def test_bad_usage_is_refused_in_a_sentence(
    command: Command, archive: Path, tmp_path: Path, more: list[str], says: str
):
    out = tmp_path / "out"
    assert says in command(*words(archive, out, *more)).refusal
    assert not out.exists()


def test_what_is_no_archive_is_refused(command: Command, tmp_path: Path):
    assert "no folder" in command(*words(tmp_path / "nowhere", tmp_path / "out")).refusal


def test_a_take_that_took_too_long_is_a_failure(command: Command, archive: Path, tmp_path: Path):
    ended = command(*words(archive, tmp_path / "out", "--jobs", 2, "--time-limit", 0.001, "--json"))
    summary = json.loads(ended.out)
    assert ended.code == 1
    assert len(summary["failed"]) == N_TAKES
    assert "longer than 0.001 s" in summary["failed"][0]["reason"]


@pytest.mark.skipif(os.name != "posix", reason="SIGKILL")
def test_a_killed_run_is_gone_on_with(
    command: Command, archive: Path, tmp_path: Path, cheap: tuple[str, ...]
):
    out, whole = tmp_path / "killed", tmp_path / "whole"
    enough = random.randrange(1, N_TAKES - 2)
    with start(*words(archive, out, "--jobs", "2", *cheap)) as process:
        until = time.monotonic() + WAIT_S
        while len(kept(out)) < enough:
            assert process.poll() is None, process.communicate()
            assert time.monotonic() < until
        hands = psutil.Process(process.pid).children(recursive=True)
        process.send_signal(signal.SIGKILL)
        process.communicate()
    assert psutil.wait_procs(hands, timeout=WAIT_S)[1] == []
    done = kept(out)
    assert len(done) >= enough
    for folder, resumed in ((out, len(done)), (whole, 0)):
        summary = json.loads(command(*words(archive, folder, "--jobs", "1", "--json", *cheap)).out)
        assert (len(summary["done"]), summary["resumed"]) == (N_TAKES, resumed)
    assert contents(out) == contents(whole)
    assert kept(out).items() >= done.items()  # nothing is lost, and nothing was done again


def kept(out: Path) -> dict[str, str]:
    """When each take was put down as done."""
    store = out.with_suffix(".sqlite")
    if not store.exists():
        return {}
    with closing(sqlite3.connect(store, timeout=30)) as connection:
        try:
            return dict(connection.execute("SELECT take, at FROM scans"))
        except sqlite3.OperationalError:  # its tables are not made yet
            return {}


def test_a_second_run_is_refused_while_one_lives(command: Command, archive: Path, tmp_path: Path):
    out = tmp_path / "out"
    first = start(*words(archive, out, "--jobs", "1", "--kinds", "gap"))
    try:
        until = time.monotonic() + WAIT_S
        while not kept(out):
            assert first.poll() is None, first.communicate()
            assert time.monotonic() < until
            time.sleep(0.02)
        os.kill(first.pid, signal.SIGSTOP)  # so that it lives while the second one looks
        own = words(archive, tmp_path / "own")
        for given in ([*words(archive, out)[:-1], own[-1]], own):
            assert "Another batch is at work on" in command(*given).refusal
    finally:
        first.kill()
        first.communicate()
    with FileLock(out / ".markermend-batch.lock", timeout=10):
        pass  # the lock went with the process


@pytest.fixture
def cluster() -> Iterator[str]:
    """A scheduler and two workers, each a process of its own, on the loopback."""
    pytest.importorskip("distributed")
    with subprocess.Popen(
        [sys.executable, "-c", CLUSTER],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        encoding="utf-8",
    ) as process:
        assert process.stdout is not None
        yield process.stdout.readline().strip()
        process.communicate(timeout=WAIT_S)


def test_a_cluster_finds_the_same(
    command: Command, archive: Path, tmp_path: Path, cluster: str, cheap: tuple[str, ...]
):
    (archive / "broken.c3d").write_bytes(b"no recording")
    ended = command(*words(archive, tmp_path / "here", "--jobs", "2", *cheap))
    with start(*words(archive, tmp_path / "there", "--dask", cluster, *cheap)) as process:
        told, warned = process.communicate(timeout=WAIT_S)
    assert (process.returncode, warned) == (0, ended.err)
    assert told.startswith("11 takes: 10 done, 1 refused, 0 failed")
    assert len(contents(tmp_path / "here")) == 2 * N_TAKES
    assert contents(tmp_path / "here") == contents(tmp_path / "there")
    summaries = [(tmp_path / name / "summary.json").read_bytes() for name in ("here", "there")]
    assert summaries[0] == summaries[1]
