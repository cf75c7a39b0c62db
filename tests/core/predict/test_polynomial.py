"""The polynomial predictor P_k^L (Eq. 9)."""

import numpy as np
import pytest

from markermend.body import infer
from markermend.model import Take
from markermend.predict import polynomial
from markermend.predict.regressors import powers, regressor_markers, standardised, with_past


@pytest.fixture
def take():
    rng = np.random.default_rng(3)
    base = rng.normal(0, 1, (600, 1, 3)).cumsum(0) * 4
    wobble = rng.normal(0, 1, (600, 4, 3)).cumsum(0) * 0.2
    return Take(base + wobble + rng.normal(0, 200, (4, 3)), 100.0, list("abcd"))


def test_rows_by_hand():
    positions = np.array([[[1.0, 10.0]], [[2.0, 30.0]], [[3.0, 20.0]]])
    columns = powers(positions, [0], 2)
    z = standardised(positions[:, 0])
    assert z[:, 0] == pytest.approx([-(1.5**0.5), 0, 1.5**0.5])
    assert columns[:, :2] == pytest.approx(z)
    assert columns[:, 2:] == pytest.approx(standardised(z**2))
    rows = with_past(columns, np.arange(3), 1)
    assert rows[:, :4] == pytest.approx(columns)
    assert rows[2, 4:] == pytest.approx(columns[1])
    assert rows[0, 4:] == pytest.approx(columns[0])


def test_it_finds_a_polynomial_of_the_neighbours_present_and_past(take):
    positions = take.positions.copy()
    a = positions[:, 0]
    past = np.vstack([a[:1], a[:-1]])
    positions[:, 3] = 5 + 2 * a - 1e-4 * a**3 + 0.5 * past**2 / 100
    whole = Take(positions, 100.0, take.labels)
    body = infer(whole)
    predicted = polynomial(positions, np.ones(600, bool), body, 3, order=3, context=1)
    assert np.abs(predicted - positions[:, 3])[1:].max() < 0.05


def test_it_does_not_look_at_the_marker_itself(take):
    body = infer(take)
    trusted = np.ones(600, bool)
    trusted[200:260] = False
    before = polynomial(take.positions, trusted, body, 1)
    moved = take.positions.copy()
    moved[200:260, 1] += 100.0
    assert polynomial(moved, trusted, body, 1) == pytest.approx(before)


def test_least_squares_of_the_numbers_themselves(take):
    """The rank-revealing solve is plain least squares where that has a solution."""
    body = infer(take)
    others = list(regressor_markers(body, 0, 6))
    X = take.positions[:, others].reshape(600, -1)
    X = np.column_stack([np.ones(600), X])
    fit = X @ np.linalg.lstsq(X, take.positions[:, 0], rcond=None)[0]
    predicted = polynomial(take.positions, np.ones(600, bool), body, 0, order=1, context=0)
    assert predicted == pytest.approx(fit, abs=1e-6)


def test_no_neighbours_and_too_few_frames(take):
    alone = Take(take.positions[:, :1], 100.0, ["a"])
    assert polynomial(alone.positions, np.ones(600, bool), infer(alone), 0) is None
    few = np.zeros(600, bool)
    few[:5] = True
    assert polynomial(take.positions, few, infer(take), 0) is None


def test_root_cluster_uses_its_siblings(take):
    assert set(regressor_markers(infer(take), 0, 6)) == {1, 2, 3}
    assert len(regressor_markers(infer(take), 0, 2)) == 2
