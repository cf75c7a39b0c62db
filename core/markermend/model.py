"""The frozen types that everything hangs on: takes, spans and findings."""

import hashlib
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from markermend.errors import BadInput, UnknownName

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

Kind = Literal["gap", "peak", "noise", "step", "slow"]
KINDS: tuple[Kind, ...] = get_args(Kind)

Role = Literal["measured", "unlabelled", "model"]
"""A labelled marker, a ``*n`` trajectory without a label, or something a model computed."""

MM_PER_UNIT = {"mm": 1.0, "cm": 10.0, "m": 1000.0}
AXES = ("x", "y", "z")


@dataclass(frozen=True, order=True)
class Span:
    """Frames ``start`` to ``stop - 1``, 0-based; half-open always."""

    start: int
    stop: int

    def __post_init__(self) -> None:
        if not 0 <= self.start < self.stop:
            raise BadInput(
                f"A span needs 0 <= start < stop; got start {self.start}, stop {self.stop}."
            )

    def __len__(self) -> int:
        return self.stop - self.start

    @property
    def frames(self) -> slice:
        """The slice of the frame axis."""
        return slice(self.start, self.stop)

    def overlaps(self, other: "Span") -> bool:
        """Whether any frame is in both."""
        return self.start < other.stop and other.start < self.stop

    def iou(self, other: "Span") -> float:
        """Intersection over union, 0 to 1."""
        both = max(0, min(self.stop, other.stop) - max(self.start, other.start))
        return both / (len(self) + len(other) - both)

    def padded(self, frames: int, n_frames: int) -> "Span":
        """Return it wider by `frames` on both sides, clipped to the take."""
        return Span(max(0, self.start - frames), min(n_frames, self.stop + frames))


def runs(mask: NDArray[np.bool_]) -> list[Span]:
    """Give the spans over which the 1-D `mask` is true."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], np.asarray(mask, np.int8), [0]))))
    return [Span(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


@dataclass(frozen=True)
class Event:
    """A named moment of the file, such as a heel strike."""

    label: str
    time_s: float
    context: str = ""


@dataclass(frozen=True)
class Source:
    """The file that a take came from, as it was when it was read.

    ``units`` and ``rate`` are those that the positions were read with; ``sha256`` is the hash of
    the file's bytes and makes the file's identity, whatever it is called.
    """

    path: Path
    format: str
    sha256: str
    units: str
    rate: float


@dataclass(frozen=True, eq=False)
class Take:
    """One recording: trajectories of markers over time.

    Attributes
    ----------
    positions
        (n_frames, n_markers, n_dims), float64, read-only; mm (px where n_dims is 2); NaN where the
        marker was not seen. Metres or centimetres given with `units` are turned into mm.
    rate
        Frames per second, in Hz.
    labels
        One unique name per marker.
    units
        ``"mm"``, or ``"px"`` for two dimensions.
    first_frame
        The file's own number of frame 0, for screens only.
    roles
        What each marker is; by default ``*n`` labels are unlabelled and all others measured.
    source
        The file, or None for a take made from arrays.
    events, warnings
        What else the file says, and what was odd in it.

    Raises
    ------
    BadInput
        If shapes, labels, rate or units do not fit together.
    """

    positions: FloatArray
    rate: float
    labels: tuple[str, ...]
    units: str = "mm"
    first_frame: int = 1
    roles: tuple[Role, ...] = ()
    source: Source | None = None
    events: tuple[Event, ...] = ()
    warnings: tuple[str, ...] = field(default=(), repr=False)

    def __init__(
        self,
        positions: ArrayLike,
        rate: float,
        labels: Sequence[str],
        units: str = "mm",
        first_frame: int = 1,
        roles: Sequence[Role] = (),
        source: Source | None = None,
        events: Sequence[Event] = (),
        warnings: Sequence[str] = (),
    ) -> None:
        array = np.array(positions, dtype=np.float64)
        if array.ndim != 3 or array.shape[2] not in (2, 3):
            raise BadInput(
                f"positions must be (n_frames, n_markers, 2 or 3); got shape {array.shape}."
            )
        labels = tuple(str(label) for label in labels)
        if len(labels) != array.shape[1] or len(set(labels)) != len(labels):
            raise BadInput(
                f"labels must be {array.shape[1]} different names, one per marker; "
                f"got {len(labels)}, {len(set(labels))} of them different."
            )
        if not (math.isfinite(rate) and rate > 0):
            raise BadInput(f"rate must be a positive number of Hz; got {rate}.")
        if array.shape[2] == 2:
            if units != "px":
                raise BadInput(f"A take of two dimensions has units 'px'; got {units!r}.")
        elif units not in MM_PER_UNIT:
            raise BadInput(f"units must be one of {', '.join(MM_PER_UNIT)}; got {units!r}.")
        else:
            array *= MM_PER_UNIT[units]
            units = "mm"
        # A frame in which one coordinate is unknown is a frame in which the marker was not seen.
        array[~np.isfinite(array).all(axis=2)] = np.nan
        array.flags.writeable = False
        roles = tuple(roles) or tuple(default_role(label) for label in labels)
        if len(roles) != len(labels):
            raise BadInput(f"roles must be one per marker; got {len(roles)} for {len(labels)}.")
        values = (array, float(rate), labels, units, int(first_frame), roles, source)
        names = ("positions", "rate", "labels", "units", "first_frame", "roles", "source")
        for name, value in zip(names, values, strict=True):
            object.__setattr__(self, name, value)
        object.__setattr__(self, "events", tuple(events))
        object.__setattr__(self, "warnings", tuple(warnings))

    @property
    def n_frames(self) -> int:
        """Number of frames."""
        return int(self.positions.shape[0])

    @property
    def n_markers(self) -> int:
        """Number of trajectories stored, of whatever role."""
        return int(self.positions.shape[1])

    @property
    def n_dims(self) -> int:
        """2 or 3."""
        return int(self.positions.shape[2])

    @property
    def duration_s(self) -> float:
        """Length in seconds."""
        return self.n_frames / self.rate

    @cached_property
    def seen(self) -> BoolArray:
        """(n_frames, n_markers): whether the marker has a position."""
        return np.isfinite(self.positions[:, :, 0])

    @cached_property
    def measured(self) -> NDArray[np.intp]:
        """Indices of the labelled markers that cameras saw: the ones detected on and repaired."""
        return np.flatnonzero([role == "measured" for role in self.roles])

    def index(self, marker: str | int) -> int:
        """Give the index of a marker by its label.

        Raises
        ------
        UnknownName
            If there is no such marker.
        """
        if isinstance(marker, str):
            if marker not in self._indices:
                raise UnknownName.among("marker", marker, self.labels)
            return self._indices[marker]
        if not 0 <= marker < self.n_markers:
            raise UnknownName.among("marker", str(marker), self.labels)
        return int(marker)

    @cached_property
    def _indices(self) -> dict[str, int]:
        return {label: i for i, label in enumerate(self.labels)}

    @cached_property
    def content_hash(self) -> str:
        """Hash of the file's bytes, or of the arrays where there is no file."""
        if self.source is not None:
            return self.source.sha256
        digest = hashlib.sha256(np.ascontiguousarray(self.positions).tobytes())
        digest.update(repr((self.rate, self.labels, self.positions.shape)).encode())
        return digest.hexdigest()

    def gaps(self, marker: str | int) -> Iterator[tuple[Span, bool]]:
        """Yield the spans in which a marker was not seen, and whether each is an inner gap."""
        for span in runs(~self.seen[:, self.index(marker)]):
            yield span, span.start > 0 and span.stop < self.n_frames

    def with_positions(self, positions: ArrayLike) -> "Take":
        """Return the same take with other positions, in mm (px in two dimensions)."""
        return replace(self, positions=np.asarray(positions, np.float64))


def short(label: str) -> str:
    """Give a label without its subject, for screens."""
    return label.rsplit(":", 1)[-1]


def default_role(label: str) -> Role:
    """Tell a ``*n`` trajectory (of whatever subject) from a labelled marker."""
    return "unlabelled" if short(label).startswith("*") else "measured"


@dataclass(frozen=True, eq=False)
class Evidence:
    """Why a finding fired, for the operator to see.

    Attributes
    ----------
    name
        What the signal is, e.g. ``"deviation from the neighbours' prediction"``.
    start
        Frame of the first sample of the arrays below.
    signal
        (n,), in mm unless `unit` says otherwise.
    threshold, usual
        The level that had to be passed, and the usual level of this marker, in the same unit.
    prediction
        (n, n_dims) mm: where the marker was expected, or None.
    template
        (n,) or (n, n_dims): the shape that was fitted, in the signal's unit, or None.
    """

    name: str
    start: int
    signal: FloatArray
    threshold: float
    usual: float
    unit: str = "mm"
    prediction: FloatArray | None = None
    template: FloatArray | None = None


@dataclass(frozen=True)
class Finding:
    """Something that an operator should look at.

    Attributes
    ----------
    marker
        Label of the marker.
    span, kind
        Where, and what.
    score
        How sure, 0 to 1; for a gap 1.
    axes
        Names of the axes on which it shows.
    amplitude
        Estimated size in mm (px in two dimensions), or None for a gap.
    detector
        Name of the detector, or ``"operator"``.
    strength
        Statistic divided by the threshold that it had to pass; 1 is just found.
    partner
        For a swap, the label of the other marker.
    group
        The id that findings share which belong together, or None.
    evidence
        What made it fire, where the detector is still at hand; no part of its identity.
    """

    marker: str
    span: Span
    kind: Kind
    score: float = 1.0
    axes: tuple[str, ...] = AXES
    amplitude: float | None = None
    detector: str = "operator"
    strength: float = 1.0
    partner: str | None = None
    group: str | None = None
    evidence: Evidence | None = field(default=None, compare=False, repr=False)

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise UnknownName.among("kind", str(self.kind), KINDS)

    @cached_property
    def id(self) -> str:
        """Hash of marker, kind and span: the same finding keeps its id over runs and detectors."""
        text = f"{self.marker}\n{self.kind}\n{self.span.start}\n{self.span.stop}"
        return hashlib.sha256(text.encode()).hexdigest()[:12]

    def to_json(self) -> dict[str, Any]:
        """Give it in the form of ``markermend detect --json``."""
        record: dict[str, Any] = {
            "id": self.id,
            "marker": self.marker,
            "start": self.span.start,
            "stop": self.span.stop,
            "kind": self.kind,
            "score": round(self.score, 6),
            "axes": list(self.axes),
            "amplitude": None if self.amplitude is None else round(self.amplitude, 6),
            "detector": self.detector,
            "strength": round(self.strength, 6),
        }
        if self.partner is not None:
            record["partner"] = self.partner
        if self.group is not None:
            record["group"] = self.group
        return record

    @classmethod
    def from_json(cls, record: dict[str, Any]) -> "Finding":
        """Read it back; evidence is not part of it."""
        amplitude = record.get("amplitude")
        return cls(
            marker=str(record["marker"]),
            span=Span(int(record["start"]), int(record["stop"])),
            kind=record["kind"],
            score=float(record.get("score", 1.0)),
            axes=tuple(str(axis) for axis in record.get("axes", AXES)),
            amplitude=None if amplitude is None else float(amplitude),
            detector=str(record.get("detector", "operator")),
            strength=float(record.get("strength", 1.0)),
            partner=record.get("partner"),
            group=record.get("group"),
        )
