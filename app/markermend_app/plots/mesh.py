"""Pictures of the functional body mesh: the markers as a stick figure, the clusters as a tree."""

from collections.abc import Sequence
from itertools import combinations
from textwrap import wrap
from typing import Any

import holoviews as hv
import numpy as np
from numpy.typing import NDArray

from markermend.body import Body
from markermend.errors import BadInput
from markermend.model import Take
from markermend_app.plots.picture import INK, Panel, Picture, drawn, words
from markermend_app.plots.scene import up_axis, z_up

HEIGHT = 440
"""Of the stick figure in px; its width follows."""
LINE, LETTER, INDENT = 17, 6.6, 26
"""Of the tree in px: height of a line, width of a letter, and how far a child is moved in."""
BADGE = 18
"""Diameter in px of a circle with the number of a cluster."""
PUSHES = 100
LETTERS = 72
"""In a line of markers."""


def body_mesh(take: Take, body: Body, source: str) -> Picture:
    """Draw the body of a take: views of one frame, and the tree of its clusters (Fig. 5).

    A take of two dimensions has one view, others one from each side.

    Raises
    ------
    BadInput
        If no marker of the take is of the body.
    """
    if not body.clusters:
        raise BadInput("No measured marker is ever seen, so there is no body to draw.")
    frame = clearest_frame(take, body)
    up = up_axis(take.positions)
    upright = z_up(take.positions[frame], up).astype(np.float64)
    views = [
        Panel(
            f"Frame {frame + take.first_frame}, {name}", stick_figure(upright[:, [axis, 2]], body)
        )
        for axis, name in _views(take, up)
    ]
    return Picture(
        f"Functional body mesh of {source}",
        f"n = {len(body.order)} markers in {body.n_clusters} clusters, from {take.n_frames} "
        f"frames at {take.rate:g} Hz; nothing is random. Numbers are clusters: their markers keep "
        "their distances (siblings); solid lines join the markers of a cluster, dashed ones a "
        "cluster with its parent. In the tree each cluster hangs on its parent, and “on” names the "
        "parent marker. As in Skurowski & Pawlyta, Fig. 5.",
        ((*views, Panel("Clusters, parents and siblings", tree(body))),),
    )


def _views(take: Take, up: int) -> list[tuple[int, str]]:
    """Give horizontal axes (after turning z up), and what the view is called in the take's axes."""
    if take.positions.shape[2] == 2:
        return [(0, "x to the right, y downwards")]
    across = {0: "yz", 1: "zx", 2: "xy"}[up]
    return [(axis, f"{name} to the right, {'xyz'[up]} up") for axis, name in enumerate(across)]


def clearest_frame(take: Take, body: Body) -> int:
    """Give the frame nearest to the middle among those in which most of the body is seen."""
    count = take.seen[:, list(body.order)].sum(axis=1)
    best = np.flatnonzero(count == count.max())
    return int(best[np.argmin(np.abs(best - take.n_frames // 2))])


def stick_figure(points: NDArray[np.float64], body: Body) -> Any:
    """Draw points (n_markers, 2) in mm with the bones and the numbers of the clusters."""
    seen = [marker for marker in body.order if np.isfinite(points[marker]).all()]
    bones = [(a, b) for a, b in body.bones if a in seen and b in seen]
    inside = [(a, b) for a, b in bones if body.cluster(a) == body.cluster(b)]
    between = [(a, b) for a, b in bones if body.cluster(a) != body.cluster(b)]
    middles = {
        number: points[[m for m in cluster if m in seen]].mean(axis=0)
        for number, cluster in enumerate(body.clusters, 1)
        if any(m in seen for m in cluster)
    }
    where = points[seen]
    low, high = where.min(axis=0), where.max(axis=0)
    room = 0.06 * max(*(high - low), 1.0)
    low, high = low - room, high + room
    scale = HEIGHT / (high[1] - low[1])
    badges = apart(np.array(list(middles.values())), (BADGE + 2) / scale)
    numbered = list(zip(middles, badges.tolist(), strict=True))
    layers = hv.Overlay(
        [
            _sticks(points, between, color=INK["ink3"], line_dash="dashed", line_width=1.2),
            _sticks(points, inside, color=INK["ink2"], line_width=2.2),
            hv.Points([(*points[m], body.labels[m]) for m in seen], ["x", "z"], "marker").opts(
                color=INK["ink"], size=5, backend="bokeh"
            ),
            hv.Points([(*at, number) for number, at in numbered], ["x", "z"], "cluster").opts(
                size=BADGE,
                fill_color=INK["panel"],
                line_color=INK["ink"],
                line_width=1.2,
                backend="bokeh",
            ),
            words(
                ((*at, str(number)) for number, at in numbered),
                text_color=INK["ink"],
                text_font_style="bold",
            ),
        ]
    )
    return drawn(
        layers,
        int(np.clip(scale * (high[0] - low[0]), 160, 700)),
        HEIGHT,
        xlim=(low[0], high[0]),
        ylim=(low[1], high[1]),
        xlabel="mm",
        ylabel="mm",
        xticks=4,
        data_aspect=1,
    )


def apart(points: NDArray[np.float64], least: float) -> NDArray[np.float64]:
    """Push points (n, 2) away from each other until none are closer than `least`, or nearly so."""
    moved = points.copy()
    for _ in range(PUSHES):
        close = False
        for i, j in combinations(range(len(moved)), 2):
            away = moved[j] - moved[i]
            distance = float(np.hypot(*away))
            if distance < least:
                close = True
                direction = away / distance if distance > 0 else np.array([1.0, 0.0])
                push = 0.5 * (least - distance) * direction
                moved[i] -= push
                moved[j] += push
        if not close:
            break
    return moved


def _sticks(points: NDArray[np.float64], pairs: Sequence[tuple[int, int]], **options: Any) -> Any:
    lines = [(*points[a], *points[b]) for a, b in pairs]
    return hv.Segments(lines, ["x", "z", "x2", "z2"]).opts(**options, backend="bokeh")


def tree(body: Body) -> Any:
    """Draw the clusters beneath each other, each moved in under its parent, with its markers."""
    depths: list[int] = []
    for parent in body.parents:
        depths.append(0 if parent is None else depths[parent] + 1)
    texts = [_lines(body, cluster) for cluster in range(body.n_clusters)]
    tops = np.cumsum([0.0, *(len(lines) + 0.5 for lines in texts)])
    middles = tops[:-1] + 0.5
    corners = [
        [
            (_left(depths[up]), middles[up]),
            (_left(depths[up]), middles[c]),
            (_left(depths[c]), middles[c]),
        ]
        for c, up in enumerate(body.parents)
        if up is not None
    ]
    places = [(_left(depth), middle) for depth, middle in zip(depths, middles, strict=True)]
    lines = [
        (_left(depths[c]) + 16, middles[c] + i, line)
        for c, block in enumerate(texts)
        for i, line in enumerate(block)
    ]
    width = max(x + LETTER * len(line) for x, _, line in lines) + 8
    layers = hv.Overlay(
        [
            hv.Path(corners, ["x", "line"]).opts(
                color=INK["ink3"], line_dash="dashed", line_width=1.2, backend="bokeh"
            ),
            hv.Points([(*at, c) for c, at in enumerate(places, 1)], ["x", "line"], "cluster").opts(
                size=BADGE,
                fill_color=INK["panel"],
                line_color=INK["ink"],
                line_width=1.2,
                backend="bokeh",
            ),
            words(
                ((*at, str(c)) for c, at in enumerate(places, 1)),
                text_color=INK["ink"],
                text_font_style="bold",
            ),
            words(lines, text_align="left", text_color=INK["ink"]),
        ]
    )
    return drawn(
        layers,
        int(width),
        int(LINE * tops[-1]) + 8,
        grid="",
        xlim=(0, width),
        ylim=(-0.25, tops[-1]),
        xaxis=None,
        yaxis=None,
        invert_yaxis=True,
        framed=False,
    )


def _left(depth: int) -> float:
    return 12.0 + INDENT * depth


def _lines(body: Body, cluster: int) -> list[str]:
    """Give the markers of a cluster in lines, and the parent marker at the end."""
    names = " ".join(
        body.labels[m].replace(" ", "\N{NO-BREAK SPACE}") for m in body.clusters[cluster]
    )
    lines = wrap(names, LETTERS, break_long_words=False, break_on_hyphens=False)
    parent = body.parent_markers[cluster]
    if parent is not None:
        lines[-1] += f"  (on {body.labels[parent]})"
    return lines
