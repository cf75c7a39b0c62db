"""Examples and laws of the whole detector on a small moving body."""

import os
import subprocess
import sys
from dataclasses import replace
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from markermend.detection import detect, scan, smallest_slow_changes
from markermend.detection.likelihood.findings import _windows
from markermend.detection.likelihood.star import confirmed, star_jumps
from markermend.detection.likelihood.window import Settings
from markermend.model import Finding, Span, Take

from .bodies import body

TRUTH = (
    ("m1", "peak", Span(100, 101)),
    ("m3", "step", Span(150, 200)),
    ("m5", "noise", Span(250, 300)),
    ("m9", "slow", Span(400, 451)),
    ("m9", "peak", Span(420, 421)),
    ("m11", "peak", Span(520, 521)),
)


def spoilt() -> Take:
    take = body()
    x = np.array(take.positions)
    rng = np.random.default_rng(5)
    x[100, 1] += (0, 8, 0)
    x[150:200, 3] += (9, 0, 0)
    x[250:300, 5] += rng.normal(0, 6, (50, 3))
    x[400:451, 9, 2] += 14 * (1 - np.abs(np.linspace(-1, 1, 53)[1:-1]))
    x[420, 9] += (0, 12, 0)
    x[520, 11] += (-7, 7, 0)
    return take.with_positions(x)


@cache
def found() -> tuple[Finding, ...]:
    return scan(spoilt(), "likelihood")


def strong(findings: tuple[Finding, ...]) -> list[Finding]:
    return [f for f in findings if f.strength >= 1.0 and f.kind != "gap"]


def matches(findings: list[Finding], iou: float) -> list[tuple[str, str, Span]]:
    return [
        (marker, kind, span)
        for marker, kind, span in TRUTH
        if any(f.marker == marker and f.kind == kind and f.span.iou(span) >= iou for f in findings)
    ]


def test_every_kind_is_found_in_its_place_and_nothing_else() -> None:
    assert matches(strong(found()), 0.7) == list(TRUTH)
    assert len(strong(found())) == len(TRUTH)


def test_sudden_kinds_are_exact_to_the_frame() -> None:
    exact = {(f.marker, f.kind, f.span) for f in strong(found())}
    for truth in TRUTH:
        if truth[1] in ("peak", "step"):
            assert truth in exact


def test_a_peak_on_a_slow_change_shares_its_group() -> None:
    groups = {f.kind: f.group for f in strong(found()) if f.marker == "m9"}
    assert groups["peak"] == groups["slow"] is not None
    assert all(f.group is None for f in strong(found()) if f.marker != "m9")


def test_amplitudes_and_axes_are_those_put_in() -> None:
    by = {(f.marker, f.kind): f for f in strong(found())}
    assert by["m1", "peak"].amplitude == pytest.approx(8, abs=1.0)
    assert by["m1", "peak"].axes == ("y",)
    assert by["m3", "step"].amplitude == pytest.approx(9, abs=1.0)
    assert by["m9", "slow"].amplitude == pytest.approx(14, abs=3.0)
    assert by["m11", "peak"].axes == ("x", "y")


def test_a_clean_body_gives_nothing() -> None:
    assert strong(scan(body(), "likelihood")) == []


def test_evidence_shows_signal_prediction_threshold_and_template() -> None:
    for f in strong(found()):
        evidence = f.evidence
        assert evidence is not None
        assert evidence.prediction is not None
        assert evidence.signal.shape == (len(evidence.prediction),)
        assert evidence.start <= f.span.start
        assert f.span.stop <= evidence.start + len(evidence.signal)
        inside = slice(f.span.start - evidence.start, f.span.stop - evidence.start)
        assert np.abs(evidence.signal[inside]).max() > evidence.threshold > 0.0
        assert (evidence.template is None) == (f.kind == "noise")


def test_sensitivity_only_filters() -> None:
    take = spoilt()
    counts = [len(detect(take, "likelihood", sensitivity=s)) for s in (0.5, 1.0, 2.0)]
    assert counts == sorted(counts)
    assert all(f.strength >= 0.5 for f in found())
    ids = {f.id for f in detect(take, "likelihood", sensitivity=2.0)}
    assert {f.id for f in strong(found())} <= ids


@pytest.mark.parametrize("way", ["shift", "mirror", "rotation", "relabel"])
def test_findings_do_not_depend_on_where_the_body_is(way: str) -> None:
    take = spoilt()
    x = np.array(take.positions)
    labels = take.labels
    if way == "shift":
        x = x + np.array((5000.0, -300.0, 12.0))
    elif way == "mirror":
        x = x * (-1, 1, 1)
    elif way == "rotation":
        x = x @ Rotation.from_rotvec((0.4, -1.0, 0.7)).as_matrix().T
    else:
        order = np.random.default_rng(3).permutation(x.shape[1])
        x, labels = x[:, order], tuple(labels[i] for i in order)
    again = strong(scan(Take(x, take.rate, labels), "likelihood"))
    key = [(f.marker, f.span, f.kind) for f in strong(found())]
    assert sorted((f.marker, f.span, f.kind) for f in again) == sorted(key)
    strengths = {(f.marker, f.span): f.strength for f in strong(found())}
    for f in again:
        assert f.strength == pytest.approx(strengths[f.marker, f.span], rel=1e-6)


def test_findings_of_the_reversed_take_are_reversed() -> None:
    take = spoilt()
    back = strong(scan(take.with_positions(take.positions[::-1]), "likelihood"))
    n = take.n_frames
    turned = [Finding(f.marker, Span(n - f.span.stop, n - f.span.start), f.kind) for f in back]
    assert matches(turned, 0.6) == list(TRUTH)


def test_gaps_hide_what_is_in_them_and_invent_nothing() -> None:
    take = spoilt()
    x = np.array(take.positions)
    rng = np.random.default_rng(8)
    for m in (0, 2, 4, 6, 8, 10, 12, 13):
        start = int(rng.integers(0, 540))
        x[start : start + int(rng.integers(1, 80)), m] = np.nan
    x[:, 7] = np.nan
    gappy = strong(scan(take.with_positions(x), "likelihood"))
    # Neighbours are missing beside the slow change; whatever is sudden is still there.
    assert set(matches(gappy, 0.6)) >= {truth for truth in TRUTH if truth[1] != "slow"}
    assert len(gappy) <= len(TRUTH)


def test_a_swap_is_a_step_with_its_partner_on_both() -> None:
    take = body()
    x = np.array(take.positions)
    x[200:260, [2, 10]] = x[200:260, [10, 2]]
    steps = [f for f in strong(scan(take.with_positions(x), "likelihood")) if f.partner]
    assert {(f.marker, f.partner, f.span) for f in steps} == {
        ("m2", "m10", Span(200, 260)),
        ("m10", "m2", Span(200, 260)),
    }
    assert all(f.kind == "step" for f in steps)


@pytest.mark.parametrize(("frames", "markers"), [(1, 5), (20, 12), (250, 12), (300, 3), (300, 1)])
def test_short_takes_and_few_markers_do_not_flood(frames: int, markers: int) -> None:
    take = body(n_frames=max(frames, 30))
    few = Take(take.positions[:frames, :markers], 100.0, take.labels[:markers])
    assert len(strong(scan(few, "likelihood"))) <= 1


def test_a_peak_is_found_without_any_neighbour() -> None:
    take = body()
    x = np.array(take.positions[:, :1])
    x[200, 0, 0] += 15.0
    alone = strong(scan(Take(x, 100.0, ["m0"]), "likelihood"))
    assert [(f.kind, f.span) for f in alone] == [("peak", Span(200, 201))]


def test_two_dimensions_work() -> None:
    take = body()
    x = np.array(take.positions[:, :7, :2])
    x[300, 2] += (9.0, 0.0)
    flat = Take(x, 100.0, take.labels[:7], units="px")
    peaks = [f for f in strong(scan(flat, "likelihood")) if f.kind == "peak"]
    assert [(f.marker, f.span, f.axes) for f in peaks] == [("m2", Span(300, 301), ("x",))]


def test_long_takes_are_scanned_in_windows_without_doubles() -> None:
    take = body(n_frames=5200, per_part=2)
    x = np.array(take.positions)
    for t in range(90, 5200, 230):
        x[t, t % 4, 1] += 12.0
    peaks = strong(scan(take.with_positions(x), "likelihood"))
    assert len({f.id for f in peaks}) == len(peaks)
    places = sorted((f.span.start, f.marker) for f in peaks if f.kind == "peak")
    assert places == [(t, f"m{t % 4}") for t in range(90, 5200, 230)]


@pytest.mark.parametrize(
    ("n_frames", "pace"), [(2880, 1.0), (2881, 1.0), (30_000, 1.0), (19_000, 5)]
)
def test_windows_cover_the_take_and_own_every_frame_once(n_frames: int, pace: float) -> None:
    windows = _windows(n_frames, pace)
    assert windows[0][0] == 0
    assert windows[-1][1] == n_frames
    assert len({stop - start for start, stop, _, _ in windows}) == 1
    for (_, stop, _, high), (start, _, low, _) in pairwise(windows):
        assert high == low
        assert stop - start >= 180 * pace
        assert start + 90 * pace <= low <= stop - 90 * pace
    assert sum(stop - start for start, stop, _, _ in windows) <= 1.08 * n_frames + 900


@pytest.mark.parametrize("factor", [2, 4])
def test_kinds_last_in_seconds_not_in_frames(factor: int) -> None:
    take = body(n_frames=600 * factor)
    x = np.array(take.positions)
    t = np.arange(600 * factor)
    x[130 * factor : 380 * factor, 3, 0] += 9.0
    x[:, 9, 2] += 16 * np.clip(1 - np.abs(t / factor - 480) / 26, 0, None)
    found = strong(scan(Take(x, 100.0 * factor, take.labels), "likelihood"))
    assert [(f.marker, f.kind) for f in found] == [("m3", "step"), ("m9", "slow")]
    assert found[0].span == Span(130 * factor, 380 * factor)


def test_the_reach_tells_what_would_be_seen() -> None:
    take = body()
    table = {r.marker: r for r in smallest_slow_changes(take)}
    assert smallest_slow_changes(take, Settings(take.rate)) == tuple(table.values())
    assert set(table) == set(take.labels)
    for r in table.values():
        assert 1.5 <= r.usual_mm <= r.fast_mm < 30.0
    x = np.array(take.positions)
    x[300:351, 4, 0] += 3 * table["m4"].fast_mm * (1 - np.abs(np.linspace(-1, 1, 53)[1:-1]))
    slow = [f for f in strong(scan(take.with_positions(x), "likelihood")) if f.kind == "slow"]
    assert [f.marker for f in slow] == ["m4"]


@pytest.mark.parametrize(("shape", "called"), [("hump", []), ("triangle", ["m4"])])
def test_a_short_hump_is_movement_and_the_shortest_slow_change_is_not(
    shape: str, called: list[str]
) -> None:
    take = body()
    x = np.array(take.positions)
    bump = np.hanning(25) if shape == "hump" else 1 - np.abs(np.linspace(-1, 1, 35)[1:-1])
    x[300 : 300 + len(bump), 4, 0] += 8 * bump
    found = strong(scan(take.with_positions(x), "likelihood"))
    assert [(f.marker, f.kind) for f in found] == [(m, "slow") for m in called]


def test_the_check_without_a_model_confirms_what_jumps() -> None:
    jumps = star_jumps(spoilt())
    assert {(j.marker, j.frame) for j in jumps} >= {("m3", 150), ("m3", 200), ("m11", 520)}
    assert star_jumps(body()) == ()
    ids = confirmed(found(), jumps)
    by = {(f.marker, f.kind): f.id for f in strong(found())}
    assert by["m3", "step"] in ids
    assert by["m5", "noise"] in ids
    assert by["m11", "peak"] in ids
    assert by["m9", "slow"] not in ids
    elsewhere = [replace(f, span=Span(f.span.start + 20, f.span.stop + 23)) for f in found()]
    assert not confirmed([f for f in elsewhere if f.kind in ("peak", "step")], jumps)


def test_the_same_with_any_number_of_threads() -> None:
    code = (
        "from tests.core.detection_likelihood.test_detector import spoilt\n"
        "from markermend.detection.run import scan\n"
        "print([(f.id, f.strength, f.amplitude) for f in scan(spoilt(), 'likelihood')])"
    )
    root = str(Path(__file__).resolve().parents[3])
    shown = [
        subprocess.run(
            [sys.executable, "-c", code],
            env=os.environ | {"OMP_NUM_THREADS": n, "OPENBLAS_NUM_THREADS": n, "PYTHONPATH": root},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for n in ("1", "2")
    ]
    assert shown[0] == shown[1]
