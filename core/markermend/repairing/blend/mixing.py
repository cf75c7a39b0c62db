"""Weights that mix several predictions so that their errors cancel."""

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from markermend.model import FloatArray

MOST_MEMBERS = 4
LEAST_GAIN = 0.005


def simplex_weights(covariance: FloatArray) -> FloatArray:
    """Minimise wᵀCw over w ≥ 0 with sum 1, exactly.

    Parameters
    ----------
    covariance
        (n, n), positive semi-definite; n is small, since every subset is tried.
    """
    n = len(covariance)
    ridge = 1e-9 * np.trace(covariance) / n + 1e-300
    best, lowest = np.zeros(n), np.inf
    for size in range(1, n + 1):
        for subset in combinations(range(n), size):
            at = np.ix_(subset, subset)
            solved = np.linalg.solve(covariance[at] + ridge * np.eye(size), np.ones(size))
            weights = solved / solved.sum()
            if (weights < 0).any():
                continue
            value = weights @ covariance[at] @ weights
            if value < lowest:
                best, lowest = np.zeros(n), value
                best[list(subset)] = weights
    return best


def mix(errors: FloatArray) -> tuple[NDArray[np.intp], FloatArray]:
    """Choose up to MOST_MEMBERS candidates and their weights.

    Parameters
    ----------
    errors
        (n_candidates, n_gaps, n_values): signed errors; the gaps count alike, however large the
        errors are in them.

    Returns
    -------
    The indices of the members, and their weights.
    """
    size = np.sqrt(np.square(errors).mean(axis=2))
    usual = np.sqrt(size.min(axis=0) * np.median(size, axis=0)) + 1e-9
    scaled = (errors / np.sqrt(usual)[:, None]).reshape(len(errors), -1)
    covariance = scaled @ scaled.T / scaled.shape[1]
    members = [int(np.argmin(np.diag(covariance)))]
    reached = covariance[members[0], members[0]]
    while len(members) < min(MOST_MEMBERS, len(errors)):
        others = np.setdiff1d(np.arange(len(errors)), members)
        value, candidate = min(zip(_joined(covariance, members, others), others, strict=True))
        if value > (1 - LEAST_GAIN) * reached:
            break
        members.append(int(candidate))
        reached = float(value)
    weights = simplex_weights(covariance[np.ix_(members, members)])
    keep = weights > 0
    return np.asarray(members, np.intp)[keep], weights[keep]


def _joined(
    covariance: FloatArray, members: list[int], others: NDArray[np.intp]
) -> NDArray[np.float64]:
    """Give wᵀCw, the least over w ≥ 0 of sum 1, of the members with each of the others joined.

    Only subsets that hold the one that joins can be better than the members alone.
    """
    lowest = np.full(len(others), np.inf)
    for size in range(len(members) + 1):
        for subset in combinations(members, size):
            group = np.column_stack([np.tile(subset, (len(others), 1)), others]).astype(np.intp)
            within = covariance[group[:, :, None], group[:, None, :]]
            ridge = 1e-9 * np.trace(within, axis1=1, axis2=2) / (size + 1) + 1e-300
            matrix = within + ridge[:, None, None] * np.eye(size + 1)
            solved = np.linalg.solve(matrix, np.ones((len(others), size + 1, 1)))[:, :, 0]
            weights = solved / solved.sum(axis=1, keepdims=True)
            value = np.einsum("ni,nij,nj->n", weights, within, weights)
            value[(weights < 0).any(axis=1)] = np.inf
            lowest = np.minimum(lowest, value)
    return lowest
