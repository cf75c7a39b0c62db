"""Small archives, and a foreign format whose files end or hang the process that reads them."""

import json
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import markermend as mm
from markermend.batch.settings import Settings
from markermend.io.format import all_formats
from markermend.review.store import Store

FORMAT = '''
"""A format of another distribution, which does what the file says."""
import ctypes, time
from markermend.io.format import Format

def do(path, reading):
    what = path.read_text()
    if what == "crash":
        ctypes.string_at(0)
    if what == "fault":
        raise ZeroDivisionError("a fault of the format")
    time.sleep(600)

FORMAT = Format("trap", "Trap", (".trap",), lambda path, head: path.suffix == ".trap", do)
'''

GAPS = Settings(kinds=("gap",))


def small_take(seed: int = 0, n_frames: int = 80) -> mm.Take:
    """Four markers that swing together, with gaps; a different take for each seed."""
    rng = np.random.default_rng(seed)
    t = np.arange(n_frames) / 100
    path = np.column_stack([300 * np.sin(2 * t), 100 * np.cos(3 * t), 900 + 40 * np.sin(4 * t)])
    positions = path[:, None] + rng.normal(0, 90, (4, 3)) + rng.normal(0, 0.1, (n_frames, 4, 3))
    start = int(rng.integers(5, 40))
    positions[start : start + int(rng.integers(2, 20)), 1] = np.nan
    positions[60:, 3] = np.nan
    return mm.Take(positions, 100, ["S:A", "S:B", "S:C", "S:D"])


@pytest.fixture
def store(tmp_path: Path):
    with Store(tmp_path / "store.sqlite") as store:
        yield store


@pytest.fixture
def archive(tmp_path: Path) -> Path:
    """Six takes, two of them in a folder of their own, and one file that is none."""
    folder = tmp_path / "archive"
    (folder / "monday").mkdir(parents=True)
    names = ("a.npz", "b.npz", "c.c3d", "c.npz", "monday/a.npz", "monday/d.trc")
    for seed, name in enumerate(names):
        mm.write(small_take(seed), folder / name)
    (folder / "broken.c3d").write_bytes(b"this is no recording")
    (folder / "notes.txt").write_text("not a take")
    (folder / "session.json").write_text("{}")
    return folder


@pytest.fixture
def trap(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[Path, str], None]]:
    """Install the foreign format, here and for processes started; give what sets a trap."""
    place = tmp_path / "foreign"
    info = place / "traps-1.0.dist-info"
    info.mkdir(parents=True)
    (place / "traps.py").write_text(FORMAT)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: traps\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[markermend.formats]\ntrap = traps:FORMAT\n")
    monkeypatch.setenv("PYTHONPATH", str(place))
    monkeypatch.syspath_prepend(str(place))
    all_formats.cache_clear()

    def set_trap(path: Path, what: str) -> None:
        path.write_text(what)

    yield set_trap
    all_formats.cache_clear()
    sys.modules.pop("traps", None)


def load(path: Path) -> Any:
    """Read JSON."""
    return json.loads(path.read_text(encoding="ascii"))
