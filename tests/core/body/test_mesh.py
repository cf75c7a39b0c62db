"""The functional body mesh: laws on bodies made by hand, then real takes."""

import json
import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from markermend.body import infer
from markermend.errors import UnknownName
from markermend.model import Take

SHAPE = np.array([[0, 0, 0], [90, 0, 0], [0, 80, 0], [30, 30, 70]], float)


def rotations(angles):
    """(n, 3, 3) rotations about a slanted axis."""
    axis = np.array([0.6, 0.0, 0.8])
    K = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]], float)
    a = np.asarray(angles)[:, None, None]
    return np.eye(3) + np.sin(a) * K + (1 - np.cos(a)) * (K @ K)


def chain(n_parts=4, n_frames=300, seed=0):
    """Rigid parts of four markers in a row, each turning about the end of the one before."""
    rng = np.random.default_rng(seed)
    t = np.arange(n_frames) / 100.0
    root = np.stack([400 * np.sin(t), 300 * np.cos(0.7 * t), 900 + 50 * np.sin(3 * t)], 1)
    parts, R, angle = [], np.eye(3), np.zeros(n_frames)
    for part in range(n_parts):
        angle = angle + (0.5 + 0.2 * part) * np.sin((1.0 + 0.6 * part) * t + part)
        R = rotations(angle)
        parts.append(root[:, None] + np.einsum("fij,mj->fmi", R, SHAPE))
        root = root + np.einsum("fij,j->fi", R, np.array([300.0, 0, 0]))
    positions = np.concatenate(parts, axis=1)
    positions += rng.normal(0, 0.2, positions.shape)
    return positions


def take_of(positions, prefix=""):
    return Take(positions, 100.0, [f"{prefix}m{i}" for i in range(positions.shape[1])])


def test_rigid_parts_become_clusters_and_their_row_the_tree():
    body = infer(take_of(chain()))
    assert sorted(body.clusters) == [(0, 1, 2, 3), (4, 5, 6, 7), (8, 9, 10, 11), (12, 13, 14, 15)]
    part = {c: min(cluster) // 4 for c, cluster in enumerate(body.clusters)}
    links = {frozenset((part[c], part[p])) for c, p in enumerate(body.parents) if p is not None}
    assert links == {frozenset((0, 1)), frozenset((1, 2)), frozenset((2, 3))}
    assert set(body.siblings("m5")) == {4, 6, 7}
    for c, marker in enumerate(body.parent_markers):
        parent = body.parents[c]
        assert (marker is None) == (parent is None)
        assert parent is None or marker in body.clusters[parent]


def test_neighbours_come_in_the_order_of_rigidity():
    body = infer(take_of(chain()))
    assert set(body.neighbours("m9")[:3]) == {8, 10, 11}
    assert len(body.neighbours("m9")) == 15
    assert body.neighbours("m9", 2) == body.neighbours("m9")[:2]


@settings(max_examples=20, deadline=None)
@given(
    angle=st.floats(0, 6.28),
    shift=st.tuples(*[st.floats(-2000, 2000)] * 3),
    order=st.permutations(range(16)),
)
def test_shift_turn_and_order_of_markers_change_nothing(angle, shift, order):
    positions = chain(n_frames=120)
    turned = (positions @ rotations([angle])[0].T + np.array(shift))[:, list(order)]
    before, after = infer(take_of(positions)), infer(take_of(turned))
    back = {tuple(sorted(order[m] for m in cluster)) for cluster in after.clusters}
    assert back == set(before.clusters)
    bones = {tuple(sorted((order[a], order[b]))) for a, b in after.bones}
    assert bones == set(before.bones)


def test_bones_are_a_tree_per_subject():
    positions = chain()
    both = np.concatenate([positions, positions[::-1] + np.array([3000.0, 0, 0])], axis=1)
    labels = [f"{who}:m{i}" for who in ("Anna", "Bo") for i in range(16)]
    body = infer(Take(both, 100.0, labels))
    assert sum(parent is None for parent in body.parents) == 2
    assert len(body.bones) == 2 * 15
    for a, b in body.bones:
        assert (a < 16) == (b < 16)
    for parent, cluster in zip(body.parents, body.clusters, strict=True):
        assert parent is None or (min(body.clusters[parent]) < 16) == (min(cluster) < 16)


def test_gaps_artefacts_and_unseen_markers_do_not_disturb():
    positions = chain()
    whole = infer(take_of(positions))
    rng = np.random.default_rng(1)
    for m in range(16):
        start = rng.integers(0, 250)
        positions[start : start + 40, m] = np.nan
    positions[100, 3] += 500.0
    positions = np.concatenate([positions, np.full((300, 1, 3), np.nan)], axis=1)
    body = infer(take_of(positions))
    assert body.clusters == whole.clusters
    assert body.cluster(16) is None
    assert body.siblings(16) == body.neighbours(16) == ()
    assert body.parent(16) is None
    assert 16 not in body.order


def test_marker_that_is_seldom_seen_still_has_neighbours():
    positions = np.tile(chain(n_frames=500), (20, 1, 1))
    hidden = np.ones(len(positions), bool)
    hidden[4001:4030] = False
    positions[hidden, 2] = np.nan
    body = infer(take_of(positions))
    assert set(body.neighbours("m2", 3)) == {0, 1, 3}


@pytest.mark.parametrize("n_markers", [1, 2, 3, 5])
@pytest.mark.parametrize("n_frames", [1, 2, 50])
def test_small_takes(n_markers, n_frames):
    body = infer(take_of(chain()[:n_frames, :n_markers]))
    assert body.order == tuple(range(n_markers))
    assert body.n_clusters == 1
    assert len(body.bones) == n_markers - 1


def test_nothing_seen_and_two_dimensions():
    assert infer(take_of(np.full((10, 4, 3), np.nan))).n_clusters == 0
    flat = Take(chain()[:, :, :2], 100.0, [f"m{i}" for i in range(16)], units="px")
    assert len(infer(flat).bones) == 15


def test_unlabelled_trajectories_are_not_of_the_body():
    positions = chain()
    labels = [*(f"m{i}" for i in range(15)), "*16"]
    assert 15 not in infer(Take(positions, 100.0, labels)).order


def test_unknown_marker_is_refused():
    with pytest.raises(UnknownName, match="no marker 'knee'"):
        infer(take_of(chain())).siblings("knee")


def test_cost_does_not_grow_with_the_take():
    positions = np.tile(chain(n_parts=25, n_frames=400), (50, 1, 1))
    take = take_of(positions)
    infer(take_of(positions[:400]))
    started = time.process_time()
    infer(take)
    assert time.process_time() - started < 1.0


def test_parts_of_a_real_person(shared):
    folder = shared / "protocols" / "detection"
    info = json.loads((folder / "datasets.json").read_text())["zoo_HC033A10"]
    positions = np.load(folder / "data" / "zoo_HC033A10.npy")
    take = Take(positions, 100.0, info["labels"])
    body = infer(take)
    same = [("LFHD", "RBHD"), ("RWRA", "RWRB"), ("LASI", "RASI"), ("LANK", "LHEE")]
    other = [("LFHD", "SACR"), ("LWRA", "RWRA"), ("LANK", "RANK"), ("STRN", "LHEE")]
    assert all(body.cluster(a) == body.cluster(b) for a, b in same)
    assert all(body.cluster(a) != body.cluster(b) for a, b in other)
    # A skeleton, not a hairball: short lines, and a tree.
    lengths = [body.distance[a, b] for a, b in body.bones]
    assert len(lengths) == take.n_markers - 1
    assert np.median(lengths) < 250.0
