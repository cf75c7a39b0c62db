"""Ways into a gap: what they reproduce, and that kriging is what the textbook says."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from markermend.repairing.kriging import krige, matern32, matern52, operators

INSIDE = np.arange(30) / 100
BOTH = np.concatenate([np.arange(-12, 0), np.arange(30, 42)]) / 100
KINDS = [(way.name, way.weights) for way in operators(INSIDE, BOTH)]


@pytest.mark.parametrize(("name", "weights"), KINDS, ids=[name for name, _ in KINDS])
def test_constants_are_kept_unless_the_mean_is_known_to_be_zero(name, weights):
    carried = weights @ np.full(len(BOTH), 7.0)
    if "Matérn" in name and "mean" not in name:
        assert (carried <= 7.0 + 0.1).all()
        assert carried[0] > 6.0 or "0.04" in name
    else:
        np.testing.assert_allclose(carried, 7.0, atol=1e-6)


@pytest.mark.parametrize("name", ["ramp", "Hermite", "cubic spline"])
def test_straight_lines_are_kept(name):
    weights = dict(KINDS)[name]
    np.testing.assert_allclose(weights @ (3 * BOTH - 1), 3 * INSIDE - 1, atol=1e-9)


def test_value_and_slope_are_met_at_both_edges():
    path = np.sin(6 * BOTH)
    for name in ("Hermite", "cubic spline", "Matérn 5/2 of 0.25 s"):
        filled = np.concatenate([path[:12], dict(KINDS)[name] @ path, path[12:]])
        assert np.abs(np.diff(filled, n=2)[9:13]).max() < 0.02, name
        assert np.abs(np.diff(filled, n=2)[-13:-9]).max() < 0.02, name


@pytest.mark.parametrize("kernel", [matern32, matern52])
def test_simple_kriging_is_the_conditional_mean_of_the_process(kernel):
    lag = np.subtract.outer(np.r_[INSIDE, BOTH], np.r_[INSIDE, BOTH]) / 0.2
    covariance = kernel(lag) + 1e-4 * np.diag(np.r_[np.zeros(30), np.ones(24)])
    precision = np.linalg.inv(covariance)
    by_precision = -np.linalg.solve(precision[:30, :30], precision[:30, 30:])
    np.testing.assert_allclose(krige(INSIDE, BOTH, kernel, 0.2), by_precision, atol=1e-5)


@given(st.integers(1, 12), st.integers(1, 60), st.booleans())
def test_one_side_is_enough_and_never_runs_away(n_boundary, length, before):
    boundary = np.arange(n_boundary) / 100
    inside = np.arange(length) / 100
    inside = inside + (n_boundary / 100) if before else inside - (length / 100)
    for way in operators(inside, boundary):
        assert way.weights.shape == (length, n_boundary)
        assert np.isfinite(way.weights).all()
        if way.name == "ramp":
            np.testing.assert_allclose(way.weights.sum(axis=1), 1.0)
