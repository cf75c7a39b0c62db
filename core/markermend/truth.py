"""What is known of an artefact because somebody put it there."""

from dataclasses import asdict, dataclass
from typing import Any

from markermend.model import AXES, Kind, Span


@dataclass(frozen=True)
class Truth:
    """One artefact that was put in.

    Attributes
    ----------
    marker
        Label of the marker.
    span, kind
        Where, and what.
    amplitude
        Size in mm, or None where there is none to say, as for a gap. Who puts artefacts in says
        how it is measured: `markermend.contaminate` on each axis, `markermend.simulate.distort` in
        space; for heavy noise both mean the standard deviation on each axis, and for swapped
        labels the distance of both markers where it begins.
    axes
        Names of the axes that are distorted.
    partner
        For a label swap, the label of the other marker, which has a record of its own.
    sign
        +1 or -1 where all axes share it, else None.
    """

    marker: str
    span: Span
    kind: Kind
    amplitude: float | None = None
    axes: tuple[str, ...] = AXES
    partner: str | None = None
    sign: int | None = None

    def to_json(self) -> dict[str, Any]:
        """Give it as a record of plain values, with ``start`` and ``stop`` for the span."""
        record = asdict(self)
        del record["span"]
        if self.sign is None:
            del record["sign"]
        return record | {
            "start": self.span.start,
            "stop": self.span.stop,
            "axes": list(self.axes),
        }

    @classmethod
    def from_json(cls, record: dict[str, Any]) -> "Truth":
        """Read it back."""
        return cls(
            marker=record["marker"],
            span=Span(record["start"], record["stop"]),
            kind=record["kind"],
            amplitude=record["amplitude"],
            axes=tuple(record["axes"]),
            partner=record["partner"],
            sign=record.get("sign"),
        )
