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
    """The signal that made a finding fire, with its levels."""

    name: str
    unit: str
    time: FloatArray
    signal: FloatArray
    threshold: float
    usual: float


@dataclass(frozen=True, eq=False)
class LaneValues:
    """What was recorded of one marker: ``raw`` outside the selected span, ``inside`` within it."""

    unit: str
    raw: Curve
    inside: Curve
    marks: tuple[SpanMark, ...]
    evidence: EvidenceCurve | None
    kind: Kind


@dataclass(frozen=True, eq=False)
class RepairValues:
    """The repairs of the selected span.

    ``band`` is the half-width in mm of the chosen repair's 90 % band, one value per point of
    ``chosen``; ``y_ranges`` are the limits of each axis that hold recording and chosen repair.
    """

    chosen: Curve
    band: FloatArray | None
    others: tuple[Curve, ...]
    y_ranges: tuple[tuple[float, float], ...]


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
