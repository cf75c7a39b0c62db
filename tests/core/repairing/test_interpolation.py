"""Methods that look at the marker's own trajectory only."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline, PchipInterpolator
from scipy.signal import savgol_filter

from markermend.errors import CannotRepair
from markermend.model import Span, Take
from markermend.repairing.run import repair

RATE = 100.0
SPAN = Span(60, 75)


def curve(values, kind="gap", span=SPAN, method="pchip", **parameters):
    """Repair one marker whose three axes are the same curve."""
    positions = np.repeat(np.asarray(values, float)[:, None, None], 3, axis=2)
    take = Take(positions, RATE, ["A"])
    return repair(take, "A", span, method, kind=kind, **parameters).values[:, 0]


def wave(n=200, seed=0):
    rng = np.random.default_rng(seed)
    t = np.arange(n) / RATE
    phases = rng.uniform(0, 6, 3)
    return sum(
        a * np.sin(2 * np.pi * f * t + p)
        for a, f, p in zip([80, 30, 5], [0.7, 1.5, 4], phases, strict=True)
    )


@pytest.mark.parametrize(
    ("method", "whole"), [("pchip", PchipInterpolator), ("spline", CubicSpline)]
)
def test_the_bounded_context_gives_what_the_whole_take_gives(method, whole):
    values = wave(1000)
    span = Span(500, 520)
    known = np.r_[0:500, 520:1000]
    expected = whole(known, values[known])(np.arange(500, 520))
    np.testing.assert_allclose(curve(values, span=span, method=method), expected, atol=1e-9)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 1000), st.integers(1, 30))
def test_pchip_does_not_overshoot(seed, length):
    values = np.random.default_rng(seed).normal(0, 50, 120).cumsum()
    filled = curve(values, span=Span(60, 60 + length))
    low, high = sorted((values[59], values[60 + length]))
    assert low - 1e-9 <= filled.min()
    assert filled.max() <= high + 1e-9


def test_a_spline_reproduces_a_cubic():
    t = np.linspace(-1, 1, 200)
    values = 100 * t**3 - 50 * t
    np.testing.assert_allclose(curve(values, method="spline"), values[60:75], atol=1e-9)


@pytest.mark.parametrize(("order", "window"), [(3, 21), (5, 41), (5, 101)])
def test_savgol_smooths_as_scipy_does(order, window):
    """scipy's own filter is a foreign reference where its basis is still accurate."""
    rng = np.random.default_rng(3)
    values = wave(300) + rng.normal(0, 3, 300)
    expected = savgol_filter(values, window, order)[100:160]
    found = curve(
        values, kind="noise", span=Span(100, 160), method="savgol", order=order, window=window
    )
    np.testing.assert_allclose(found, expected, atol=1e-6)


def test_savgol_of_order_13_is_accurate_far_from_frame_0():
    t = np.linspace(-1, 1, 101)
    values = np.r_[np.zeros(50_000), 1000 * t**13, np.zeros(100)]
    found = curve(values, kind="noise", span=Span(50_050, 50_051), method="savgol")
    np.testing.assert_allclose(found, 0.0, atol=1e-8)
    bridged = curve(values[50_000:50_101], span=Span(45, 56), method="savgol")
    np.testing.assert_allclose(bridged, values[50_045:50_056], atol=1e-6)


def test_savgol_refuses_a_gap_beyond_half_its_window():
    with pytest.raises(CannotRepair, match="51 frames, more than half the window of 101"):
        curve(wave(), span=Span(60, 111), method="savgol")


def test_neighbouring_masked_spans_are_not_trusted():
    """The edge is the next frame that no other repair is about to change."""
    values = wave()
    positions = np.repeat(values[:, None, None], 3, axis=2)
    positions[75:80] += 500
    take = Take(positions, RATE, ["A"])
    masked = [("A", Span(75, 80))]
    for method in ("linear", "pchip", "spline", "savgol"):
        filled = repair(take, "A", Span(60, 75), method, masked=masked).values[:, 0]
        np.testing.assert_allclose(filled, values[60:75], atol=30)
