"""By how many mm the repaired trajectories of two people differ."""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from markermend.model import BoolArray, Span, Take


@dataclass(frozen=True)
class Difference:
    """Two repaired versions of one take, over the samples that one of them changed.

    Attributes
    ----------
    samples
        Samples (a marker in a frame) that at least one of the two changed or filled.
    differing
        Those of them that have a position in both, and not the same one.
    only_one
        Those that have a position in one version alone.
    mean_mm, rms_mm, largest_mm
        Distance over the samples that have a position in both; None without any.
    where
        Marker and frame of the largest distance, or None.
    """

    samples: int
    differing: int
    only_one: int
    mean_mm: float | None
    rms_mm: float | None
    largest_mm: float | None
    where: tuple[str, int] | None

    def to_json(self) -> dict[str, Any]:
        """Give it as a record."""
        return {**asdict(self), "where": None if self.where is None else list(self.where)}


def difference(take: Take, one: Take, other: Take) -> Difference:
    """Compare two repaired versions of `take`."""
    touched = _changed(take, one) | _changed(take, other)
    both = touched & one.seen & other.seen
    only = int((touched & (one.seen ^ other.seen)).sum())
    off = np.linalg.norm(one.positions - other.positions, axis=2)[both]
    if not len(off):
        return Difference(int(touched.sum()), 0, only, None, None, None, None)
    frame, marker = np.argwhere(both)[int(off.argmax())]
    return Difference(
        samples=int(touched.sum()),
        differing=int((off > 0.0).sum()),
        only_one=only,
        mean_mm=float(off.mean()),
        rms_mm=float(np.sqrt(np.square(off).mean())),
        largest_mm=float(off.max()),
        where=(take.labels[marker], int(frame)),
    )


def apart(one: Take, other: Take, marker: str, span: Span) -> float | None:
    """Give the mean distance of two versions over one span, or None where one has a gap."""
    m = one.index(marker)
    off = np.linalg.norm(one.positions[span.frames, m] - other.positions[span.frames, m], axis=1)
    return float(off.mean()) if np.isfinite(off).all() else None


def _changed(take: Take, version: Take) -> BoolArray:
    same: BoolArray = (version.positions == take.positions).all(axis=2)
    changed: BoolArray = ~(same | (~take.seen & ~version.seen))
    return changed
