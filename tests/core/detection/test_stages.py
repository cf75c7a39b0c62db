"""Each published stage on signals worked out by hand (sections 3.4.2 to 3.5)."""

from dataclasses import replace

import numpy as np
import pytest

from markermend.detection.published import Settings
from markermend.detection.published.stages import (
    deviation,
    differential,
    fast_steps,
    heavy_noise,
    peak_candidates,
    peaks,
    slow_changes,
    steps,
)
from markermend.model import Span
from markermend.predict import savgol_highpass

SETTINGS = Settings(
    peak_window=19,
    peak_k=3.0,
    peak_ratio=5.0,
    peak_size=3,
    noise_k=2.0,
    noise_length=20,
    step_k=3.0,
    step_length=20,
    step_distance=200,
    savgol_order=5,
    savgol_window=13,
    slow_k=3.0,
    slow_low=0.5,
    slow_top=20,
    slow_length=50,
    predictor="polynomial",
    order=4,
    context=3,
    average=200,
    epochs=100,
)
N = 1000


def signal(add=(), noise=0.05, seed=0):
    x = np.random.default_rng(seed).normal(0, noise, (N, 1))
    x[:, 0] += 100 * np.sin(np.arange(N) / 100)
    for frames, values in add:
        x[frames, 0] += values
    return x


def look(stage, x, settings=SETTINGS):
    return stage(x, np.ones(x.shape, bool), settings)


def spans(stage):
    return [mark.span for mark in stage.marks]


def test_differential_and_deviation():
    x = np.array([[1.0], [3.0], [2.0], [9.0]])
    assert differential(x).ravel().tolist() == [0, 2, -1, 7]
    trusted = np.array([[True], [True], [True], [False]])
    assert deviation(x, trusted)[0] == pytest.approx(np.std([1, 3, 2]))
    assert deviation(x, ~trusted)[0] == 0.0


def test_ratio_of_a_peak_and_of_a_step_by_hand():
    """A peak goes 8 up and 8 down: sum 0, absolute sum 16; a step only up: ratio 1."""
    settings = replace(SETTINGS, peak_size=1)  # a window of five frames
    kept = np.zeros((12, 1))
    kept[5], kept[6] = 8.0, -8.0
    assert np.flatnonzero(peak_candidates(kept, settings)).tolist() == [4, 5, 6, 7]
    kept[6] = 0.0
    assert not peak_candidates(kept, settings).any()
    # Up 8 and down 4: |sum| 4, absolute sum 12, ratio 3.
    kept[6] = -4.0
    assert not peak_candidates(kept, settings).any()
    assert peak_candidates(kept, replace(settings, peak_ratio=2.9)).any()


def test_ratio_as_printed_never_exceeds_one():
    rng = np.random.default_rng(0)
    kept = rng.normal(size=(500, 3))
    assert not peak_candidates(kept, replace(SETTINGS, as_printed=True)).any()
    assert peak_candidates(kept, replace(SETTINGS, as_printed=True, peak_ratio=0.5)).any()


@pytest.mark.parametrize("sign", [1, -1])
def test_peak_is_found_with_its_frame_and_size(sign):
    stage = look(peaks, signal([(slice(500, 501), sign * 10.0)]))
    assert Span(500, 501) in spans(stage)
    best = max(stage.marks, key=lambda mark: mark.strength)
    assert best.span == Span(500, 501)
    assert best.amplitude == pytest.approx(10.0, abs=0.6)
    assert best.strength > 1.0


def test_three_frames_are_one_peak_and_a_step_is_none():
    settings = replace(SETTINGS, peak_k=8.0)
    three = look(peaks, signal([(slice(500, 503), 10.0)]), settings)
    assert spans(three) == [Span(500, 503)]
    assert not spans(look(peaks, signal([(slice(500, 560), 10.0)]), settings))


def test_peaks_close_to_each_other_are_not_isolated():
    x = signal([(slice(at, at + 1), 10.0) for at in range(480, 520, 4)])
    assert not [s for s in spans(look(peaks, x)) if 478 < s.start < 522]


def test_upward_only_as_printed():
    """Eq. 20 without the absolute value keeps the rising flank alone."""
    settings = replace(SETTINGS, as_printed=True, peak_ratio=0.9)
    x = signal([(slice(500, 501), 10.0)])
    assert not spans(look(peaks, x, settings))  # and the exchanged top-hat removes everything


def test_fast_steps_are_the_high_passed_differential():
    x = signal()
    assert fast_steps(x, SETTINGS) == pytest.approx(savgol_highpass(differential(x), 5, 13))


def test_heavy_noise_is_found_with_its_size():
    burst = np.random.default_rng(4).normal(0, 10.0, 50)
    stage = look(heavy_noise, signal([(slice(500, 550), burst)]))
    assert len(stage.marks) == 1
    mark = stage.marks[0]
    assert mark.span.iou(Span(500, 550)) > 0.75
    # White noise keeps its size through the filter's known gain; the span is a little wider.
    assert mark.amplitude == pytest.approx(10.0, rel=0.25)


def test_noise_shorter_than_min_len_is_rejected():
    burst = np.random.default_rng(4).normal(0, 10.0, 20)
    x = signal([(slice(500, 520), burst)])
    assert spans(look(heavy_noise, x, replace(SETTINGS, noise_length=20)))
    assert not spans(look(heavy_noise, x, replace(SETTINGS, noise_length=60)))


@pytest.mark.parametrize("sign", [1, -1])
def test_step_is_found_with_its_edges_and_size(sign):
    settings = replace(SETTINGS, step_k=6.0)
    stage = look(steps, signal([(slice(500, 550), sign * 10.0)]), settings)
    assert spans(stage) == [Span(500, 550)]
    assert stage.marks[0].amplitude == pytest.approx(10.0, abs=0.3)


def test_step_strength_is_the_smaller_edge_over_the_threshold():
    settings = replace(SETTINGS, step_k=6.0)
    x = signal([(slice(500, 550), 10.0)])
    stage = look(steps, x, settings)
    fast = np.abs(fast_steps(x, settings)[[500, 550], 0])
    threshold = 6.0 * fast_steps(x, settings).std()
    assert stage.threshold[0] == pytest.approx(threshold)
    assert stage.marks[0].strength == pytest.approx(fast.min() / threshold)


def test_slow_change_by_hysteresis():
    """T_U decides whether, T_L how far: a triangle is followed down to half a deviation."""
    r = np.random.default_rng(0).normal(0, 0.001, (N, 1))
    triangle = 10.0 * (1 - np.abs(np.arange(-50, 51)) / 51)
    r[450:551, 0] += triangle
    stage = look(slow_changes, r, replace(SETTINGS, slow_k=2.0))
    sigma = r.std()
    first = np.flatnonzero(r[:, 0] > 0.5 * sigma)
    assert spans(stage) == [Span(int(first[0]), int(first[-1]) + 1)]
    assert stage.marks[0].amplitude == pytest.approx(10.0, abs=0.01)
    assert stage.marks[0].strength == pytest.approx(r.max() / (2.0 * sigma), rel=1e-9)


def test_slow_change_as_valley_too_short_or_with_too_short_a_top():
    r = np.zeros((N, 1))
    r[400:460, 0] = -5.0
    loose = replace(SETTINGS, slow_k=2.0)
    assert spans(look(slow_changes, r, loose)) == [Span(400, 460)]
    assert not spans(look(slow_changes, r, replace(loose, slow_top=61)))
    assert not spans(look(slow_changes, r, replace(loose, slow_length=61)))


def test_nothing_moves_and_nothing_is_found():
    x = np.full((300, 2), 7.0)
    for stage in (peaks, heavy_noise, steps, slow_changes):
        assert not look(stage, x).marks
