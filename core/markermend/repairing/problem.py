"""What a repair method is given, and what it may give back."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from markermend.model import BoolArray, FloatArray, Kind, Span, Take


@dataclass(frozen=True, eq=False)
class Problem:
    """One span of one marker to be repaired.

    Attributes
    ----------
    positions
        (n_frames, n_markers, n_dims), read-only, mm (px in two dimensions). NaN where a marker was
        not seen *or lies in a span that is being repaired*, the span at hand among them: what is
        not NaN may be trusted. Only measured markers are here; ``labels`` names them.
    marker
        Index of the marker on the second axis.
    span
        Frames to be repaired.
    rate
        Hz.
    labels
        Names of the markers in ``positions``.
    recorded
        (n_frames, n_dims): the marker as recorded, artefacts and all; NaN in real gaps only.
    kind, partner
        What was found there, and for a swap the label of the other marker.
    take
        The whole take as recorded, for methods that look at other trajectories (fragments, the
        partner of a swap).
    training
        Other takes to learn from, or none.
    """

    positions: FloatArray
    marker: int
    span: Span
    rate: float
    labels: tuple[str, ...]
    recorded: FloatArray
    take: Take
    kind: Kind = "gap"
    partner: str | None = None
    training: tuple[Take, ...] = ()

    @property
    def n_frames(self) -> int:
        """Number of frames of the take."""
        return int(self.positions.shape[0])

    @property
    def n_dims(self) -> int:
        """2 or 3."""
        return int(self.positions.shape[2])

    @cached_property
    def own(self) -> FloatArray:
        """(n_frames, n_dims): the marker's trusted positions."""
        return self.positions[:, self.marker]

    @cached_property
    def seen(self) -> BoolArray:
        """(n_frames, n_markers): which positions may be trusted."""
        return np.isfinite(self.positions[:, :, 0])


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a method gives back where it has more to say than the values.

    Attributes
    ----------
    values
        (len(span), n_dims): the repaired positions; NaN where the gap is left.
    band
        (len(span),) mm: 90 % of errors are expected to be smaller, or None.
    expected_mm
        Mean error to be expected, or None.
    note
        One sentence for the operator, or empty.
    also
        (marker label, values) of further markers that the same repair changes over the same span,
        such as the partner of a swap.
    """

    values: FloatArray
    band: FloatArray | None = None
    expected_mm: float | None = None
    note: str = ""
    also: tuple[tuple[str, FloatArray], ...] = ()


@dataclass(frozen=True, eq=False)
class Repair:
    """A repair of one span, computed but not applied.

    Attributes
    ----------
    marker, span
        What is repaired.
    values
        (len(span), n_dims) mm; NaN where the gap is left.
    method, parameters
        How.
    band, expected_mm, note, also
        As in `Outcome`.
    """

    marker: str
    span: Span
    values: FloatArray
    method: str
    parameters: Mapping[str, Any] = field(default_factory=dict)
    band: FloatArray | None = None
    expected_mm: float | None = None
    note: str = ""
    also: tuple[tuple[str, FloatArray], ...] = ()

    def largest_change(self, take: Take) -> float | None:
        """Give the largest distance in mm between repaired and recorded positions of the span.

        None where nothing was recorded, or the span is left as a gap.
        """
        before = take.positions[self.span.frames, take.index(self.marker)]
        distance = np.linalg.norm(self.values - before, axis=1)
        known = distance[np.isfinite(distance)]
        return float(known.max()) if known.size else None
