"""Local frames: proper rotations, exact where the body is rigid, the best fit where it is not."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.distance import pdist
from scipy.spatial.transform import Rotation

from markermend.repairing.geometry import (
    defines_frame,
    distance_spread,
    kabsch,
    mean_shape,
)


def scene(seed, n_frames=12, n_points=4, n_dims=3):
    rng = np.random.default_rng(seed)
    shape = rng.normal(0, 100, (n_points, n_dims))
    if n_dims == 3:
        turn = Rotation.random(n_frames, random_state=seed).as_matrix()
    else:
        angle = rng.uniform(0, 6, n_frames)
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        turn = turn.transpose(2, 0, 1)
    way = rng.normal(0, 1000, (n_frames, 1, n_dims))
    return shape, turn, shape @ turn.transpose(0, 2, 1) + way


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10_000), st.sampled_from([2, 3]), st.integers(3, 8))
def test_a_rigid_body_is_found_exactly(seed, n_dims, n_points):
    shape, turn, points = scene(seed, n_points=n_points, n_dims=n_dims)
    frames = kabsch(shape, points, np.ones(n_points))
    np.testing.assert_allclose(frames.rotation, turn, atol=1e-6)
    np.testing.assert_allclose(np.linalg.det(frames.rotation), 1.0)
    np.testing.assert_allclose(frames.to_world(frames.to_local(points)), points)
    np.testing.assert_allclose(frames.to_local(points[:, 0]), frames.to_local(points)[:, 0])
    np.testing.assert_allclose(frames.to_world(frames.to_local(points[:, 0])), points[:, 0])


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10_000))
def test_no_other_rotation_fits_better(seed):
    rng = np.random.default_rng(seed)
    shape, _, points = scene(seed)
    points = points + rng.normal(0, 20, points.shape)
    weights = rng.uniform(0.1, 1, 4)
    frames = kabsch(shape, points, weights)
    model = shape - np.average(shape, axis=0, weights=weights)

    def misfit(turn):
        rest = points - frames.origin[:, None] - model @ turn.transpose(0, 2, 1)
        return (weights * np.square(rest).sum(axis=2)).sum(axis=1)

    nudge = Rotation.from_rotvec(rng.normal(0, 0.05, 3)).as_matrix()
    assert (misfit(frames.rotation) <= misfit(frames.rotation @ nudge) + 1e-9).all()


def test_points_not_seen_are_left_out():
    shape, turn, points = scene(3, n_points=5)
    points[2, 1] = np.nan
    points[5] = np.nan
    frames = kabsch(shape, points, np.ones(5))
    np.testing.assert_allclose(frames.rotation[2], turn[2], atol=1e-9)
    assert np.isnan(frames.rotation[5]).all()
    assert np.isnan(frames.origin[5]).all()


@pytest.mark.parametrize(
    ("shape", "fixes"),
    [
        (np.eye(3) * 100, True),
        (np.eye(3)[:2], False),
        (np.outer(np.arange(5.0), [1, 2, 3]), False),
        (np.zeros((4, 3)), False),
        (np.array([[0.0, 0], [100, 0]]), True),
        (np.zeros((2, 2)), False),
    ],
)
def test_a_line_fixes_no_frame(shape, fixes):
    assert defines_frame(shape) is fixes


def test_spread_is_zero_on_one_body_and_infinite_without_common_frames():
    _, _, points = scene(4, n_points=3)
    others = np.concatenate([points[:, 1:], points[:, :1] * 1.1], axis=1)
    others[1:, 2] = np.nan
    spread, mean = distance_spread(points[:, 0], others)
    np.testing.assert_allclose(spread[:2], 0, atol=1e-9)
    np.testing.assert_allclose(mean[0], np.linalg.norm(points[0, 0] - points[0, 1]))
    assert spread[2] == mean[2] == np.inf


def test_a_mean_of_two_postures_has_no_first_one():
    _, _, points = scene(5)
    points += np.random.default_rng(0).normal(0, 5, points.shape)
    weights = np.array([1.0, 2, 3, 4])
    one, other = mean_shape(points[:2], weights), mean_shape(points[1::-1], weights)
    np.testing.assert_allclose(pdist(one), pdist(other))
