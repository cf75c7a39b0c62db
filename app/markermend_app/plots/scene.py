"""What the 3D view consists of: pure functions from positions to meshes.

Everything that is seen is a `pyvista.PolyData` made here, in millimetres with z up. What stays
where it is (the floor) is drawn as it is; what moves is a unit shape (bone, disc, ring)
or a chain of segments (trail), which the browser puts in its place for every frame. No plotter is
ever made here: drawing is left to the browser.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pyvista as pv
from numpy.typing import NDArray

from markermend_app.style.tokens import TOKENS

Array = NDArray[np.float64]

TRAIL_POINTS = 121
FLOOR_STEP_MM = 400.0
FLOOR_MARGIN_MM = 1600.0
FLOOR_LINES = 60
FLOOR_AT_MOST_MM = 300.0
SAMPLED_FRAMES = 400

OWN_COLOURS = {
    "light": {"floor": "#D5DBE3", "shadow": "#DCE0E7", "bone": "#8A94A3", "marker": "#3D4550"},
    "dark": {"floor": "#272D37", "shadow": "#1E232B", "bone": "#667080", "marker": "#C3CAD5"},
}
SHARED_COLOURS = ("view", "panel", "line", "line2", "ink", "ink2", "ink3", "accent")


def scene_colours(theme: str) -> dict[str, str]:
    """Give the colours of the 3D view in the theme ``"light"`` or ``"dark"``."""
    return {name: TOKENS[theme][name] for name in SHARED_COLOURS} | OWN_COLOURS[theme]


@dataclass(frozen=True)
class Surroundings:
    """Where the subject is and how large it is, so that a camera and a floor fit.

    Attributes
    ----------
    centre
        (3,), middle of the subject's box, median over the take.
    size
        (3,), extent of the subject's box, 90th percentile over the take.
    low, high
        (3,), corners of the box around all of the take, without outliers.
    """

    centre: Array
    size: Array
    low: Array
    high: Array


def up_axis(positions: Array) -> int:
    """Tell which axis points up: the one along which a person is longest, most of the time.

    Two-dimensional pictures have none: their second axis, pointing down, is turned up.
    """
    if positions.shape[2] == 2:
        return 1
    extent = _box(_sample(positions))[1]
    return int(np.argmax(np.median(extent, axis=0))) if len(extent) else 2


def z_up(positions: Array, up: int) -> NDArray[np.float32]:
    """Give positions (…, n_dims) as (…, 3) float32 with z up, right-handed.

    Two-dimensional ones stand upright in the plane y = 0.
    """
    if positions.shape[-1] == 2:
        flat = np.zeros(positions.shape[:-1], np.float32)
        return np.stack([positions[..., 0], flat, -positions[..., 1]], axis=-1, dtype=np.float32)
    order = {0: (1, 2, 0), 1: (2, 0, 1), 2: (0, 1, 2)}[up]
    return np.ascontiguousarray(positions[..., order], dtype=np.float32)


def surroundings(positions: Array, up: int) -> Surroundings:
    """Measure where a take (n_frames, n_markers, n_dims) happens, z up."""
    sample = z_up(_sample(positions), up).astype(np.float64)
    centres, extents = _box(sample)
    if not len(extents):
        nothing = np.zeros(3)
        return Surroundings(nothing, np.full(3, 1000.0), nothing - 500.0, nothing + 500.0)
    seen = sample[~np.isnan(sample).any(axis=2)]
    low, high = np.percentile(seen, [0.5, 99.5], axis=0)
    size = np.maximum(np.percentile(extents, 90, axis=0), 1.0)
    return Surroundings(np.median(centres, axis=0), size, low, high)


def floor_height(around: Surroundings) -> float:
    """Give the height of the floor: 0 as in most laboratories, unless the take denies it."""
    lowest = float(around.low[2])
    return 0.0 if 0 <= lowest <= FLOOR_AT_MOST_MM else lowest


def floor_grid(around: Surroundings) -> pv.PolyData:
    """Give the lines of a floor under the take, with ``fade`` (1 inside, 0 at the rim) per point.

    Lines are cut at every crossing, so that they can fade away; the step grows with the room.
    """
    margin = FLOOR_MARGIN_MM
    low, high = around.low[:2] - margin, around.high[:2] + margin
    step = FLOOR_STEP_MM
    while np.max(high - low) / step > FLOOR_LINES:
        step *= 2
    xs, ys = (
        np.arange(np.floor(a / step), np.ceil(b / step) + 1) * step
        for a, b in zip(low, high, strict=True)
    )
    crossings = np.stack(np.meshgrid(xs, ys, indexing="ij"), axis=-1).reshape(-1, 2)
    number = np.arange(len(crossings)).reshape(len(xs), len(ys))
    edges = np.concatenate(
        [
            np.stack([number[:-1].ravel(), number[1:].ravel()], axis=1),
            np.stack([number[:, :-1].ravel(), number[:, 1:].ravel()], axis=1),
        ]
    )
    points = np.column_stack([crossings, np.full(len(crossings), floor_height(around))])
    mesh = pv.PolyData(points, lines=_lines(edges))
    outside = np.maximum(around.low[:2] - crossings, crossings - around.high[:2])
    mesh.point_data["fade"] = np.clip(1 - np.hypot(*np.maximum(outside, 0).T) / margin, 0, 1)
    return mesh


def skeleton(points: Array, bones: Iterable[tuple[int, int]]) -> pv.PolyData:
    """Give markers (n_markers, 3) as points, unseen ones at the origin, and bones as lines."""
    seen = ~np.isnan(points).any(axis=1)
    edges = np.array(list(bones), np.int64).reshape(-1, 2)
    mesh = pv.PolyData(np.where(seen[:, None], points, 0.0))
    if len(edges):
        mesh.lines = _lines(edges)
    mesh.point_data["seen"] = seen
    return mesh


def trail(n_points: int = TRAIL_POINTS) -> pv.PolyData:
    """Give a chain of separate segments, so that it may be broken where a marker is not seen."""
    ends = np.zeros((2 * (n_points - 1), 3))
    return pv.PolyData(ends, lines=_lines(np.arange(len(ends)).reshape(-1, 2)))


def shapes() -> dict[str, pv.PolyData]:
    """Give the unit shapes that are put in place, and turned to the eye, for every frame.

    ``bone`` is a strip along z from 0 to 1, of half width 1 along x; ``disc`` (markers, and their
    shadows lying on the floor) and ``ring`` face z and have the outer radius 1. They are flat and
    have few corners: so a computer without a graphics card draws a body thirty times a second.
    """
    strip = np.array([(-1, 0, 0), (1, 0, 0), (1, 0, 1), (-1, 0, 1)], float)
    return {
        "bone": pv.PolyData(strip, faces=[3, 0, 1, 2, 3, 0, 2, 3]),
        "disc": pv.Disc(inner=0.0, outer=1.0, c_res=16).triangulate(),
        "ring": pv.Disc(inner=0.78, outer=1.0, c_res=20).triangulate(),
    }


def buffers(mesh: pv.PolyData) -> dict[str, bytes]:
    """Give a mesh as little-endian bytes: float32 ``points``, uint32 cells, uint8 ``fade``."""
    parts: dict[str, Any] = {"points": np.ascontiguousarray(mesh.points, "<f4")}
    if mesh.n_lines:
        parts["lines"] = np.ascontiguousarray(mesh.lines, "<u4")
    if len(mesh.faces):
        parts["polys"] = np.ascontiguousarray(mesh.faces, "<u4")
    if "fade" in mesh.point_data:
        parts["fade"] = np.round(255 * np.asarray(mesh.point_data["fade"])).astype("u1")
    return {name: values.tobytes() for name, values in parts.items()}


def sides(labels: Sequence[str]) -> NDArray[np.int8]:
    """Tell left (1) from right (-1) markers by pairs of labels such as LKNE and RKNE.

    A label without its mirror image counts as neither (0); a subject's name before ``:`` is kept.
    """
    known = set(labels)
    found = np.zeros(len(labels), np.int8)
    for marker, label in enumerate(labels):
        subject, colon, name = label.rpartition(":")
        for side, (own, other) in ((1, "LR"), (-1, "RL"), (1, "lr"), (-1, "rl")):
            if name[:1] == own and f"{subject}{colon}{other}{name[1:]}" in known:
                found[marker] = side
    return found


def _lines(edges: NDArray[np.int64]) -> NDArray[np.int64]:
    return np.column_stack([np.full(len(edges), 2), edges]).ravel()


def _sample(positions: Array) -> Array:
    step = max(1, len(positions) // SAMPLED_FRAMES)
    return positions[::step]


def _box(positions: Array) -> tuple[Array, Array]:
    """Centres and extents (n, 3) of the markers' box in every frame that shows at least two."""
    seen = ~np.isnan(positions).any(axis=2)
    shown = positions[seen.sum(axis=1) >= 2]
    if not len(shown):
        return np.empty((0, 3)), np.empty((0, 3))
    low, high = np.nanmin(shown, axis=1), np.nanmax(shown, axis=1)
    return (low + high) / 2, high - low
