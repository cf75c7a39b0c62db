"""Every public recording is what the list beside it says."""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from markermend import write
from markermend.io import Contents, Reading
from markermend.io.format import format_of
from markermend.model import runs

# What the list has a question mark for, found in the files by hand.
BY_HAND = {
    "long_diabolo_zero_gaps_metres.csv": (None, None, 3, 19_400),
    "motive_rigidbody_1.21.csv": (120.0, "m", 13, 250),
    "vicon_box_gaps.csv": (100.0, "mm", 51, 580),
}
_GAPS = re.compile(r"([\d.]+)% missing, ([\d.]+)% as 0,0,0; (\d+) inner gaps, longest (\d+)")


@dataclass(frozen=True)
class Listed:
    name: str
    rate: float | None
    units: str | None
    points: int
    frames: int
    gaps: tuple[float, ...] | None

    @classmethod
    def of(cls, row: list[str]) -> "Listed":
        name, _, _, _, rate, units, points, frames, gaps, *_ = row
        if name in BY_HAND:
            return cls(name, *BY_HAND[name], None)
        units = None if units == "none" else units.split()[0]
        found = tuple(float(number) for number in _GAPS.match(gaps).groups())
        return cls(name, float(rate), units, int(points), int(frames), found)


def listed(shared: Path) -> list[Listed]:
    text = (shared / "data/public/README.md").read_text()
    table = [line.strip("| \n").split(" | ") for line in text.splitlines() if line[:2] == "| "]
    return [Listed.of(row) for row in table if len(row) > 8 and Path(row[0]).suffix]


def opened(path: Path) -> Contents:
    return format_of(path).open(path, Reading(second_opinion=False))


def test_the_list_names_every_file(shared: Path) -> None:
    there = {path.name for path in (shared / "data/public").iterdir()} - {"README.md"}
    derived = {name for name in there if name.startswith("derived_")}
    assert {row.name for row in listed(shared)} == there - derived


def test_count_rate_unit_and_gaps_are_as_listed(shared: Path) -> None:
    for row in listed(shared):
        contents = opened(shared / "data/public" / row.name)
        assert contents.units == row.units, row.name
        assert contents.rate == (None if row.rate is None else pytest.approx(row.rate, rel=1e-5))
        assert contents.positions.shape == (row.frames, row.points, 3), row.name
        if row.gaps is None:
            continue
        missing, zero, inner, longest = row.gaps
        unseen = np.isnan(contents.positions[..., 0])
        assert 100 * unseen.mean() == pytest.approx(missing + zero, abs=0.011), row.name
        spans = [
            len(span)
            for m in range(contents.n_points)
            for span in runs(unseen[:, m])
            if span.start > 0 and span.stop < contents.n_frames
        ]
        if missing == 0 or zero == 0:  # the list counts gaps of one encoding only
            assert (len(spans), max(spans, default=0)) == (inner, longest), row.name


def test_nothing_repaired_gives_every_file_back(shared: Path, tmp_path: Path) -> None:
    for row in listed(shared):
        path = shared / "data/public" / row.name
        take = opened(path).take(units=row.units or "mm", rate=row.rate or 100.0)
        assert write(take, tmp_path / row.name).mode == "copied"
        assert (tmp_path / row.name).read_bytes() == path.read_bytes()
        (tmp_path / row.name).unlink()
