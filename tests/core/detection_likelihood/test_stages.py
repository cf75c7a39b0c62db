"""Each stage against a slower or simpler way to the same numbers."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from markermend.detection.likelihood import templates
from markermend.detection.likelihood.calibration import CURVES, probability
from markermend.detection.likelihood.filling import bridged, interpolated
from markermend.detection.likelihood.frames import best_rotations
from markermend.detection.likelihood.neighbours import steadiest
from markermend.detection.likelihood.prediction import predict_marker
from markermend.detection.likelihood.scales import rolling_quantile
from markermend.detection.likelihood.whitening import whiten

from .bodies import body


@given(st.integers(0, 2**32 - 1), st.integers(3, 6))
@settings(max_examples=40, deadline=None)
def test_rotations_are_those_of_kabsch(seed: int, k: int) -> None:
    rng = np.random.default_rng(seed)
    a = rng.normal(size=(k, 3)) * 100
    a -= a.mean(0)
    truth = Rotation.random(20, random_state=seed).as_matrix()
    b = np.einsum("kj,nji->nki", a, truth) + rng.normal(size=(20, k, 3))
    b -= b.mean(1, keepdims=True)
    H = np.einsum("nki,kj->ijn", b, a)
    found = best_rotations(H, ((a**2).sum() + (b**2).sum((1, 2))) / 2)
    for i in range(20):
        expected, _ = Rotation.align_vectors(a, b[i])
        np.testing.assert_allclose(found[:, :, i], expected.as_matrix(), atol=1e-6)


def test_points_on_one_spot_do_not_turn() -> None:
    found = best_rotations(np.zeros((3, 3, 2)), np.zeros(2))
    np.testing.assert_allclose(found, np.repeat(np.eye(3)[:, :, None], 2, axis=2))


@pytest.mark.parametrize("length", [1, 2, 3, 20])
def test_box_statistic_is_the_generalised_likelihood_ratio(length: int) -> None:
    """N / q is the generalised least-squares amplitude under the estimated spectrum."""
    rng = np.random.default_rng(1)
    series = np.cumsum(rng.normal(size=(3, 400)), axis=1) * 0.1
    whitened = whiten(series, 0.15)
    shape = np.ones(length)
    q = whitened.energy(shape)
    moved = series.copy()
    moved[:, 200 : 200 + length] += 5.0
    weight = whitened.weight  # the same spectrum for both, so that the change is exact
    padded = np.zeros((3, whitened.size))
    padded[:, 200 : 200 + length] = 5.0
    g = np.fft.irfft(np.fft.rfft(padded, axis=1) * weight, whitened.size, axis=1)
    N = g[:, 200 : 200 + length].sum(1)
    np.testing.assert_allclose(N / q, 5.0, rtol=1e-9)


@pytest.mark.parametrize("length", [5, 33, 79])
def test_triangles_from_cumulative_sums_equal_direct_correlation(length: int) -> None:
    series = np.random.default_rng(2).normal(size=(3, 200))
    whitened = whiten(series, 0.15)
    fast = templates.triangles(templates.sums(whitened), length)
    shape = templates.triangle_template(length)
    assert len(shape) == length
    assert shape.max() == pytest.approx(1.0)
    slow = np.array([np.correlate(g, shape, "valid") for g in whitened.g])
    np.testing.assert_allclose(fast, slow, atol=1e-8)


def test_no_frame_takes_part_in_predicting_itself() -> None:
    take = body()
    positions = np.array(take.positions)
    neighbours = steadiest(positions, take.seen, 10)[3]
    before = predict_marker(positions, take.seen, 3, neighbours)
    positions[300, 3] += (400.0, -300.0, 200.0)
    after = predict_marker(positions, take.seen, 3, neighbours)
    change = after.to_lab(after.residual)[300] - before.to_lab(before.residual)[300]
    np.testing.assert_allclose(change, (400.0, -300.0, 200.0), atol=0.05)


def test_prediction_of_a_rigid_part_is_as_good_as_its_noise() -> None:
    take = body(noise_mm=0.1)
    neighbours = steadiest(take.positions, take.seen, 16)
    made = predict_marker(np.array(take.positions), take.seen, 0, neighbours[0])
    assert np.sqrt(np.mean(made.residual**2)) < 1.0
    assert set(neighbours[0][:4].tolist()) <= set(range(7))


def test_model_repeats_its_own_residual_on_any_stretch() -> None:
    take = body()
    positions = np.array(take.positions)
    made = predict_marker(positions, take.seen, 2, steadiest(positions, take.seen, 10)[2])
    again = made.model.residual(positions[150:340], 150)
    np.testing.assert_allclose(again, made.residual[150:340], atol=1e-9)


def test_rolling_quantile_ignores_what_is_not_valid() -> None:
    values = np.tile(np.arange(100.0), (2, 1))
    valid = np.ones((2, 100), bool)
    values[1, 40:50] = 1e9
    valid[1, 40:50] = False
    found = rolling_quantile(values, valid, 20, 1, 0.5)
    assert found[0, 50] == 50.0
    assert found[1].max() < 100.0


def test_bridge_goes_straight_across() -> None:
    residual = np.zeros((30, 3))
    residual[20:] = 4.0
    residual[10:20] = 99.0
    flagged = np.zeros(30, bool)
    flagged[10:20] = True
    found = bridged(residual, flagged)
    np.testing.assert_allclose(found[10:20, 0], 4.0 * np.arange(1, 11) / 11)
    np.testing.assert_array_equal(found[~flagged], residual[~flagged])


def test_gaps_are_filled_linearly_and_ends_held() -> None:
    positions = np.arange(10.0)[:, None, None] * np.ones((10, 1, 3))
    seen = np.ones((10, 1), bool)
    seen[[0, 4, 5, 9]] = False
    positions[~seen[:, 0]] = np.nan
    found = interpolated(positions, seen)[:, 0, 0]
    np.testing.assert_allclose(found, [1, 1, 2, 3, 4, 5, 6, 7, 8, 8])


@pytest.mark.parametrize("kind", sorted(CURVES))
def test_probability_grows_with_strength(kind: str) -> None:
    p = [probability(kind, s) for s in np.geomspace(0.5, 100, 30)]
    assert 0.0 <= p[0] < p[-1] <= 1.0
    assert np.all(np.diff(p) >= 0.0)
