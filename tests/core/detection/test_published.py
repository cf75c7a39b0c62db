"""The published detector on takes."""

import json
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from markermend.body import infer
from markermend.detection import DETECTORS
from markermend.detection import detect as detect_with
from markermend.errors import BadParameter
from markermend.model import Span, Take

detect = partial(detect_with, detector="published")


def person(n_frames=2000, rate=100.0, seed=0, n_dims=3):
    """Two rigid parts of four markers that sway, with a tenth of a millimetre of noise."""
    rng = np.random.default_rng(seed)
    t = np.arange(n_frames) / rate
    root = 150 * np.stack([np.sin(0.9 * t), np.cos(0.7 * t), 0.2 * np.sin(2 * t)], 1)
    a = 0.4 * np.sin(1.3 * t)
    turn = np.zeros((n_frames, 3, 3))
    turn[:, 0, 0] = turn[:, 1, 1] = np.cos(a)
    turn[:, 0, 1], turn[:, 1, 0], turn[:, 2, 2] = -np.sin(a), np.sin(a), 1.0
    shape = np.array([[0, 0, 0], [90, 0, 0], [0, 80, 0], [30, 30, 70]], float)
    first = root[:, None] + shape
    second = root[:, None] + [0, 0, 300.0] + np.einsum("fij,mj->fmi", turn, shape)
    positions = np.concatenate([first, second], 1) + rng.normal(0, 0.1, (n_frames, 8, 3))
    labels = [f"m{i}" for i in range(8)]
    return Take(positions[:, :, :n_dims], rate, labels, units="mm" if n_dims == 3 else "px")


def with_artefact(take, marker, span, values, axes=(0, 1, 2)):
    positions = take.positions.copy()
    for axis in axes:
        positions[span.frames, take.index(marker), axis] += values
    return take.with_positions(positions)


def triangle(n):
    return 1 - np.abs(np.arange(n) - (n - 1) / 2) / (n / 2)


ARTEFACTS = [
    ("peak", Span(400, 401), 12.0),
    ("noise", Span(400, 450), np.random.default_rng(8).normal(0, 10.0, 50)),
    ("step", Span(400, 450), 12.0),
    ("slow", Span(380, 460), 15.0 * triangle(80)),
]


@pytest.mark.parametrize(("kind", "span", "values"), ARTEFACTS)
@pytest.mark.parametrize("axes", [(0,), (2,), (0, 1, 2)])
def test_one_artefact_is_one_finding_of_its_kind(kind, span, values, axes):
    take = with_artefact(person(), "m5", span, values, axes)
    # So regular a motion can be any shape as a polynomial of high order: take a plain one.
    found = detect(take, order=1, context=1)
    found = [f for f in found if f.marker == "m5" and f.span.overlaps(span)]
    assert [f.kind for f in found] == [kind]
    finding = found[0]
    assert finding.span.iou(span) > 0.5
    assert set(finding.axes) == {"xyz"[a] for a in axes}
    assert finding.strength >= 1.0
    assert 0.5 <= finding.score <= 1.0
    size = np.std(values) if kind == "noise" else np.max(values)
    # On several axes the amplitude is that of the displacement in space.
    assert finding.amplitude == pytest.approx(size * len(axes) ** 0.5, rel=0.35)


@pytest.mark.parametrize(("kind", "span", "values"), ARTEFACTS)
def test_evidence_shows_why(kind, span, values):
    take = with_artefact(person(), "m5", span, values, (1,))
    found = [f for f in detect(take) if f.marker == "m5" and f.kind == kind]
    finding = next(f for f in found if f.span.overlaps(span))
    evidence = finding.evidence
    n = len(evidence.signal)
    assert evidence.start <= finding.span.start
    assert evidence.start + n >= finding.span.stop
    assert np.abs(evidence.signal).max() >= evidence.threshold > evidence.usual > 0
    assert evidence.prediction.shape == (n, 3)
    # What is expected lies nearer to the truth than what was recorded.
    frames = slice(evidence.start, evidence.start + n)
    true = person().positions[frames, 5, 1]
    recorded = take.positions[frames, 5, 1]
    assert np.abs(evidence.prediction[:, 1] - true).max() < np.abs(recorded - true).max()


@settings(max_examples=5, deadline=None)
@given(shift=st.tuples(*[st.floats(-3000, 3000)] * 3))
def test_where_the_floor_is_does_not_matter(shift):
    take = with_artefact(person(), "m5", *ARTEFACTS[2][1:])
    moved = take.with_positions(take.positions + np.array(shift))
    key = [(f.id, round(f.strength, 3)) for f in detect(take)]
    assert [(f.id, round(f.strength, 3)) for f in detect(moved)] == key


def test_it_finds_the_same_again():
    take = with_artefact(person(), "m5", *ARTEFACTS[1][1:])
    assert [f.to_json() for f in detect(take)] == [f.to_json() for f in detect(take)]


def test_windows_follow_the_rate():
    """A step of half a second is found at every rate, in frames of that rate."""
    for rate in (50.0, 100.0, 250.0):
        take = person(int(15 * rate), rate)
        span = Span(int(4 * rate), int(4.5 * rate))
        found = detect(with_artefact(take, "m5", span, 15.0), kinds=["step"])
        assert [(f.marker, f.span) for f in found if f.marker == "m5"] == [("m5", span)]


def test_gaps_are_gaps_and_nothing_else():
    positions = person().positions.copy()
    for m in range(8):
        positions[100 + 80 * m : 130 + 80 * m, m] = np.nan
    positions[:40, 0] = np.nan
    take = person().with_positions(positions)
    clean = [f for f in detect(person()) if f.kind != "gap"]
    found = detect(take)
    assert sum(f.kind == "gap" for f in found) == 9
    assert sum(f.kind != "gap" for f in found) <= len(clean) + 2
    assert not [f for f in found if f.kind != "gap" and not take.seen[f.span.frames].any()]


@pytest.mark.parametrize("n_frames", [1, 2, 3, 7, 20, 60])
@pytest.mark.parametrize("n_markers", [1, 2, 8])
def test_short_takes_and_few_markers(n_frames, n_markers):
    take = person(n_frames)
    detect(Take(take.positions[:, :n_markers], 100.0, take.labels[:n_markers]))


def test_unseen_markers_two_dimensions_and_no_markers():
    positions = person(200).positions.copy()
    positions[:, 3] = np.nan
    positions[5:, 4] = np.nan
    detect(person(200).with_positions(positions))
    detect(person(200).with_positions(np.full_like(positions, np.nan)))
    flat = with_artefact(person(n_dims=2), "m5", Span(400, 450), 20.0, (0, 1))
    assert {"x", "y"} >= {a for f in detect(flat) for a in f.axes if f.kind == "step"} > set()
    assert detect(Take(np.zeros((50, 0, 3)), 100.0, [])) == ()


def test_only_measured_markers_are_looked_at():
    take = with_artefact(person(), "m5", Span(400, 401), 12.0)
    hidden = Take(take.positions, 100.0, [*take.labels[:5], "*1", *take.labels[6:]])
    assert "*1" not in {f.marker for f in detect(hidden)}


def test_as_printed_finds_no_peak_and_floods_otherwise():
    take = with_artefact(person(), "m5", Span(400, 401), 12.0)
    printed = detect(take, as_printed=True)
    assert not [f for f in printed if f.kind in ("peak", "noise")]
    assert {f.kind for f in printed} <= {"step", "slow"}


def test_as_printed_floods(shared):
    take = real_take(shared)
    assert len(detect(take, as_printed=True)) > 10 * len(detect(take))


def test_network_as_predictor_finds_a_slow_change():
    span = Span(380, 460)
    take = with_artefact(person(), "m5", span, 30.0 * triangle(80), (0,))
    found = detect(take, kinds=["slow"], predictor="ffnn")
    assert any(f.marker == "m5" and f.span.iou(span) > 0.5 and f.axes == ("x",) for f in found)


def test_printed_thresholds_fire_more_often():
    take = person()
    assert len(detect(take, peak_k=3.0)) > len(detect(take))


def test_parameters_are_checked():
    with pytest.raises(BadParameter, match=r"peak_k must be a number in 0\.5 to 50"):
        detect(person(50), peak_k=-1)
    method = DETECTORS.get("published")
    assert all(p.doc and (p.bounds or p.type is bool) for p in method.parameters)


def real_take(shared):
    folder = shared / "protocols" / "detection"
    info = json.loads((folder / "datasets.json").read_text())["vicon_pyomeca"]
    return Take(np.load(folder / "data" / "vicon_pyomeca.npy"), 100.0, info["labels"])


def test_real_take(shared):
    take = real_take(shared)
    knee = take.labels[infer(take).clusters[1][0]]
    found = detect(with_artefact(take, knee, Span(100, 140), 25.0))
    assert [
        f
        for f in found
        if f.marker == knee and f.kind == "step" and f.span.iou(Span(100, 140)) > 0.9
    ]
