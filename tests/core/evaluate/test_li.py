"""The experiment of Li et al.: pieces, projection, and takes whose postures are linear."""

import dataclasses
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import markermend as mm
from markermend.errors import BadInput
from markermend.evaluate.li import li, weighting
from markermend.evaluate.li_pieces import (
    EMBARGO,
    Condition,
    conditions,
    even_gaps,
    pieces_of,
    starts_of,
)
from markermend.evaluate.li_tables import Li
from markermend.evaluate.projection import HEIGHT, POINTS, WIDTH, body25, openpose, pinhole
from markermend.model import Span
from markermend.simulate import simulate

LABELS = [f"M{i}" for i in range(8)]


def moving(n_frames: int = 1100, seed: int = 3) -> mm.Take:
    """Eight markers whose postures are mixtures of three patterns."""
    rng = np.random.default_rng(seed)
    t = np.arange(n_frames) / 100
    waves = np.stack([np.sin(1.3 * t), np.cos(2.9 * t + 1), np.sin(4.7 * t)], axis=1)
    mixed = waves @ np.random.default_rng(0).normal(0, 100, (3, 24))
    place = np.random.default_rng(1).uniform(-500, 500, 24)
    positions = mixed + place + rng.normal(0, 0.01, mixed.shape)
    return mm.Take(positions.reshape(-1, 8, 3), 100, LABELS)


def run(**options: object) -> Li:
    wanted = {"dims": (3,), "markers": 0, "pieces": 2, "figures": ("rank",), "times": False}
    return li([moving()], **{**wanted, **options})  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def result() -> Li:
    return run()


@pytest.fixture(scope="module")
def walker() -> mm.Take:
    return simulate("treadmill", 0, duration_s=4.0)


def test_enough_energy_recovers_linear_postures(result: Li):
    rows = {row.method: row for row in result.rows}
    full, poor = rows["li_eq4 energy 1"], rows["li_eq4 energy 0.9"]
    assert full.mean is not None
    assert poor.mean is not None
    assert full.mean < 0.2
    assert poor.mean > 50 * full.mean, "two patterns cannot stand for three"
    for row in result.rows:
        assert row.gaps == 2 * 5
        assert row.refused == 0
        assert row.mean == pytest.approx(np.mean(np.array(row.pieces, float)))
        assert row.rmse is not None
        assert row.mean is not None
        assert row.rmse >= row.mean - 1e-12


def test_seeded_and_the_same_for_any_number_of_processes(result: Li):
    assert run(jobs=2).to_json() == result.to_json()
    assert run(seed=2).starts != result.starts


def test_training_set_that_is_given_is_the_one_used():
    other = dataclasses.replace(moving(), positions=moving().positions[:, ::-1])
    own, strange = run(training=[moving(seed=9)]), run(training=[other])
    for good, bad in zip(own.rows, strange.rows, strict=True):
        if good.method == "li_eq4 energy 1":
            assert good.mean is not None
            assert bad.mean is not None
            assert good.mean < 0.2 < bad.mean, "postures of swapped markers teach nothing"


@settings(max_examples=40, deadline=None)
@given(st.integers(200, 2000), st.integers(0, 2**31))
def test_pieces_do_not_overlap_and_are_not_learnt_from(n_frames: int, seed: int):
    clock = np.broadcast_to(np.arange(n_frames, dtype=float)[:, None, None], (n_frames, 8, 3))
    take = mm.Take(clock + np.arange(24).reshape(8, 3) / 100, 100, LABELS)
    n = n_frames // 200
    starts = starts_of([take], n, 200, seed)
    assert all(b - a >= 200 for (_, a), (_, b) in pairwise(starts))
    for one in pieces_of([take], [], starts, 200, dims=3, markers=0, seed=seed):
        assert one.seen.positions[0, 0, 0] == one.start
        for learnt in one.training:
            frames = learnt.positions[:, 0, 0]
            assert (
                (frames < one.start - EMBARGO + 1) | (frames >= one.start + 200 + EMBARGO)
            ).all()


@given(st.integers(5, 60), st.integers(1, 150))
def test_gaps_are_spread_evenly(n_markers: int, length: int):
    gaps = even_gaps(n_markers, 200, 5, length)
    assert len({marker for marker, _ in gaps}) == 5
    assert {len(span) for _, span in gaps} == {length}
    assert np.ptp(np.diff([span.start for _, span in gaps])) <= 2, "but for rounding"


def test_conditions_are_those_of_the_paper():
    solid = conditions(3, 15, 200, 100.0, whole=True)
    rates = [c.setting for c in solid if c.figure == "Table 2"]
    assert [text.split("(")[1] for text in rates] == [
        "3.3 %)", "6.7 %)", "10.0 %)", "16.7 %)", "26.7 %)",
    ]  # fmt: skip
    assert all(c.gaps[0][1] == Span(100, 200) for c in solid if c.figure == "Table 2")
    dark = [c for c in solid if c.figure.startswith("Blackouts")]
    assert all(len(c.gaps) == 15 and len({span for _, span in c.gaps}) == 1 for c in dark)
    flat = [c.setting for c in conditions(2, 25, 200, 100.0, whole=True) if c.figure == "Table 3"]
    assert flat[-1] == "13 gaps (26.0 %)"


def test_weights_are_told_by_their_scale():
    gap = Span(90, 110)
    dark = Condition("Blackouts", "10 %", 0.1, tuple((m, gap) for m in range(8)), ())
    told = weighting(3, dark, [(4, 2), (8, 2), (4, 0)])
    assert told.scales == (None, 5.0, 10.0, 20.0, 40.0)
    assert told.ranks == (4, 8, 4)
    away = np.arange(50, 0, -1)
    assert told.diagonal == pytest.approx(np.exp(-(away - 1) / 10.0), abs=1e-4)


def test_projection_is_a_picture_of_the_points(walker: mm.Take):
    points = body25(walker)
    assert points.shape == (walker.n_frames, 25, 3)
    flat = pinhole(points)
    assert (flat >= 0).all()
    assert (flat <= [WIDTH, HEIGHT]).all()
    names = list(POINTS)
    nose, heel = names.index("Nose"), names.index("RHeel")
    assert (flat[:, nose, 1] < flat[:, heel, 1]).all(), "y goes down"
    ends = points[:, [nose, heel]]
    line = np.stack([ends[:, 0], ends.mean(axis=1), ends[:, 1]], axis=1)
    a, b, c = pinhole(np.concatenate([points, line[:, 1:2]], axis=1))[
        :, [nose, -1, heel]
    ].transpose(1, 0, 2)
    cross = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    assert np.abs(cross).max() < 1e-6 * np.square(c - a).sum(axis=1).max(), (
        "straight stays straight"
    )


def test_noise_and_drop_outs_are_as_asked_for(walker: mm.Take):
    exact, truth = openpose(walker, noise=0.0, lost=0.0)
    assert np.array_equal(exact.positions, truth)
    assert exact.units == "px"
    rough, same = openpose(walker, noise=2.0, lost=0.1, seed=4)
    assert np.array_equal(same, truth)
    assert np.isnan(rough.positions).mean() == pytest.approx(0.1, abs=0.04)
    assert np.nanstd(rough.positions - truth) == pytest.approx(2.0, rel=0.03)


def test_two_dimensions_go_through(walker: mm.Take):
    told = li([walker], dims=(2,), pieces=1, figures=("rank",), times=False)
    assert len(told.labels) == 25
    assert "no recording" in told.projected
    best = min(row.mean for row in told.rows if row.mean is not None)
    assert best < 15.0, "px"


def test_refusals(walker: mm.Take):
    with pytest.raises(BadInput, match="5 pieces"):
        run(pieces=6)
    with pytest.raises(BadInput, match="Table or Fig"):
        run(figures=("Table 9",))
    with pytest.raises(BadInput, match="OpenPose"):
        run(dims=(2,))
    with pytest.raises(BadInput, match="2 or 3"):
        run(dims=(4,))
    with pytest.raises(BadInput, match="one rate"):
        run(training=[dataclasses.replace(moving(), rate=120.0)])


def test_auto_stands_beside_the_best_rank(result: Li):
    row = dataclasses.replace(result.rows[0], figure="Blackouts", setting="10 %")
    means = {"li_eq16 rank 2": 8.0, "li_eq16 rank 4": 6.0, "auto": 3.0, "spline": 4.0}
    rows = tuple(dataclasses.replace(row, method=m, mean=value) for m, value in means.items())
    tables = {title: lines for title, _, lines in dataclasses.replace(result, rows=rows).tables()}
    told = next(lines for title, lines in tables.items() if title.startswith("AUTO"))
    assert told == [("3D", "10 %", "4", "6.00", "3.00", "0.50", "4.00", "0.75")]
