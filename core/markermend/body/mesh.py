"""The functional body mesh of a take, inferred from its data without a template."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from markermend.body import bones, tree
from markermend.body.rigidity import Rigidity, measure
from markermend.errors import UnknownName
from markermend.model import FloatArray, Take


@dataclass(frozen=True, eq=False)
class Body:
    """Clusters of markers that keep their distances, and the tree of these clusters.

    Markers are given by their index in the take.  Only measured markers that are seen at least
    once belong to the body.  Clusters stand in the order of the tree, from the trunk outwards,
    one subject after the other.

    Attributes
    ----------
    labels
        Names of all markers of the take.
    clusters
        Indices of the markers of each cluster.
    parents
        For each cluster the index of its parent cluster, None for the root of a subject.
    parent_markers
        For each cluster the one marker of its parent cluster that goes best with it, or None.
    bones
        Pairs of markers to be joined by lines: the shortest tree inside each cluster and one line
        from each cluster to its parent.
    distance, spread
        (n_markers, n_markers) mm: mean and standard deviation of the distance of each pair; NaN
        for markers that are not of the body or are never seen together.
    """

    labels: tuple[str, ...]
    clusters: tuple[tuple[int, ...], ...]
    parents: tuple[int | None, ...]
    parent_markers: tuple[int | None, ...]
    bones: tuple[tuple[int, int], ...]
    distance: FloatArray = field(repr=False)
    spread: FloatArray = field(repr=False)

    @property
    def n_clusters(self) -> int:
        """Number of clusters."""
        return len(self.clusters)

    @property
    def order(self) -> tuple[int, ...]:
        """All markers of the body, cluster by cluster: an order for an overview."""
        return tuple(marker for cluster in self.clusters for marker in cluster)

    @cached_property
    def _cluster(self) -> dict[int, int]:
        return {m: c for c, cluster in enumerate(self.clusters) for m in cluster}

    def cluster(self, marker: str | int) -> int | None:
        """Give the index of the cluster of a marker, None if it is not of the body."""
        return self._cluster.get(self._index(marker))

    def siblings(self, marker: str | int) -> tuple[int, ...]:
        """Give the other markers of its cluster, the steadiest first."""
        index = self._index(marker)
        found = self.cluster(index)
        if found is None:
            return ()
        mates = set(self.clusters[found])
        return tuple(other for other in self.neighbours(index) if other in mates)

    def parent(self, marker: str | int) -> int | None:
        """Give the parent marker of its cluster, None in the root cluster."""
        found = self.cluster(marker)
        return None if found is None else self.parent_markers[found]

    def neighbours(self, marker: str | int, n: int | None = None) -> tuple[int, ...]:
        """Give the other markers of the body by rigidity, the steadiest distance first.

        The rank is by the standard deviation of the distance plus 1 % of its mean; markers never
        seen together with this one are left out.
        """
        index = self._index(marker)
        cost = self.spread[index] + 0.01 * self.distance[index]
        ranked = np.argsort(cost, kind="stable")
        return tuple(int(m) for m in ranked if m != index and np.isfinite(cost[m]))[:n]

    def _index(self, marker: str | int) -> int:
        if isinstance(marker, str):
            if marker not in self.labels:
                raise UnknownName.among("marker", marker, self.labels)
            return self.labels.index(marker)
        if not 0 <= marker < len(self.labels):
            raise UnknownName.among("marker", str(marker), self.labels)
        return int(marker)


def infer(take: Take) -> Body:
    """Infer the functional body mesh of a take.

    Subjects (``Subject:LABEL``) are kept apart.  A few hundred frames are looked at, however long
    the take is; gaps and single artefacts do no harm.

    Parameters
    ----------
    take
        Any take; of two dimensions as well.

    Notes
    -----
    After Skurowski & Pawlyta, section 3.3.2 and Fig. 5: markers on one part of the body keep their
    distances, parts form a tree, and a part knows its parent by one marker.
    """
    usable = np.array([m for m in take.measured if take.seen[:, m].any()], np.intp)
    rigidity = measure(take.positions, take.seen, usable, take.rate)
    clusters: list[tuple[int, ...]] = []
    parents: list[int | None] = []
    parent_markers: list[int | None] = []
    lines: list[tuple[int, int]] = []
    for members in _subjects([take.labels[m] for m in usable]):
        groups = tree.clusters_of(members, rigidity)
        above = tree.hang(groups, rigidity)
        start, place = len(clusters), {g: at for at, g in enumerate(_outwards(groups, above))}
        for group in place:
            up = above[group]
            clusters.append(tuple(groups[group]))
            lines += bones.inside(groups[group], rigidity)
            if up is None:
                parents.append(None)
                parent_markers.append(None)
            else:
                parents.append(start + place[up])
                parent_markers.append(tree.parent_marker(groups[group], groups[up], rigidity))
                lines.append(bones.between(groups[group], groups[up], rigidity))
    whole = _spread_out(rigidity, usable.tolist(), take.n_markers)
    return Body(
        labels=take.labels,
        clusters=tuple(tuple(int(usable[m]) for m in cluster) for cluster in clusters),
        parents=tuple(parents),
        parent_markers=tuple(None if m is None else int(usable[m]) for m in parent_markers),
        bones=tuple((int(usable[a]), int(usable[b])) for a, b in lines),
        distance=whole[0],
        spread=whole[1],
    )


def _subjects(labels: Sequence[str]) -> list[list[int]]:
    """Group markers by the prefix before the colon."""
    groups: dict[str, list[int]] = {}
    for index, label in enumerate(labels):
        subject, colon, _ = label.rpartition(":")
        groups.setdefault(subject if colon else "", []).append(index)
    return list(groups.values())


def _outwards(groups: Sequence[Sequence[int]], above: Sequence[int | None]) -> list[int]:
    """Order clusters depth first from the root."""
    order: list[int] = []
    waiting = [g for g, up in enumerate(above) if up is None]
    while waiting:
        group = waiting.pop()
        order.append(group)
        waiting += sorted((g for g, up in enumerate(above) if up == group), reverse=True)
    return order


def _spread_out(
    rigidity: Rigidity, usable: Sequence[int], n_markers: int
) -> tuple[FloatArray, FloatArray]:
    """Write the statistics of the usable markers into tables over all markers of the take."""
    tables = []
    for table in (rigidity.distance, rigidity.spread):
        whole = np.full((n_markers, n_markers), np.nan)
        whole[np.ix_(usable, usable)] = table
        whole.flags.writeable = False
        tables.append(whole)
    return tables[0], tables[1]
