"""What the overview shows of a desk: all markers over time."""

from weakref import WeakKeyDictionary

import numpy as np

from markermend import curves
from markermend_app.state.curves import events, marks
from markermend_app.state.desk import Desk
from markermend_app.state.values import EventMark, OverviewValues
from markermend_app.state.workspace import Opened

N_BINS = 1200
NAMES = 7
"""Names of groups that there is room for where the overview is lowest."""


def overview(desk: Desk) -> OverviewValues | None:
    """Give what the overview shows, or None when no take is open."""
    if desk.opened is None:
        return None
    rows, groups, shade, happened = _fixed(desk.opened)
    return OverviewValues(
        duration_s=desk.opened.take.duration_s,
        shade=shade,
        rows=rows,
        groups=groups,
        marks=tuple(m for m in marks(desk) if m[0] in rows),
        events=happened,
    )


Fixed = tuple[dict[str, int], tuple[tuple[float, str], ...], np.ndarray, tuple[EventMark, ...]]
_OF_TAKES: WeakKeyDictionary[Opened, Fixed] = WeakKeyDictionary()


def _fixed(opened: Opened) -> Fixed:
    """Give what stays the same while a take is open: rows, names of groups, shading, events."""
    if opened not in _OF_TAKES:
        _OF_TAKES[opened] = _computed(opened)
    return _OF_TAKES[opened]


def _computed(opened: Opened) -> Fixed:
    take, mesh = opened.take, opened.mesh
    order = list(mesh.order)
    listed = set(order)
    order += [int(m) for m in take.measured if m not in listed]
    rows = {take.labels[m]: len(order) - 1 - i for i, m in enumerate(order)}
    groups, at, last = [], len(order), np.inf
    for cluster in mesh.clusters:
        at -= len(cluster)
        middle = at + len(cluster) / 2
        # A name needs so much of the height where the picture is lowest.
        if len(cluster) >= 3 and last - middle >= len(order) / NAMES:
            last = middle
            groups.append((middle, _name(take.labels, cluster)))
    shade = curves.speed_map(take, np.array(order[::-1], dtype=int), N_BINS)
    return rows, tuple(groups), shade, events(take)


def _name(labels: tuple[str, ...], cluster: tuple[int, ...]) -> str:
    """Name a group by its middle marker; with the subject's initial where there are several."""
    subject, _, name = labels[cluster[len(cluster) // 2]].rpartition(":")
    several = len({label.rpartition(":")[0] for label in labels} - {""}) > 1
    return f"{subject[:1]} {name}" if several else name
