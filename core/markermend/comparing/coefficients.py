"""Agreement beyond chance between people who put things into classes."""

import numpy as np
from numpy.typing import NDArray

from markermend.model import FloatArray

MISSING = -1
"""The value of a unit on which a person said nothing."""


def cohen_kappa(table: NDArray[np.int64] | FloatArray) -> float | None:
    """Give Cohen's kappa of two people.

    Parameters
    ----------
    table
        (n_classes, n_classes) counts: first person by second.

    Returns
    -------
    Kappa, or None where both only ever used one and the same class, or nothing was counted.

    Notes
    -----
    Cohen (1960), Educational and Psychological Measurement 20, 37-46: (p_o - p_e) / (1 - p_e).
    """
    counts = np.asarray(table, np.float64)
    total = float(counts.sum())
    if not total:
        return None
    observed = float(np.trace(counts)) / total
    expected = float(counts.sum(axis=1) @ counts.sum(axis=0)) / total**2
    return None if np.isclose(expected, 1.0, atol=1e-15) else (observed - expected) / (1 - expected)


def krippendorff_alpha(values: NDArray[np.intp], n_classes: int) -> float | None:
    """Give Krippendorff's alpha of any number of people, for classes without an order.

    Parameters
    ----------
    values
        (n_people, n_units) classes 0 to ``n_classes - 1``, or `MISSING`.
    n_classes
        How many classes there are.

    Returns
    -------
    Alpha, or None where everything is of one class or no unit was judged twice.

    Notes
    -----
    Krippendorff (2011), Computing Krippendorff's Alpha-Reliability: 1 - D_o / D_e from the
    coincidence matrix; units judged by fewer than two people are left out.
    """
    counts = np.stack([(values == c).sum(axis=0) for c in range(n_classes)], axis=1)
    judged = counts.sum(axis=1)
    kept = judged >= 2
    # Units that were judged alike are one row with a weight: samples are many, patterns are few.
    patterns, weights = np.unique(counts[kept], axis=0, return_counts=True)
    if not len(patterns):
        return None
    n = patterns.astype(np.float64)
    shares = weights / (n.sum(axis=1) - 1.0)
    coincidences = np.einsum("uc,uk,u->ck", n, n, shares) - np.diag(shares @ n)
    margins = coincidences.sum(axis=1)
    total = float(margins.sum())
    observed = total - float(np.trace(coincidences))
    expected = (total**2 - float(margins @ margins)) / (total - 1.0)
    return None if expected <= 1e-12 else 1.0 - observed / expected
