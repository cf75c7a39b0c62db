"""What the lanes and the overview show of a desk: asked of the library, put into values."""

from dataclasses import dataclass

import numpy as np

from markermend import curves
from markermend.model import Finding, FloatArray, Span, Take, short
from markermend_app.state.desk import Desk
from markermend_app.state.values import (
    Curve,
    EvidenceCurve,
    LaneValues,
    OverviewValues,
    RepairValues,
    SpanMark,
)

MOST_POINTS = 4000
MOST_OTHERS = 8


def marks(desk: Desk, marker: str | None = None) -> list[tuple[str, SpanMark]]:
    """Give the coloured spans of one marker, or of all, with their markers."""
    if desk.opened is None:
        return []
    rate, found = desk.opened.take.rate, []
    for finding in desk.findings:
        if marker is not None and finding.marker != marker:
            continue
        judged = desk.judged(finding)
        found.append(
            (
                finding.marker,
                SpanMark(
                    id=finding.id,
                    start_s=(judged.span.start - 0.5) / rate,
                    stop_s=(judged.span.stop - 0.5) / rate,
                    kind=judged.kind,
                    settled=judged.decision.settled,
                    selected=finding.id == desk.selected,
                ),
            )
        )
    return found


@dataclass(frozen=True)
class _Cut:
    """The part of a take that the lanes need: the window and as much again on both sides."""

    start: int
    stop: int


def _cut(desk: Desk, take: Take) -> _Cut:
    low, high = desk.window
    margin = high - low
    start = max(0, int((low - margin) * take.rate))
    stop = min(take.n_frames, int((high + margin) * take.rate) + 2)
    return _Cut(start, max(start + 1, stop))


def lanes(desk: Desk) -> LaneValues | None:
    """Give what was recorded around the finding at hand, or None when there is none."""
    opened, current, span = desk.opened, desk.current, desk.span
    if opened is None or current is None or span is None:
        return None
    take = opened.take
    marker = take.index(current.marker)
    cut = _cut(desk, take)
    own = take.positions[cut.start : cut.stop, marker]
    first, last = max(span.start - cut.start, 0), max(0, span.stop - cut.start)
    outside = own.copy()
    # One sample more on both sides of the span, so that the two lines meet.
    outside[first + 1 : max(0, last - 1)] = np.nan
    return LaneValues(
        unit=take.units,
        raw=_curve(outside, cut.start, take.rate),
        inside=_curve(own[first:last], cut.start + first, take.rate),
        marks=tuple(mark for _, mark in marks(desk, current.marker)),
        evidence=_evidence(take, current),
        kind=desk.judged(current).kind,
    )


def repairs(desk: Desk) -> RepairValues | None:
    """Give the repairs of the finding at hand, or None when there is none."""
    opened, current, span = desk.opened, desk.current, desk.span
    if opened is None or current is None or span is None:
        return None
    take = opened.take
    marker = take.index(current.marker)
    shown = [] if desk.raw_only else [p.repair for p in desk.previews if p.repair is not None]
    shown = [done for done in shown if np.isfinite(done.values).any()]
    chosen, band = Curve(), None
    for done in shown:
        if done.method == desk.chosen:
            chosen = _joined(take, marker, span, done.values)
            if done.band is not None:
                band = np.concatenate([[0.0], done.band, [0.0]])[_edges(take, span)]
    others = [done for done in shown if done.method != desk.chosen][:MOST_OTHERS]
    return RepairValues(
        chosen=chosen,
        band=band,
        others=tuple(_joined(take, marker, span, done.values) for done in others),
        y_ranges=_y_ranges(desk, take, marker, chosen.values),
    )


def _curve(values: FloatArray, start: int, rate: float) -> Curve:
    indices, thin = curves.thinned(values, MOST_POINTS)
    return Curve((indices + start) / rate, thin)


def _edges(take: Take, span: Span) -> slice:
    """Leave out the sample before or after the span where the take ends there."""
    return slice(0 if span.start > 0 else 1, None if span.stop < take.n_frames else -1)


def _joined(take: Take, marker: int, span: Span, values: FloatArray) -> Curve:
    """Give repaired values with the recorded samples on both sides, so that a kink is seen."""
    wide = span.padded(1, take.n_frames)
    frames = np.arange(wide.start, wide.stop)
    joined = take.positions[wide.frames, marker].copy()
    joined[span.start - wide.start : span.stop - wide.start] = values
    return Curve(frames / take.rate, joined)


def _y_ranges(
    desk: Desk, take: Take, marker: int, chosen: FloatArray
) -> tuple[tuple[float, float], ...]:
    """Scale each lane to the recorded curve in the window and the chosen repair."""
    low, high = (round(edge * take.rate) for edge in desk.window)
    shown = take.positions[max(0, low) : high + 1, marker]
    ranges = []
    for axis in range(take.n_dims):
        parts = [shown[:, axis], chosen[:, axis] if len(chosen) else np.empty(0)]
        values = np.concatenate(parts)
        values = values[np.isfinite(values)]
        if not values.size:
            ranges.append((-1.0, 1.0))
            continue
        bottom, top = float(values.min()), float(values.max())
        room = max(0.12 * (top - bottom), 2.0)
        ranges.append((bottom - room, top + room))
    return tuple(ranges)


def _evidence(take: Take, finding: Finding) -> EvidenceCurve | None:
    """Give the signal that fired; a gap fires by being one, and shows the marker's speed."""
    found = finding.evidence
    if found is not None:
        frames = np.arange(found.start, found.start + len(found.signal))
        return EvidenceCurve(
            found.name,
            found.unit,
            frames / take.rate,
            np.abs(found.signal),
            found.threshold,
            found.usual,
        )
    wide = finding.span.padded(max(len(finding.span), round(take.rate)), take.n_frames)
    speed = curves.speed(take.positions[wide.frames, take.index(finding.marker)], take.rate)
    unit = "mm/s" if take.units == "mm" else "px/s"
    known = speed[np.isfinite(speed)]
    usual = float(np.median(known)) if known.size else np.nan
    frames = np.arange(wide.start, wide.stop)
    return EvidenceCurve("speed", unit, frames / take.rate, speed, np.nan, usual)


def overview(desk: Desk) -> OverviewValues | None:
    """Give what the overview shows, or None when no take is open."""
    if desk.opened is None:
        return None
    take, mesh = desk.opened.take, desk.opened.mesh
    order = list(mesh.order)
    order += [int(m) for m in take.measured if m not in set(order)]
    rows = {take.labels[m]: len(order) - 1 - i for i, m in enumerate(order)}
    groups, at = [], len(order)
    for cluster in mesh.clusters:
        at -= len(cluster)
        if len(cluster) >= max(3, len(order) // 18):
            groups.append((at + len(cluster) / 2, short(take.labels[cluster[len(cluster) // 2]])))
    shade = curves.speed_map(take, np.array(order[::-1], dtype=int), 1200)
    return OverviewValues(
        duration_s=take.duration_s,
        shade=shade,
        rows=rows,
        groups=tuple(groups),
        marks=tuple(m for m in marks(desk) if m[0] in rows),
    )
