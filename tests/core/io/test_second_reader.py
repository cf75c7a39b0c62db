"""The second reader that stays: its opinions are those of a fresh one, whatever it read before."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import psutil
import pytest

import markermend as mm
from markermend.io import second_reader


@pytest.fixture
def kept(monkeypatch: pytest.MonkeyPatch) -> Iterator[second_reader._Kept]:
    """Keep a reader, for one test."""
    reader = second_reader._Kept()
    monkeypatch.setattr(second_reader, "_kept", reader)
    yield reader
    reader.close()


def recording(path: Path, seed: int) -> Path:
    positions = np.random.default_rng(seed).normal(0, 300, (20, 3, 3))
    positions[4:6, 1] = np.nan
    mm.write(mm.Take(positions, 100, ["A", "B", "C"]), path)
    return path


def pid(kept: second_reader._Kept) -> int | None:
    return None if kept._child is None else kept._child.pid


def same(one: second_reader.Opinion, other: second_reader.Opinion) -> bool:
    if one.positions is None or other.positions is None:
        return one.positions is other.positions and one.trouble == other.trouble
    return one.trouble == other.trouble and np.array_equal(
        one.positions, other.positions, equal_nan=True
    )


def test_one_process_reads_many_files(kept: second_reader._Kept, tmp_path: Path):
    pids = set()
    for seed in range(3):
        path = recording(tmp_path / f"{seed}.c3d", seed)
        opinion = second_reader.ask(path)
        np.testing.assert_allclose(opinion.positions, mm.read(path).positions, rtol=1e-5)
        pids.add(pid(kept))
    assert len(pids) == 1


def test_after_trouble_the_next_file_has_a_fresh_one(kept: second_reader._Kept, tmp_path: Path):
    good, bad = recording(tmp_path / "good.c3d", 1), tmp_path / "bad.c3d"
    bad.write_bytes(good.read_bytes()[:600])
    first, before = second_reader.ask(good), pid(kept)
    assert second_reader.ask(bad).positions is None
    assert pid(kept) is None
    assert before is not None
    assert not psutil.pid_exists(before)
    assert same(second_reader.ask(good), first)
    kept._child.kill()  # also one that ended while nobody asked
    assert same(second_reader.ask(good), first)


@pytest.mark.parametrize("limit_s", [0.0, 30.0])
def test_what_hangs_or_crashes_ezc3d_gets_the_opinion_of_a_fresh_one(
    kept: second_reader._Kept, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, limit_s: float
):
    path = recording(tmp_path / "a.c3d", 2)
    known = second_reader.ask(path, limit_s)
    monkeypatch.setattr(second_reader, "_kept", None)
    assert same(second_reader.ask(path, limit_s), known)


def test_odd_files_get_the_opinion_of_a_fresh_one(
    kept: second_reader._Kept, shared: Path, monkeypatch: pytest.MonkeyPatch
):
    paths = [p for p in sorted((shared / "data/odd").glob("*.c3d")) if "HANG" not in p.name][:8]
    opinions = [second_reader.ask(path) for path in paths]
    monkeypatch.setattr(second_reader, "_kept", None)
    for path, opinion in zip(paths, opinions, strict=True):
        assert same(second_reader.ask(path), opinion), path.name
