"""The picture of the body mesh: what is drawn stands where the markers are."""

import re

import holoviews as hv
import numpy as np
import pytest

import markermend as mm
from markermend.body import infer
from markermend_app.plots import mesh

from .conftest import made_take
from .test_plots import parts, rows_of


def test_the_mesh_is_drawn_where_the_markers_are():
    take = made_take()
    body = infer(take)
    picture = mesh.body_mesh(take, body, "small.c3d")
    x_up, y_up, tree = (panel.element for panel in picture.panels)
    frame = mesh.clearest_frame(take, body)
    assert take.seen[frame, list(body.order)].all()
    for element, axis in ((x_up, 0), (y_up, 1)):
        markers, badges = parts(element, hv.Points)
        assert {label: (x, z) for x, z, label in rows_of(markers)} == {
            take.labels[m]: pytest.approx(tuple(take.positions[frame, m, [axis, 2]]), rel=1e-5)
            for m in body.order
        }
        assert [number for *_, number in rows_of(badges)] == [1, 2]
        between, inside = parts(element, hv.Segments)
        assert (len(between), len(inside)) == (1, len(body.bones) - 1)
    _, lines = parts(tree, hv.Labels)
    written = [text for *_, text in rows_of(lines)]
    assert [set(re.findall(r"M\d", text.partition("(")[0])) for text in written] == [
        {body.labels[m] for m in cluster} for cluster in body.clusters
    ]
    parent = body.parent_markers[1]
    assert parent is not None
    assert written[1].endswith(f"(on {body.labels[parent]})")
    assert len(parts(tree, hv.Path)[0].split()) == 1


def test_a_long_cluster_is_wrapped_and_nothing_of_it_is_lost():
    rng = np.random.default_rng(3)
    way = rng.normal(size=(300, 1, 3)).cumsum(axis=0)
    labels = [f"MARKER{i:02}" for i in range(30)]
    body = infer(mm.Take(way + rng.normal(0, 100, (1, 30, 3)), 100, labels))
    _, lines = parts(mesh.tree(body), hv.Labels)
    written = [text for *_, text in rows_of(lines)]
    assert len(written) > body.n_clusters
    assert max(map(len, written)) <= mesh.LETTERS + len("  (on MARKER00)")
    assert {word for text in written for word in text.partition("(")[0].split()} == set(labels)


def test_what_is_not_seen_in_the_frame_is_left_out():
    take = made_take()
    positions = take.positions.copy()
    positions[:300, 0] = np.nan
    positions[300:, 1] = np.nan  # never seen together: no frame has all
    torn = take.with_positions(positions)
    body = infer(torn)
    frame = mesh.clearest_frame(torn, body)
    markers, _ = parts(mesh.stick_figure(positions[frame][:, [0, 2]], body), hv.Points)
    assert len(markers) == len(body.order) - 1


def test_a_picture_in_two_dimensions_has_one_view():
    rng = np.random.default_rng(0)
    take = mm.Take(rng.normal(size=(300, 6, 2)).cumsum(axis=0), 100, list("ABCDEF"), units="px")
    assert len(mesh.body_mesh(take, infer(take), "film").panels) == 2


def test_numbers_are_pushed_apart_and_lonely_ones_stay():
    points = np.array([[0.0, 0.0], [0.0, 0.0], [1.0, 0.0], [50.0, 50.0]])
    moved = mesh.apart(points, 10.0)
    assert moved[3].tolist() == [50.0, 50.0]
    away = np.linalg.norm(moved[:, None] - moved[None], axis=2)[np.triu_indices(4, 1)]
    assert away.min() > 9.5
