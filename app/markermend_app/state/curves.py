"""What the lanes show of a desk: asked of the library, put into values."""

from dataclasses import dataclass, field, replace
from weakref import WeakKeyDictionary

import numpy as np

from markermend import curves
from markermend.model import Finding, FloatArray, Span, Take
from markermend.repairing import Repair
from markermend.review import Judgement
from markermend_app.state.desk import Desk
from markermend_app.state.evidence import Surroundings, signal_of, surroundings
from markermend_app.state.values import (
    Curve,
    EventMark,
    EvidenceCurve,
    LaneValues,
    Line,
    RepairValues,
    SpanMark,
)

MOST_POINTS = 4000
MOST_OTHERS = 8
MOST_RELATIVE = 20_000
"""Frames on the screen beyond which the neighbours' motion is not subtracted."""
SMALL = 0.05
"""Share of the lane's range below which an artefact cannot be seen without subtracting it."""


Mark = tuple[str, SpanMark]
_MADE: WeakKeyDictionary[Desk, dict[str, tuple[Judgement, Mark]]] = WeakKeyDictionary()


def marks(desk: Desk, marker: str | None = None) -> list[Mark]:
    """Give the coloured spans of one marker, or of all, with their markers.

    What has not changed is the same object as before: of thousands, one changes at a time.
    """
    if desk.opened is None:
        return []
    rate, found, made = desk.opened.take.rate, [], _MADE.setdefault(desk, {})
    for finding in desk.findings:
        if marker is not None and finding.marker != marker:
            continue
        judged, known = desk.judged(finding), made.get(finding.id)
        if known is None or known[0] is not judged:
            known = made[finding.id] = (judged, _mark(judged, rate))
        mark = known[1]
        if finding.id == desk.selected:
            mark = (mark[0], replace(mark[1], selected=True))
        found.append(mark)
    if marker is None:  # all were asked for: what is not among them is of an earlier take
        for gone in made.keys() - {mark.id for _, mark in found}:
            del made[gone]
    return found


def _mark(judged: Judgement, rate: float) -> Mark:
    finding = judged.finding
    mark = SpanMark(
        id=finding.id,
        start_s=(judged.span.start - 0.5) / rate,
        stop_s=(judged.span.stop - 0.5) / rate,
        kind=judged.kind,
        settled=judged.decision.settled,
    )
    return finding.marker, mark


@dataclass(frozen=True, eq=False)
class _Scene:
    """The part of a take that the lanes need: the window and as much again on both sides."""

    take: Take
    marker: int
    start: int
    stop: int
    span: Span | None
    finding: Finding | None
    away: FloatArray | None = field(default=None)

    @property
    def own(self) -> FloatArray:
        return self.take.positions[self.start : self.stop, self.marker]

    def curve(self, values: FloatArray, start: int) -> Curve:
        """Put values of some frames into a line, without the neighbours' motion where wanted."""
        if self.away is not None:
            values = values - self.away[start - self.start : start - self.start + len(values)]
        return _curve(values, start, self.take.rate)


def _scene(desk: Desk) -> _Scene | None:
    opened = desk.opened
    if opened is None or not desk.marker:
        return None
    take, (low, high) = opened.take, desk.window
    margin = high - low
    start = min(max(0, int((low - margin) * take.rate)), take.n_frames - 1)
    stop = max(start + 1, min(take.n_frames, int((high + margin) * take.rate) + 2))
    if desk.span is not None:
        start, stop = min(start, max(0, desk.span.start - 1)), max(stop, desk.span.stop)
    stop = min(stop + 1, take.n_frames)
    scene = _Scene(take, take.index(desk.marker), start, stop, desk.span, desk.current)
    if not is_relative(desk):
        return scene
    around = _around(desk, scene)
    return _Scene(scene.take, scene.marker, start, stop, scene.span, scene.finding, around.expected)


def _around(desk: Desk, scene: _Scene) -> Surroundings:
    assert desk.opened is not None
    partner = scene.finding.partner if scene.finding else None
    frames = Span(scene.start, scene.stop)
    return surroundings(desk.opened, scene.marker, frames, scene.span, partner)


def is_relative(desk: Desk) -> bool:
    """Tell whether the neighbours' motion is subtracted: as chosen, else where it helps."""
    opened, current, span = desk.opened, desk.current, desk.span
    if opened is None or not desk.marker:
        return False
    low, high = (round(edge * opened.take.rate) for edge in desk.window)
    if high - low > MOST_RELATIVE:
        return False
    if desk.relative is not None:
        return desk.relative
    if current is None or span is None or current.amplitude is None:
        return False
    if desk.judged(current).kind == "gap" or current.partner is not None:
        return False
    shown = opened.take.positions[max(0, low) : high + 1, opened.take.index(desk.marker)]
    known = shown[np.isfinite(shown[:, 0])]
    if not len(known) or abs(current.amplitude) >= SMALL * float(np.ptp(known, axis=0).max()):
        return False
    frames = span.padded(1, opened.take.n_frames)
    around = surroundings(
        opened, opened.take.index(desk.marker), frames.padded(50, opened.take.n_frames), span
    )
    return bool(np.isfinite(around.expected).any())


def lanes(desk: Desk) -> LaneValues | None:
    """Give what was recorded of the marker at hand, or None when there is none."""
    scene = _scene(desk)
    if scene is None or desk.opened is None:
        return None
    take, span, own = scene.take, scene.span, scene.own
    outside, inside = own.copy(), Curve()
    if span is not None:
        first, last = max(span.start - scene.start, 0), max(0, span.stop - scene.start)
        # One sample more on both sides of the span, so that the two lines meet.
        outside[first + 1 : max(0, last - 1)] = np.nan
        inside = scene.curve(own[first:last], scene.start + first)
    partner = scene.finding.partner if scene.finding else None
    return LaneValues(
        unit=take.units,
        raw=scene.curve(outside, scene.start),
        inside=inside,
        marks=tuple(mark for _, mark in marks(desk, desk.marker)),
        evidence=_thinned(signal_of(desk.opened, desk.signal, scene.finding, _around(desk, scene))),
        kind=desk.judged(scene.finding).kind if scene.finding else "gap",
        partner=Curve()
        if partner is None
        else scene.curve(
            take.positions[scene.start : scene.stop, take.index(partner)], scene.start
        ),
        mended=tuple(
            _joined(scene, done.span, done.values)
            for done in desk.mended.values()
            if done.marker == desk.marker
            and done.span != span
            and scene.start < done.span.start
            and done.span.stop < scene.stop
        ),
        events=events(take),
        relative=scene.away is not None,
    )


def _thinned(signal: EvidenceCurve | None) -> EvidenceCurve | None:
    """Leave as many points as can be told apart on a screen."""
    if signal is None or len(signal.time) <= MOST_POINTS:
        return signal
    indices, thin = curves.thinned(signal.signal[:, None], MOST_POINTS)
    time = np.interp(indices, np.arange(len(signal.time)), signal.time)
    return replace(signal, time=time, signal=thin[:, 0])


def events(take: Take) -> tuple[EventMark, ...]:
    """Give the events of the file, such as heel strikes."""
    return tuple(
        EventMark(e.time_s, f"{e.context} {e.label}".strip())
        for e in take.events
        if np.isfinite(e.time_s)
    )


def repairs(desk: Desk) -> RepairValues | None:
    """Give the repairs of the finding at hand, or None when there is none."""
    scene = _scene(desk)
    if scene is None or desk.opened is None:
        return None
    span = scene.span
    shown: list[Repair] = []
    if span is not None and not desk.raw_only:
        shown = [p.repair for p in desk.previews if p.repair is not None]
        shown = [d for d in shown if d.span == span and np.isfinite(d.values).any()]
    mine = next((d for d in shown if d.method == desk.chosen), None)
    chosen, band, after, also = Curve(), None, Line(), Curve()
    if mine is not None and span is not None:
        chosen = _joined(scene, span, mine.values)
        if mine.band is not None:
            band = np.concatenate([[0.0], mine.band, [0.0]])[_edges(scene.take, span)]
        after = _after(desk, scene, mine)
        also = next((_also(scene, span, v, label) for label, v in mine.also), Curve())
    others = [done for done in shown if done is not mine][:MOST_OTHERS]
    return RepairValues(
        chosen=chosen,
        band=band,
        others=tuple(_joined(scene, done.span, done.values) for done in others),
        y_ranges=_y_ranges(desk, scene, chosen, band, also),
        after=after,
        also=also,
    )


def _curve(values: FloatArray, start: int, rate: float) -> Curve:
    indices, thin = curves.thinned(values, MOST_POINTS)
    return Curve((indices + start) / rate, thin)


def _edges(take: Take, span: Span) -> slice:
    """Leave out the sample before or after the span where the take ends there."""
    return slice(0 if span.start > 0 else 1, None if span.stop < take.n_frames else -1)


def _joined(scene: _Scene, span: Span, values: FloatArray, marker: int | None = None) -> Curve:
    """Give repaired values with the recorded samples on both sides, so that a kink is seen."""
    take = scene.take
    wide = span.padded(1, take.n_frames)
    joined = take.positions[wide.frames, scene.marker if marker is None else marker].copy()
    joined[span.start - wide.start : span.stop - wide.start] = values
    if scene.away is not None:
        joined = joined - scene.away[wide.start - scene.start : wide.stop - scene.start]
    return Curve(np.arange(wide.start, wide.stop) / take.rate, joined)


def _also(scene: _Scene, span: Span, values: FloatArray, label: str) -> Curve:
    return _joined(scene, span, values, scene.take.index(label))


def _after(desk: Desk, scene: _Scene, done: Repair) -> Line:
    """Give the evidence of the marker as it would be with the repair, over the span."""
    assert desk.opened is not None
    own = scene.own.copy()
    at = slice(done.span.start - scene.start, done.span.stop - scene.start)
    own[at] = done.values
    around = _around(desk, scene).with_own(own)
    found = signal_of(desk.opened, desk.signal, scene.finding, around, repaired=True)
    if found is None:
        return Line()
    start, stop = ((f - 0.5) / scene.take.rate for f in (done.span.start - 1, done.span.stop + 1))
    inside = (found.time >= start) & (found.time <= stop)
    return Line(found.time[inside], found.signal[inside])


def _y_ranges(
    desk: Desk, scene: _Scene, chosen: Curve, band: FloatArray | None, also: Curve
) -> tuple[tuple[float, float], ...]:
    """Scale each lane to the recorded curve in the window and the chosen repair with its band."""
    take = scene.take
    low, high = (round(edge * take.rate) for edge in desk.window)
    low, high = max(scene.start, low), min(scene.stop, high + 1)
    shown = scene.own[low - scene.start : high - scene.start]
    if scene.away is not None:
        shown = shown - scene.away[low - scene.start : high - scene.start]
    half = np.zeros(len(chosen.time)) if band is None else band
    ranges = []
    for axis in range(take.n_dims):
        parts = [shown[:, axis]]
        if len(chosen.time):
            parts += [chosen.values[:, axis] - half, chosen.values[:, axis] + half]
        if len(also.time):
            parts.append(also.values[:, axis])
        values = np.concatenate(parts)
        values = values[np.isfinite(values)]
        if not values.size:
            ranges.append((-1.0, 1.0))
            continue
        bottom, top = float(values.min()), float(values.max())
        room = max(0.12 * (top - bottom), 2.0)
        ranges.append((bottom - room, top + room))
    return tuple(ranges)
