"""The meshes of the 3D view, and the component's side of Python, without a browser."""

import numpy as np
import pytest

from markermend_app.plots import scene
from markermend_app.views.scene import Focus, SceneView


def body(n_frames: int = 50) -> np.ndarray:
    """Markers of someone tall who walks along x, z up."""
    rng = np.random.default_rng(3)
    markers = rng.uniform([-200, -250, 0], [200, 250, 1800], (20, 3))
    walked = np.linspace(0, 2000, n_frames)
    return markers + np.stack([walked, 0 * walked, 0 * walked], axis=1)[:, None]


@pytest.mark.parametrize("up", [0, 1, 2])
def test_whatever_points_up_in_the_file_points_along_z_on_the_screen(up: int) -> None:
    upright = body()
    as_filed = upright[..., {0: (2, 0, 1), 1: (1, 2, 0), 2: (0, 1, 2)}[up]]
    assert scene.up_axis(as_filed) == up
    np.testing.assert_allclose(scene.z_up(as_filed, up), upright, rtol=1e-6)


def test_turning_keeps_left_and_right() -> None:
    for up in range(3):
        assert np.linalg.det(scene.z_up(np.eye(3), up)) == pytest.approx(1.0)


def test_pictures_stand_upright() -> None:
    flat = np.array([[[10.0, 20.0], [10.0, 50.0]]])
    upper, lower = scene.z_up(flat, scene.up_axis(flat))[0]
    assert upper[2] > lower[2], "pixels count downwards"


def test_floor_lies_under_the_take_and_fades_towards_its_rim() -> None:
    around = scene.surroundings(body(), 2)
    floor = scene.floor_grid(around)
    inside = np.all(
        (floor.points[:, :2] >= around.low[:2]) & (floor.points[:, :2] <= around.high[:2]), axis=1
    )
    assert inside.any()
    assert np.all(floor.point_data["fade"][inside] == 1)
    assert floor.point_data["fade"].min() == 0
    assert np.all(floor.points[:, 2] == 0)
    assert floor.n_lines < 4 * scene.FLOOR_LINES**2


def test_floor_of_a_take_above_or_below_zero_follows_it() -> None:
    for height in (-500.0, 2000.0):
        around = scene.surroundings(body() + np.array([0, 0, height]), 2)
        assert scene.floor_height(around) == pytest.approx(around.low[2])


def test_bones_are_lines_between_markers_and_unseen_ones_are_marked() -> None:
    points = body()[0]
    points[3] = np.nan
    mesh = scene.skeleton(points, [(0, 1), (1, 2)])
    assert mesh.lines.tolist() == [2, 0, 1, 2, 1, 2]
    assert np.flatnonzero(~mesh.point_data["seen"].astype(bool)).tolist() == [3]
    assert np.isfinite(mesh.points).all()


def test_shapes_have_their_sizes_and_reach_the_browser_whole() -> None:
    for name, mesh in scene.shapes().items():
        sent = scene.buffers(mesh)
        points = np.frombuffer(sent["points"], "<f4").reshape(-1, 3)
        np.testing.assert_allclose(points, mesh.points, atol=1e-6)
        polys = np.frombuffer(sent["polys"], "<u4").reshape(-1, 4)
        assert (polys[:, 0] == 3).all(), name
        assert polys[:, 1:].max() < len(points)
        assert np.abs(points).max() == pytest.approx(1, abs=1e-6)


def test_trail_can_be_broken_anywhere() -> None:
    assert scene.trail(5).lines.tolist() == [2, 0, 1, 2, 2, 3, 2, 4, 5, 2, 6, 7]


def test_sides_come_from_pairs_of_labels_only() -> None:
    labels = ["LKNE", "RKNE", "LUMBAR", "C7", "Ann:LANK", "Ann:RANK", "RANK"]
    assert scene.sides(labels).tolist() == [1, -1, 0, 0, 1, -1, 0]


@pytest.mark.parametrize("shape", [(1, 1, 3), (3, 1, 2), (2, 5, 3)])
def test_nothing_seen_is_shown_as_nothing(shape: tuple[int, int, int]) -> None:
    view = SceneView()
    view.show_take(np.full(shape, np.nan), 100.0, [f"M{i}" for i in range(shape[1])], [])
    assert view.scene["n_frames"] == shape[0]


def test_chunks_cover_the_take_once_and_carry_what_is_current() -> None:
    positions = np.arange(5000 * 60 * 3, dtype=float).reshape(5000, 60, 3)
    view, sent = SceneView(), []
    view._send_msg = sent.append
    view.show_take(positions, 100.0, [f"M{i}" for i in range(60)], [])
    size = view.scene["chunk_frames"]
    n_chunks = -(-5000 // size)
    assert n_chunks > 1
    for chunk in range(n_chunks):
        view._handle_msg({"type": "want", "take": view.scene["id"], "chunk": chunk})
    data = np.concatenate([np.frombuffer(m["data"], "<f4") for m in sent]).reshape(-1, 60, 3)
    np.testing.assert_array_equal(data, scene.z_up(positions, view._up))

    mended = positions.copy()
    mended[10:20, 7] += 5
    view.amend(7, (10, 20), mended[10:20, 7])
    patch = sent[-1]
    assert (patch["type"], patch["marker"], patch["start"]) == ("patch", 7, 10)
    np.testing.assert_array_equal(
        np.frombuffer(patch["data"], "<f4").reshape(-1, 3),
        scene.z_up(mended[10:20, 7], view._up),
    )
    view._handle_msg({"type": "want", "take": view.scene["id"], "chunk": 0})
    first = np.frombuffer(sent[-1]["data"], "<f4").reshape(-1, 60, 3)
    np.testing.assert_array_equal(first, scene.z_up(mended[: len(first)], view._up))
    view.amend(7, (10, 20), None)
    np.testing.assert_array_equal(
        np.frombuffer(sent[-1]["data"], "<f4").reshape(-1, 3),
        scene.z_up(positions[10:20, 7], view._up),
    )


def test_requests_of_a_former_take_are_dropped() -> None:
    view, sent = SceneView(), []
    view._send_msg = sent.append
    view.show_take(body(), 100.0, [f"M{i}" for i in range(20)], [])
    former = view.scene["id"]
    view.show_take(body(), 100.0, [f"M{i}" for i in range(20)], [])
    view._handle_msg({"type": "want", "take": former, "chunk": 0})
    view._handle_msg({"type": "pick", "take": former, "marker": 4})
    assert sent == []
    assert view.selected == -1


def test_a_finding_is_published_whole() -> None:
    view = SceneView()
    view.show_take(body(), 100.0, [f"M{i}" for i in range(20)], [])
    seen: list[tuple[int, int]] = []
    view.param.watch(lambda *_: seen.append((view.selected, view.focus["marker"])), ["focus"])
    view.show_focus(Focus(4, 10, 20, "#9A0088", (1, 2), None, body()[10:20, 4]))
    assert seen == [(4, 4)]
    assert view.focus["raw"] is None
    assert len(view.focus["repaired"]) == 10 * 3 * 4
