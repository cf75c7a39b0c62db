"""An archive seen as a whole: which takes are worst, which markers fail, and where."""

from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from datetime import datetime
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from markermend.batch import records
from markermend.batch.records import Line
from markermend.model import KINDS, FloatArray, Kind
from markermend.review.store import Store

MOST_COLUMNS = 600
MOST_ROWS = 80


@dataclass(frozen=True)
class Sum:
    """Findings added up: how many, in how many takes, and the damage expected of them in mm s."""

    n_findings: int = 0
    n_takes: int = 0
    damage: float = 0.0


@dataclass(frozen=True)
class MarkerLine:
    """One marker over the whole archive.

    ``n_takes`` is in how many takes it is measured at all, ``by`` the sums by kind.
    """

    marker: str
    n_takes: int
    total: Sum
    by: Mapping[Kind, Sum]


@dataclass(frozen=True, eq=False)
class Picture:
    """Markers by takes.

    Attributes
    ----------
    markers
        Of the rows, the worst first.
    takes
        Of each column the names of its takes, in the order of names; one each, unless there are
        more than `MOST_COLUMNS`.
    mm
        (n_markers, n_columns): damage over duration, which is the mean error in mm that is to be
        expected of the marker over the take; NaN where the marker is not in the take.
    """

    markers: tuple[str, ...]
    takes: tuple[tuple[str, ...], ...]
    mm: FloatArray


@dataclass(frozen=True)
class Overview:
    """An archive as it was last looked at.

    Attributes
    ----------
    folder
        The archive.
    lines
        All takes, by name.
    settings, begun
        How it was looked at, as `Settings.to_json`, and when that was begun.
    """

    folder: Path
    lines: tuple[Line, ...]
    settings: Mapping[str, Any]
    begun: datetime

    @cached_property
    def worst_first(self) -> tuple[Line, ...]:
        """The takes that are done, by expected damage."""
        done = (line for line in self.lines if line.ended == "done")
        return tuple(sorted(done, key=lambda line: (-line.summary["damage"], line.name)))

    @cached_property
    def not_done(self) -> tuple[Line, ...]:
        """The takes that failed, and then those that were refused."""
        return tuple(
            line for ended in ("failed", "refused") for line in self.lines if line.ended == ended
        )

    @cached_property
    def kinds(self) -> Mapping[Kind, Sum]:
        """The sums of each kind over all markers and takes."""
        sums: dict[Kind, Sum] = dict.fromkeys(KINDS, Sum())
        for line in self.worst_first:
            for kind in KINDS:
                cells = [row[kind] for row in line.summary["by"].values() if kind in row]
                if cells:
                    sums[kind] = _plus(sums[kind], cells)
        return sums

    @cached_property
    def markers(self) -> tuple[MarkerLine, ...]:
        """All measured markers, the one with the most damage first."""
        sums: dict[str, dict[Kind, Sum]] = defaultdict(dict)
        affected: dict[str, int] = defaultdict(int)
        measured: dict[str, int] = defaultdict(int)
        for line in self.worst_first:
            for marker in line.summary["markers"]:
                measured[marker] += 1
            for marker, row in line.summary["by"].items():
                affected[marker] += 1
                for kind in KINDS:
                    if kind in row:
                        sums[marker][kind] = _plus(sums[marker].get(kind, Sum()), [row[kind]])
        found = (
            MarkerLine(
                marker,
                n,
                Sum(
                    sum(one.n_findings for one in sums[marker].values()),
                    affected[marker],
                    sum(one.damage for one in sums[marker].values()),
                ),
                sums[marker],
            )
            for marker, n in measured.items()
        )
        return tuple(sorted(found, key=lambda m: (-m.total.damage, -m.total.n_findings, m.marker)))

    @cached_property
    def picture(self) -> Picture:
        """Markers by takes, the worst `MOST_ROWS` markers and all takes."""
        lines = sorted(self.worst_first, key=lambda line: (line.name.casefold(), line.name))
        rows = [m.marker for m in self.markers[:MOST_ROWS]]
        place = {marker: i for i, marker in enumerate(rows)}
        n_columns = min(len(lines), MOST_COLUMNS)
        column = np.arange(len(lines)) * n_columns // max(1, len(lines))
        damage = np.zeros((len(rows), n_columns))
        duration = np.zeros((len(rows), n_columns))
        takes: list[list[str]] = [[] for _ in range(n_columns)]
        for at, line in zip(column, lines, strict=True):
            takes[at].append(line.name)
            for marker in line.summary["markers"]:
                if marker in place:
                    duration[place[marker], at] += line.summary["duration_s"]
            for marker, row in line.summary["by"].items():
                if marker in place:
                    damage[place[marker], at] += sum(size for _, size in row.values())
        with np.errstate(invalid="ignore"):
            mm = damage / np.where(duration > 0, duration, np.nan)
        return Picture(tuple(rows), tuple(tuple(names) for names in takes), mm)


def overview(store: Store, folder: Path) -> Overview | None:
    """Give the archive that a folder was last looked at as, or None if it never was."""
    folder = folder.resolve()
    archive = records.latest(store, folder)
    if archive is None:
        return None
    lines = records.lines(store, archive.id)
    return Overview(folder, lines, archive.settings, archive.begun)


def _plus(one: Sum, cells: Iterable[tuple[int, float]]) -> Sum:
    """Add the findings of one more take."""
    cells = tuple(cells)
    return Sum(
        one.n_findings + int(sum(n for n, _ in cells)),
        one.n_takes + 1,
        one.damage + sum(size for _, size in cells),
    )
