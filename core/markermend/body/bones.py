"""Bones for drawing: few lines that look like the body."""

from collections.abc import Sequence

import numpy as np
from scipy.sparse.csgraph import minimum_spanning_tree

from markermend.body.rigidity import Rigidity

Pair = tuple[int, int]


def inside(cluster: Sequence[int], rigidity: Rigidity) -> list[Pair]:
    """Give the shortest lines that join all markers of a cluster."""
    distance = rigidity.distance[np.ix_(cluster, cluster)]
    tree = minimum_spanning_tree(np.where(np.isfinite(distance), distance + 1e-6, 1e6)).tocoo()
    ends = zip(tree.row.tolist(), tree.col.tolist(), strict=True)
    return sorted(_pair(cluster[a], cluster[b]) for a, b in ends)


def between(cluster: Sequence[int], above: Sequence[int], rigidity: Rigidity) -> Pair:
    """Give the line that joins two clusters: short, and of steady length."""
    rows = np.ix_(cluster, above)
    cost = rigidity.distance[rows] + 3.0 * rigidity.spread[rows]
    cost = np.where(np.isfinite(cost), cost, 1e6)
    a, b = np.unravel_index(int(cost.argmin()), cost.shape)
    return _pair(cluster[int(a)], above[int(b)])


def _pair(a: int, b: int) -> Pair:
    return (int(min(a, b)), int(max(a, b)))
