"""The library does in a few lines of Python what the command line does."""

from pathlib import Path

import numpy as np
import pytest

import markermend as mm

from .conftest import Command, made_take


def test_read_detect_repair_fill_write(take_path: Path, tmp_path: Path, command: Command):
    take = mm.read(take_path)
    found = mm.detect(take)
    (gap,) = [f for f in found if f.kind == "gap"]
    assert (gap.marker, gap.span, gap.score) == ("M2", mm.Span(200, 240), 1.0)
    stiff = mm.repair(take, gap.marker, gap.span, method="rigid")
    assert isinstance(stiff, mm.Repair)
    assert stiff.values.shape == (40, 3)

    done = mm.repair(take, gap.marker, gap.span)
    np.testing.assert_allclose(done.values, stiff.values, atol=2)  # the groups are stiff
    filled = mm.fill(take)
    np.testing.assert_array_equal(filled.positions[200:240, 2], done.values)
    written = mm.write(filled, tmp_path / "python.c3d")
    assert (written.mode, written.n_changed) == ("patched", 40)
    assert command("repair", take_path, "-o", tmp_path / "cli.c3d").code == 0
    assert (tmp_path / "python.c3d").read_bytes() == (tmp_path / "cli.c3d").read_bytes()


def test_a_take_from_arrays(tmp_path: Path):
    positions = made_take().positions
    take = mm.Take(positions=positions / 1000, rate=100, labels=made_take().labels, units="m")
    np.testing.assert_allclose(take.positions, positions)
    assert not take.positions.flags.writeable
    filled = mm.fill(take, method="pchip")
    assert filled.seen[:, take.measured].all()
    assert not take.seen[200:240, 2].any()  # a change is a new take
    for name in ("take.npz", "take.c3d"):
        written = mm.write(filled, tmp_path / name)
        assert written.mode == "rewritten"
        assert "did not come from a file" in written.why
        again = mm.read(tmp_path / name)
        np.testing.assert_allclose(again.positions, filled.positions, atol=1e-3)
        assert (again.labels, again.rate, again.units) == (take.labels, 100.0, "mm")


def test_fill_reaches_the_ends_where_neighbours_allow():
    positions = made_take().positions.copy()
    positions[:30, 0] = np.nan
    take = mm.Take(positions, 100, made_take().labels)
    filled = mm.fill(take)
    assert filled.seen[:30, 0].all()
    errors = filled.positions[:30, 0] - made_take().positions[:30, 0]
    assert np.linalg.norm(errors, axis=1).mean() < 2


def test_two_dimensions_are_in_pixels():
    flat = mm.Take(made_take().positions[:, :, :2], 100, made_take().labels, units="px")
    assert mm.fill(flat, method="pchip").seen[200:240, 2].all()


@pytest.mark.parametrize("name", mm.__all__)
def test_every_public_name_is_there(name: str):
    assert getattr(mm, name) is not None
    assert name in dir(mm)
