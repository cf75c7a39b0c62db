"""Experiment E1."""

import json

import numpy as np
import pytest

from markermend.errors import BadInput, UnknownName
from markermend.evaluate import e1
from markermend.model import Take


def swaying(n_frames=600):
    rng = np.random.default_rng(0)
    t = np.arange(n_frames)[:, None, None] / 100.0
    base = 100 * np.sin(t * np.array([1.1, 0.7, 0.4]))
    shape = rng.normal(0, 150, (6, 3))
    noise = rng.normal(0, 0.1, (n_frames, 6, 3))
    return Take(base + shape + noise, 100.0, [f"m{i}" for i in range(6)])


def small(**given):
    settings = {
        "detectors": ["published"],
        "amplitudes": [10.0],
        "shares": [0.1],
        "simulations": 2,
        **given,
    }
    return e1(swaying(), **settings)


@pytest.fixture(scope="module")
def table():
    return small()


def test_every_sample_is_counted(table):
    (cell,) = table.cells
    assert cell.matrix.sum() == pytest.approx(600 * 6)
    # Each kind takes the whole share.
    assert cell.matrix.sum(axis=1)[1:] == pytest.approx([60] * 4)
    assert cell.classes["peak"].tpr > 30
    assert cell.spans["peak"].true == 120


def test_jobs_do_not_change_the_result(table):
    assert small(jobs=2).to_json() == table.to_json()


def test_seeded_and_each_simulation_by_itself(table):
    assert small(seed=1).to_json() != table.to_json()
    one, three = small(simulations=1), small(simulations=3)
    two = table.cells[0].matrix
    first = one.cells[0].matrix
    third = 3 * three.cells[0].matrix - 2 * two
    assert third.sum() == pytest.approx(3600)
    assert (third > -1e-9).all()
    assert (2 * two - first > -1e-9).all()


def test_json_is_strict_and_table_has_a_row_per_kind_and_one_of_all(table):
    text = json.dumps(table.to_json(), allow_nan=False)
    assert json.loads(text)["experiment"] == "e1"
    columns, rows = table.table()
    assert [row[3] for row in rows] == ["peak", "noise", "step", "slow", "all"]
    assert {len(row) for row in rows} == {len(columns)}
    assert rows[-1][columns.index("MCC")] == f"{table.cells[0].mcc:.4f}"


def test_what_jumps_in_the_take_as_it_is_is_told_apart():
    take = swaying()
    positions = np.array(take.positions)
    positions[300, 2] += (0, 25, 0)
    (cell,) = e1(
        take.with_positions(positions),
        detectors=["published"],
        amplitudes=[10.0],
        shares=[0.1],
        simulations=1,
    ).cells
    peaks, clean = cell.spans["peak"], small(simulations=1).cells[0].spans["peak"]
    a_minute = 60 / take.duration_s
    assert peaks.confirmed_per_minute >= clean.confirmed_per_minute + a_minute
    assert peaks.confirmed_per_minute <= peaks.unmodified_per_minute


def test_progress_counts_all():
    seen = []
    small(progress=lambda done, total: seen.append((done, total)))
    assert seen == [(1, 2), (2, 2)]


def test_refusals():
    with pytest.raises(BadInput, match="Nothing to simulate"):
        small(simulations=0)
    with pytest.raises(UnknownName, match="no detector 'guess'"):
        small(detectors=["guess"])
    with pytest.raises(UnknownName, match="no parameter"):
        small(wisdom=3)
