"""Values that the plots draw: frozen, ready-made, without any reference to a screen library."""

from dataclasses import dataclass, field

import numpy as np

from markermend.model import FloatArray, Kind

EMPTY = np.empty(0)


@dataclass(frozen=True, eq=False)
class SpanMark:
    """A span to be coloured: seconds, kind, whether it is settled and whether it is selected."""

    id: str
    start_s: float
    stop_s: float
    kind: Kind
    settled: bool = False
    selected: bool = False


@dataclass(frozen=True, eq=False)
class Curve:
    """One line over time, one column per axis; seconds and mm."""

    time: FloatArray = field(default_factory=lambda: EMPTY)
    values: FloatArray = field(default_factory=lambda: np.empty((0, 3)))


@dataclass(frozen=True, eq=False)
class EvidenceCurve:
    """A signal that explains the finding, with its levels; NaN where there is no level."""

    name: str
    unit: str
    time: FloatArray
    signal: FloatArray
    threshold: float = np.nan
    usual: float = np.nan


@dataclass(frozen=True, eq=False)
class Line:
    """One line over time in the evidence lane."""

    time: FloatArray = field(default_factory=lambda: EMPTY)
    values: FloatArray = field(default_factory=lambda: EMPTY)


@dataclass(frozen=True, eq=False)
class EventMark:
    """An event of the file on the time axis."""

    time_s: float
    label: str


@dataclass(frozen=True, eq=False)
class LaneValues:
    """What was recorded of one marker: ``raw`` outside the selected span, ``inside`` within it.

    ``partner`` is the other marker of a swap; ``mended`` are accepted repairs of other spans;
    ``relative`` says that the neighbours' motion is subtracted.
    """

    unit: str
    raw: Curve
    inside: Curve
    marks: tuple[SpanMark, ...]
    evidence: EvidenceCurve | None
    kind: Kind
    partner: Curve = field(default_factory=Curve)
    mended: tuple[Curve, ...] = ()
    events: tuple[EventMark, ...] = ()
    relative: bool = False


@dataclass(frozen=True, eq=False)
class RepairValues:
    """The repairs of the selected span.

    ``band`` is the half-width in mm of the chosen repair's 90 % band, one value per point of
    ``chosen``; ``y_ranges`` are the limits of each axis that hold recording and chosen repair;
    ``after`` is the evidence after the chosen repair; ``also`` what it does to the other marker.
    """

    chosen: Curve
    band: FloatArray | None
    others: tuple[Curve, ...]
    y_ranges: tuple[tuple[float, float], ...]
    after: Line = field(default_factory=Line)
    also: Curve = field(default_factory=Curve)


@dataclass(frozen=True, eq=False)
class OverviewValues:
    """All markers over time.

    ``shade`` is (n_rows, n_bins) mm/s, row 0 at the bottom; ``rows`` gives each label its row;
    ``groups`` are (middle row, name).
    """

    duration_s: float
    shade: FloatArray
    rows: dict[str, int]
    groups: tuple[tuple[float, str], ...]
    marks: tuple[tuple[str, SpanMark], ...]
    events: tuple[EventMark, ...] = ()
