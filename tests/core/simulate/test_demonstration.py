"""Artefacts with known truth, and the demonstration take."""

import json
from collections import Counter
from functools import cache
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import markermend as mm
from markermend.errors import BadInput, UnknownName
from markermend.model import KINDS, Kind, Span, Take
from markermend.simulate import Truth, demonstration, distort, make_demo, read_truth

demonstrated = cache(demonstration)
SHIPPED = Path(__file__).parents[3] / "assets" / "takes"


def quiet_take(n_frames: int = 200) -> Take:
    positions = np.random.default_rng(0).normal(0, 500, (1, 4, 3)) + np.zeros((n_frames, 1, 1))
    return Take(positions=positions, rate=100.0, labels=("A", "B", "C", "D"))


@given(
    start=st.integers(0, 150),
    length=st.integers(1, 50),
    kind=st.sampled_from(KINDS),
    axes=st.sampled_from([("x",), ("x", "z"), ("x", "y", "z")]),
)
def test_only_the_span_changes_and_by_the_amplitude(
    start: int, length: int, kind: Kind, axes: tuple[str, ...]
) -> None:
    clean = quiet_take()
    wanted = Truth("B", Span(start, start + length), kind, None if kind == "gap" else 10.0, axes)
    take, truth = distort(clean, [wanted], np.random.default_rng(0))
    assert truth == (wanted,)
    changed = (take.positions - clean.positions)[:, 1]
    outside = np.ones(200, bool)
    outside[wanted.span.frames] = False
    assert (changed[outside] == 0).all()
    np.testing.assert_array_equal(take.positions[:, [0, 2, 3]], clean.positions[:, [0, 2, 3]])
    inside = changed[wanted.span.frames]
    if kind == "gap":
        assert np.isnan(inside).all()
        return
    assert (inside[:, [axis not in axes for axis in "xyz"]] == 0).all()
    size = np.linalg.norm(inside, axis=1)
    if kind != "noise":
        assert size.max() == pytest.approx(10.0)
    if kind == "step":
        assert size.min() == pytest.approx(10.0)
    if kind == "slow" and length > 4:
        assert (np.diff(size[: length // 2]) > 0).all()
        assert (np.diff(size[(length + 1) // 2 :]) < 0).all()


def test_noise_has_its_standard_deviation_on_each_axis() -> None:
    wanted = Truth("A", Span(0, 4000), "noise", 6.0, ("y", "z"))
    take, _ = distort(quiet_take(4000), [wanted], np.random.default_rng(1))
    spread = take.positions[:, 0].std(axis=0)
    np.testing.assert_allclose(spread, [0, 6, 6], atol=0.3)


def test_swapped_labels_change_places_and_are_two_steps() -> None:
    clean = quiet_take()
    take, truth = distort(
        clean, [Truth("C", Span(5, 9), "step", partner="A")], np.random.default_rng(0)
    )
    np.testing.assert_array_equal(take.positions[5:9, [0, 2]], clean.positions[5:9, [2, 0]])
    np.testing.assert_array_equal(take.positions[9:], clean.positions[9:])
    apart = np.linalg.norm(clean.positions[0, 0] - clean.positions[0, 2])
    assert [(one.marker, one.partner, one.kind) for one in truth] == [
        ("A", "C", "step"),
        ("C", "A", "step"),
    ]
    assert all(one.amplitude == pytest.approx(apart, abs=1e-3) for one in truth)


def test_artefacts_that_do_not_fit_are_refused() -> None:
    for wanted, error, message in (
        (Truth("A", Span(190, 201), "gap"), BadInput, "take has 200 frames; put it earlier"),
        (Truth("E", Span(1, 2), "gap"), UnknownName, "no marker 'E'"),
    ):
        with pytest.raises(error, match=message):
            distort(quiet_take(), [wanted], np.random.default_rng(0))


def test_a_truth_survives_json() -> None:
    for truth in (
        Truth("A", Span(1, 3), "gap"),
        Truth("A", Span(1, 3), "step", 4.5, ("x", "z"), "B"),
    ):
        assert Truth.from_json(json.loads(json.dumps(truth.to_json()))) == truth


@pytest.mark.parametrize(("seed", "scenario"), [(0, "demo"), (7, "demo"), (1, "walk")])
def test_the_demonstration_has_artefacts_of_every_kind_and_nothing_else(
    seed: int, scenario: str
) -> None:
    take, clean, truth = demonstrated(seed, scenario)
    assert np.isfinite(clean.positions).all()
    assert take.n_markers == 53
    assert take.rate == 100.0
    kinds = Counter(one.kind for one in truth)
    assert kinds.keys() == set(KINDS)
    assert kinds["gap"] >= 8
    assert min(kinds.values()) >= 3
    told = np.zeros(take.positions.shape[:2], bool)
    for one in truth:
        told[one.span.frames, take.index(one.marker)] = True
        changed = (
            take.positions[one.span.frames, take.index(one.marker)]
            != (clean.positions[one.span.frames, take.index(one.marker)])
        )
        assert changed.any(axis=1).all(), one
    np.testing.assert_array_equal(take.positions[~told], clean.positions[~told])
    gaps = {(one.marker, one.span) for one in truth if one.kind == "gap"}
    assert gaps == {(label, span) for label in take.labels for span, _ in take.gaps(label)}
    assert Counter(inner for label in take.labels for _, inner in take.gaps(label))[False] == 2
    swapped = [one for one in truth if one.partner]
    assert len(swapped) == 2
    both = [
        {one.kind, other.kind}
        for one, other in combinations(truth, 2)
        if one.marker == other.marker and one.span.overlaps(other.span)
    ]
    assert both == [{"slow", "peak"}], "nothing overlaps but the peak on a slow change"


def test_the_same_demonstration_is_the_same_file(tmp_path: Path) -> None:
    one = make_demo(tmp_path / "a")
    take, _, truth = demonstrated(0, "demo")
    mm.write(take, tmp_path / "again.c3d")
    assert one[0].read_bytes() == (tmp_path / "again.c3d").read_bytes()
    read = mm.read(one[0])
    assert read.labels == take.labels
    assert read.warnings == ()
    np.testing.assert_allclose(read.positions, take.positions, atol=1e-3)
    assert read_truth(one[1]) == truth


def test_the_shipped_take_is_the_one_that_the_command_makes() -> None:
    take, _, truth = demonstrated(0, "demo")
    read = mm.read(SHIPPED / "demo.c3d")
    assert read.labels == take.labels
    # Not bit for bit: mathematical libraries round differently.
    np.testing.assert_allclose(read.positions, take.positions, atol=1e-2)
    told = read_truth(SHIPPED / "demo.truth.json")
    assert [(one.marker, one.span, one.kind, one.partner) for one in told] == [
        (one.marker, one.span, one.kind, one.partner) for one in truth
    ]
    assert (SHIPPED / "demo.c3d").stat().st_size < 3_000_000
