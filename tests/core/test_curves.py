"""Curves for screens: thinner, but without losing a spike."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import markermend as mm
from markermend import curves


@given(st.integers(1, 5000), st.integers(2, 400), st.integers(0, 10**6))
def test_thinning_keeps_the_extremes_and_the_size(n: int, most: int, seed: int):
    values = np.random.default_rng(seed).normal(size=(n, 2))
    indices, thin = curves.thinned(values, most)
    assert len(indices) == len(thin) <= max(most, 2)
    assert (np.diff(indices) >= 0).all()
    assert 0 <= indices[0] <= indices[-1] <= n - 1
    np.testing.assert_array_equal(thin.max(axis=0), values.max(axis=0))
    np.testing.assert_array_equal(thin.min(axis=0), values.min(axis=0))


def test_a_single_spike_stays_visible_and_gaps_stay_gaps():
    values = np.zeros((100_000, 1))
    values[77_777] = 5.0
    values[20_000:40_000] = np.nan
    _, thin = curves.thinned(values, 1000)
    assert np.nanmax(thin) == 5.0
    assert np.isnan(thin).any()


def test_speed_of_a_straight_motion():
    path = np.arange(50)[:, None] * np.array([3.0, 4.0, 0.0])
    np.testing.assert_allclose(curves.speed(path, 100.0), 500.0)
    assert np.isnan(curves.speed(path[:2], 100.0)).all()


def test_speed_map_is_a_mean_over_time_and_empty_where_nothing_is_seen():
    path = np.arange(400)[:, None, None] * np.array([1.0, 0.0, 0.0])
    positions = np.repeat(path, 2, axis=1)
    positions[:, 1] = np.nan
    take = mm.Take(positions, 100, ["A", "B"])
    shade = curves.speed_map(take, np.array([0, 1]), 20)
    assert shade.shape == (2, 20)
    np.testing.assert_allclose(shade[0], 100.0)
    assert np.isnan(shade[1]).all()


def test_outline_shows_a_small_spike_on_a_long_way():
    path = np.arange(200)[:, None, None] * np.array([10.0, 0.0, 0.0])
    path = path.copy()
    path[100, 0, 2] += 5.0
    take = mm.Take(path, 100, ["A"])
    outline, begins, ends = curves.shape(take, "A", mm.Span(100, 101))
    assert np.nanargmax(outline) == pytest.approx(len(outline) / 2, abs=1)
    assert np.nanmax(outline) == 1.0
    assert 0 < begins <= ends < 1
