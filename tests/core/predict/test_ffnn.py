"""The feed-forward network (Eq. 10, 11) and its training."""

import numpy as np
import pytest

from markermend.body import infer
from markermend.model import Take
from markermend.predict import ffnn, scg
from markermend.predict.ffnn import moving_average


def moving_take(n_frames=500, n_markers=5, seed=3):
    rng = np.random.default_rng(seed)
    t = np.arange(n_frames)[:, None, None] / 100.0
    base = 200 * np.sin(t * np.array([1.1, 0.7, 1.9]) + np.array([0, 1, 2]))
    offset = rng.normal(0, 150, (n_markers, 3))
    return Take(base + offset + rng.normal(0, 0.2, (n_frames, n_markers, 3)), 100.0, list("abcde"))


def test_gradient_is_that_of_the_loss():
    rng = np.random.default_rng(0)
    shape = scg.Shape((4, 3, 5, 2))
    weights = scg.initial(shape, [1, 2])
    inputs, targets = rng.normal(size=(2, 7, 4)), rng.normal(size=(2, 7, 2))
    mass = rng.uniform(size=(2, 7, 1))
    mass /= mass.sum(axis=1, keepdims=True)
    _, gradient = scg.loss_and_gradient(shape, weights, inputs, targets, mass)
    for place in range(0, shape.n_weights, 3):
        for network in (0, 1):
            losses = []
            for sign in (1, -1):
                moved = weights.copy()
                moved[network, place] += sign * 1e-6
                loss, _ = scg.loss_and_gradient(shape, moved, inputs, targets, mass)
                losses.append(loss[network])
            slope = (losses[0] - losses[1]) / 2e-6
            assert gradient[network, place] == pytest.approx(slope, abs=1e-7)


def test_training_never_raises_the_error_and_learns():
    rng = np.random.default_rng(0)
    shape = scg.Shape((2, 12, 20, 1))
    inputs = rng.uniform(-2, 2, (3, 200, 2))
    targets = np.sin(inputs[..., :1]) * inputs[..., 1:]
    mass = np.full((3, 200, 1), 1 / 200)
    weights = scg.initial(shape, [1, 2, 3])
    before = np.full(3, np.inf)
    for _ in range(6):
        weights = scg.train(shape, weights, inputs, targets, mass, 25)
        after, _ = scg.loss_and_gradient(shape, weights, inputs, targets, mass)
        assert (after <= before).all()
        before = after
    assert (2 * before < 0.05 * targets.var()).all()


def test_a_network_does_not_depend_on_its_batch():
    rng = np.random.default_rng(0)
    shape = scg.Shape((3, 4, 6, 2))
    inputs, targets = rng.normal(size=(3, 50, 3)), rng.normal(size=(3, 50, 2))
    mass = np.full((3, 50, 1), 0.02)
    together = scg.train(shape, scg.initial(shape, [5, 6, 7]), inputs, targets, mass, 20)
    alone = scg.train(shape, scg.initial(shape, [6]), inputs[1:2], targets[1:2], mass[1:2], 20)
    assert alone[0] == pytest.approx(together[1], abs=1e-6)


def test_width_of_the_published_network():
    """12, then 4 * 5 neurons, 3 * 5 outputs; a parent and six siblings with k = 1, L = 2."""
    width = 7 * 3 * 2 * 2 + 3
    weights = (width + 1) * 12 + 13 * 20 + 21 * 15
    assert scg.Shape((width, 12, 20, 15)).n_weights == weights


def test_moving_average_by_hand():
    values = np.array([[1.0], [2.0], [3.0], [100.0], [5.0]])
    trusted = np.array([True, True, True, False, True])
    averaged = moving_average(values, trusted, 3).ravel()
    assert averaged == pytest.approx([1.5, 2.0, 2.5, 4.0, 5.0])
    assert moving_average(values, np.zeros(5, bool), 3).ravel() == pytest.approx([22.2] * 5)


def test_it_predicts_from_the_neighbours():
    take = moving_take()
    trusted = np.ones((500, 5), bool)
    trusted[200:280, 2] = False
    hidden = take.positions.copy()
    hidden[200:280, 2] += 300.0
    predicted = ffnn(hidden, trusted, infer(take), range(5), epochs=150)
    error = predicted - take.positions
    assert predicted.shape == (500, 5, 3)
    assert error.std() < 0.03 * take.positions.std(axis=0).mean()
    # Over the hidden span it follows the neighbours and not what was recorded.
    assert np.abs(error[200:280, 2]).max() < 40.0


def test_it_is_seeded_and_replicas_differ_in_seed_only():
    take = moving_take()
    trusted, body = np.ones((500, 5), bool), infer(take)
    first = ffnn(take.positions, trusted, body, [1, 3], epochs=5)
    assert np.array_equal(first, ffnn(take.positions, trusted, body, [1, 3], epochs=5))
    other = ffnn(take.positions, trusted, body, [1, 3], epochs=5, seed=1)
    assert not np.allclose(first, other)
    assert ffnn(take.positions, trusted, body, [3], epochs=5)[:, 0] == pytest.approx(
        first[:, 1], abs=1e-3
    )


def test_markers_without_neighbours_or_trust_stay_unknown():
    take = moving_take()
    trusted = np.ones((500, 5), bool)
    trusted[:, 4] = False
    predicted = ffnn(take.positions, trusted, infer(take), [0, 4], epochs=2)
    assert np.isfinite(predicted[:, 0]).all()
    assert np.isnan(predicted[:, 1]).all()
    alone = Take(take.positions[:, :1], 100.0, ["a"])
    assert np.isnan(ffnn(alone.positions, trusted[:, :1], infer(alone), [0], epochs=2)).all()


def test_two_dimensions():
    take = moving_take()
    flat = Take(take.positions[..., :2], 100.0, take.labels, units="px")
    predicted = ffnn(flat.positions, np.ones((500, 5), bool), infer(flat), [0], epochs=3)
    assert predicted.shape == (500, 1, 2)
