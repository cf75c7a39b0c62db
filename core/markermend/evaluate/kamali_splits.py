"""The errors of the experiment of Kamali et al. by how many gaps there are, and how long."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from markermend.model import FloatArray

BOUNDS = {"gaps": (5, 10, 15, 21), "share": (0.0, 0.2, 0.3, 0.4, 0.55)}
"""Classes, lower bound included: gaps in a mask, and length of a gap as a share of a cycle, which
is 10 to 50 % but for the rounding to frames."""


@dataclass(frozen=True)
class Split:
    """One method on the gaps of one class.

    Attributes
    ----------
    take, markers, method
        As in `markermend.evaluate.kamali_tables.Cell`.
    by
        ``gaps`` or ``share``.
    low, high
        Bounds of the class; the upper one is not in it.
    n
        Gaps of the class that the method has filled.
    mean_mm
        Mean over them, or None.
    """

    take: str
    markers: int
    method: str
    by: str
    low: float
    high: float
    n: int
    mean_mm: float | None

    @property
    def name(self) -> str:
        """What the class is called."""
        if self.by == "gaps":
            return f"{self.low:g} to {self.high - 1:g} gaps"
        return f"{max(self.low, 0.1):.0%} to {min(self.high, 0.5):.0%}"


def splits(
    take: str,
    markers: int,
    method: str,
    errors: Sequence[FloatArray],
    shares: Sequence[FloatArray],
) -> tuple[Split, ...]:
    """Sort the errors of all gaps into classes.

    Parameters
    ----------
    errors
        For every mask (n_gaps,) mm, NaN where a gap was not filled.
    shares
        Likewise the lengths of the gaps, in cycles.
    """
    every = np.concatenate(errors)
    kinds = {
        "gaps": np.concatenate([np.full(len(one), float(len(one))) for one in errors]),
        "share": np.concatenate(shares),
    }
    found = []
    for by, bounds in BOUNDS.items():
        for low, high in pairwise(bounds):
            some = every[(kinds[by] >= low) & (kinds[by] < high)]
            known = some[np.isfinite(some)]
            mean = float(known.mean()) if len(known) else None
            found.append(Split(take, markers, method, by, low, high, len(known), mean))
    return tuple(found)
