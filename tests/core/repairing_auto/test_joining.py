"""Two takes in one, with the time between them filled."""

import numpy as np
import pytest

from markermend.errors import BadInput
from markermend.model import Take
from markermend.repairing.joining import joined
from markermend_app.cli.main import main


def part(walk, frames, markers=slice(None)):
    return Take(walk.positions[frames, markers], walk.rate, walk.labels[markers])


def test_the_parts_stay_and_the_time_between_is_filled(walk):
    few = slice(0, 12, 4)
    first, second = part(walk, slice(0, 600), few), part(walk, slice(630, 1200), few)
    whole, repairs, refusals = joined(first, second, 0.3)
    truth = walk.positions[:, few]
    assert whole.n_frames == 1200
    np.testing.assert_array_equal(whole.positions[:600], truth[:600])
    np.testing.assert_array_equal(whole.positions[630:], truth[630:])
    assert len(repairs) == 3
    assert not refusals
    off = np.linalg.norm(whole.positions[600:630] - truth[600:630], axis=2)
    held = np.linalg.norm(truth[600] - truth[629], axis=1)
    assert (off.mean(axis=0) < 0.2 * held).all()


def test_what_does_not_go_together_is_refused(walk):
    take = part(walk, slice(0, 100))
    with pytest.raises(BadInput, match="rate"):
        joined(take, Take(take.positions, 50.0, take.labels), 0.1)
    with pytest.raises(BadInput, match="in common"):
        joined(take, Take(take.positions, take.rate, [f"X{i}" for i in range(12)]), 0.1)
    with pytest.raises(BadInput, match="longer gap"):
        joined(take, take, 0.001)


def test_the_command_says_what_is_lost(tmp_path, capsys, walk):
    from markermend.io import read, write

    few = slice(0, 12, 4)
    for name, frames in (("a", slice(0, 300)), ("b", slice(310, 700))):
        write(part(walk, frames, few), tmp_path / f"{name}.npz")
    out = tmp_path / "whole.c3d"
    arguments = ["join", str(tmp_path / "a.npz"), str(tmp_path / "b.npz"), "--gap", "0.1"]
    assert main([*arguments, "-o", str(out), "--method", "spline"]) == 0
    assert "written anew" in capsys.readouterr().err
    assert read(out).n_frames == 700
    assert read(out).seen.all()
