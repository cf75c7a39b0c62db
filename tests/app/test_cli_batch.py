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
N_TAKES = 12
WAIT_S = 60.0


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
        0, f"13 takes: 12 done, 1 refused, 0 failed; see {out}\n"
    )  # fmt: skip
    assert ended.warnings == [
        "broken.c3d refused: This is no C3D file: its first block is missing or has another mark."
    ]
    for name in ("t00", "sub/t01"):
        printed = command("detect", archive / f"{name}.npz", "--json").out
        assert (out / f"{name}.findings.json").read_text("ascii") == printed
    summary = json.loads((out / "summary.json").read_text("ascii"))
    assert (len(summary["done"]), summary["failed"], summary["resumed"]) == (12, [], 0)
    again = command(*words(archive, out, "--json"))
    assert json.loads(again.out) == {**summary, "resumed": 12}
    page = (out / "summary.html").read_text("utf-8")
    assert "sub/t11.npz" in page
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
def test_a_killed_run_is_gone_on_with(archive: Path, tmp_path: Path):
    random.seed(5)
    out, whole = tmp_path / "killed", tmp_path / "whole"
    done: dict[str, str] = {}
    for _ in range(2):
        enough = random.randrange(len(done) + 1, N_TAKES - 2)
        with start(*words(archive, out, "--jobs", "2", "--repair", "gap")) as process:
            until = time.monotonic() + WAIT_S
            while len(kept(out)) < enough:
                assert process.poll() is None, process.communicate()
                assert time.monotonic() < until
            hands = psutil.Process(process.pid).children(recursive=True)
            process.send_signal(signal.SIGKILL)
            process.communicate()
        assert psutil.wait_procs(hands, timeout=WAIT_S)[1] == []
        found = kept(out)
        assert found.items() >= done.items()  # nothing is lost, and nothing is done again
        done = found
    for folder in (out, whole):
        with start(*words(archive, folder, "--jobs", "2", "--repair", "gap", "--json")) as process:
            printed, _ = process.communicate(timeout=WAIT_S)
        assert process.returncode == 0
        summary = json.loads(printed)
        assert len(summary["done"]) == N_TAKES
        assert summary["resumed"] == (len(done) if folder is out else 0)
    assert contents(out) == contents(whole)
    assert kept(out).items() >= done.items()


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


def test_a_second_run_is_refused_while_one_lives(archive: Path, tmp_path: Path):
    out = tmp_path / "out"
    first = start(*words(archive, out, "--jobs", "1"))
    try:
        until = time.monotonic() + WAIT_S
        while not kept(out):
            assert first.poll() is None, first.communicate()
            assert time.monotonic() < until
            time.sleep(0.02)
        os.kill(first.pid, signal.SIGSTOP)  # so that it lives while the second one looks
        for store, folder in ((tmp_path / "own.sqlite", tmp_path / "own"), (None, out)):
            given = words(archive, folder)
            given = given if store is None else [*given[:-1], str(store)]
            with start(*given) as second:
                said, refused = second.communicate(timeout=WAIT_S)
            assert (second.returncode, said) == (2, "")
            (line,) = refused.splitlines()
            assert "Another batch is at work on" in line
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


def test_a_cluster_finds_the_same(archive: Path, tmp_path: Path, cluster: str):
    (archive / "broken.c3d").write_bytes(b"no recording")
    for name, more in (
        ("1", ["--jobs", "1"]),
        ("2", ["--jobs", "2"]),
        ("dask", ["--dask", cluster]),
    ):
        with start(*words(archive, tmp_path / name, "--repair", "gap", *more)) as process:
            told, warned = process.communicate(timeout=WAIT_S)
        assert process.returncode == 0, warned
        assert told.startswith("13 takes: 12 done, 1 refused, 0 failed")
    assert len(contents(tmp_path / "1")) == 2 * N_TAKES
    assert contents(tmp_path / "1") == contents(tmp_path / "2") == contents(tmp_path / "dask")
    summaries = [(tmp_path / name / "summary.json").read_bytes() for name in ("1", "2", "dask")]
    assert summaries[0] == summaries[1] == summaries[2]


def test_no_cluster_is_refused(archive: Path, tmp_path: Path):
    given = words(archive, tmp_path / "out", "--dask", "tcp://127.0.0.1:9")
    with start(*given) as process:
        said, refused = process.communicate(timeout=WAIT_S)
    assert (process.returncode, said) == (2, "")
    assert "There is no Dask scheduler at tcp://127.0.0.1:9" in refused.splitlines()[-1]
