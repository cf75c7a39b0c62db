"""Clusters of markers with constant distances, and the tree that they form."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.cluster.hierarchy import fcluster, linkage
from scipy.sparse.csgraph import minimum_spanning_tree, shortest_path
from scipy.spatial.distance import squareform

from markermend.body.rigidity import Rigidity
from markermend.model import FloatArray

SMALLEST = 3
LARGEST = 9


def clusters_of(members: Sequence[int], rigidity: Rigidity) -> list[list[int]]:
    """Group one subject's markers into clusters of 3 to 9 (fewer only if there are no more).

    Average linkage; the cut is the one that separates best (largest mean silhouette) among those
    whose clusters have four to seven markers on average, since a body part carries that many.
    """
    members = list(members)
    if len(members) < 2 * SMALLEST:
        return [members] if members else []
    cost = rigidity.cost[np.ix_(members, members)].copy()
    finite = np.isfinite(cost)
    cost[~finite] = 10.0 * max(cost[finite].max(), 1.0)
    np.fill_diagonal(cost, 0.0)
    joined = linkage(squareform(cost, checks=False), "average")
    candidates = []
    for n in range(max(2, round(len(members) / 7)), max(2, round(len(members) / 4)) + 1):
        labels = fcluster(joined, n, "maxclust")
        labels = _at_least(_at_most(labels, cost, LARGEST), cost, SMALLEST)
        candidates.append((_silhouette(labels, cost), -n, labels))
    labels = max(candidates, key=lambda candidate: candidate[:2])[2]
    groups: dict[int, list[int]] = {}
    for member, label in zip(members, labels, strict=True):
        groups.setdefault(int(label), []).append(member)
    return sorted(groups.values())


def _at_most(labels: NDArray[np.int32], cost: FloatArray, size: int) -> NDArray[np.int32]:
    """Split every cluster of more than `size` in two, again and again."""
    labels = labels.copy()
    while True:
        counts = np.bincount(labels)
        if counts.max() <= size:
            return labels
        big = np.flatnonzero(labels == counts.argmax())
        inner = cost[np.ix_(big, big)]
        first, second = np.unravel_index(inner.argmax(), inner.shape)
        halves = np.argsort(inner[:, first] - inner[:, second], kind="stable")
        nearer = inner[halves, first] <= inner[halves, second]
        cut = int(np.clip(nearer.sum(), SMALLEST, len(big) - SMALLEST))
        labels[big[halves[cut:]]] = labels.max() + 1


def _at_least(labels: NDArray[np.int32], cost: FloatArray, size: int) -> NDArray[np.int32]:
    """Give the members of clusters of fewer than `size` to the clusters nearest to them."""
    labels = labels.copy()
    while True:
        names, counts = np.unique(labels, return_counts=True)
        if len(names) == 1 or counts.min() >= size:
            return labels
        small = labels == names[counts.argmin()]
        others = [name for name in names if name != names[counts.argmin()]]
        distance = [cost[np.ix_(small, labels == name)].mean() for name in others]
        labels[small] = others[int(np.argmin(distance))]


def _silhouette(labels: NDArray[np.int32], cost: FloatArray) -> float:
    names = np.unique(labels)
    if len(names) < 2:
        return -1.0
    inside = (labels[:, None] == names).astype(float)
    sums, counts = cost @ inside, inside.sum(axis=0)
    own = labels[:, None] == names
    within = sums[own] / np.maximum(counts[own.argmax(axis=1)] - 1, 1)
    nearest = np.where(own, np.inf, sums / counts).min(axis=1)
    return float(((nearest - within) / np.maximum(np.maximum(nearest, within), 1e-12)).mean())


def hang(clusters: Sequence[Sequence[int]], rigidity: Rigidity) -> list[int | None]:
    """Give the index of each cluster's parent, None for the root, for clusters of one subject.

    The tree is the one of smallest total cost, the cost of a link being that of the steadiest
    pairs across it; its root is the cluster from which all markers are nearest, the trunk.
    """
    n = len(clusters)
    if n < 2:
        return [None] * n
    link = np.zeros((n, n))
    for a in range(n):
        for b in range(a):
            pairs = np.sort(rigidity.cost[np.ix_(clusters[a], clusters[b])], axis=None)
            link[a, b] = link[b, a] = _usual(pairs[: min(3, len(pairs))])
    tree = minimum_spanning_tree(link + 1e-9 * (1 - np.eye(n)))
    steps = shortest_path(tree, directed=False)
    sizes = np.array([len(cluster) for cluster in clusters])
    root = int((steps @ sizes).argmin())
    _, before = shortest_path(tree, directed=False, indices=root, return_predecessors=True)
    return [None if c == root else int(before[c]) for c in range(n)]


def _usual(pairs: FloatArray) -> float:
    known = pairs[np.isfinite(pairs)]
    return float(known.mean()) if len(known) else 1e6


def parent_marker(cluster: Sequence[int], above: Sequence[int], rigidity: Rigidity) -> int:
    """Give the marker of the parent cluster that goes best with the cluster.

    "The one which is closest in terms of gradients coherence and distances constancy"
    (Skurowski & Pawlyta, section 3.3.2): smallest mean cost over mean coherence.
    """
    cost = rigidity.cost[np.ix_(above, cluster)]
    cost = np.where(np.isfinite(cost), cost, 1e6).mean(axis=1)
    coherence = rigidity.coherence[np.ix_(above, cluster)].mean(axis=1)
    return int(above[int((cost / np.clip(coherence, 0.1, 1.0)).argmin())])
