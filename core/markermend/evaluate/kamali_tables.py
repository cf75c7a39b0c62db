"""What the experiment of Kamali et al. gives: errors, tests between methods, and the sweep."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from markermend.evaluate.cycles import Cycle
from markermend.evaluate.kamali_splits import Split

Table = tuple[str, tuple[str, ...], list[tuple[str, ...]]]
SPLITS = {
    "gaps": "Mean error in mm by the number of gaps in a mask (and gaps filled)",
    "share": "Mean error in mm by the length of a gap in cycles (and gaps filled)",
}


@dataclass(frozen=True)
class Cell:
    """One method on one take with one set of markers: a box of Fig. 4.

    Attributes
    ----------
    take, markers, method
        What.
    weight
        The lambda that was used, or None.
    mean_mm, sd_mm, median_mm
        Over the masks; each counts with the mean distance (Euclidean) over its gaps.
    rmse_mm
        Root mean square over all gaps.
    gaps, refused
        Gaps, and those that the method did not fill.
    unconverged
        Masks in which the solver stopped before its tolerance was met.
    masks_mm
        The mean of every mask; None where none of its gaps was filled.
    """

    take: str
    markers: int
    method: str
    weight: float | None
    mean_mm: float | None
    sd_mm: float | None
    median_mm: float | None
    rmse_mm: float | None
    gaps: int
    refused: int
    unconverged: int
    masks_mm: tuple[float | None, ...]


@dataclass(frozen=True)
class Pair:
    """Two methods on the same masks (Table 1).

    Attributes
    ----------
    first, second
        The methods; the paper says that the first errs less, or the first is what we recommend.
    masks
        Masks compared, each by the gaps that both have filled.
    difference_mm
        Mean of the first's error less the second's.
    p
        Two-sided Wilcoxon signed-rank test over the masks; None where they cannot be told apart.
    """

    take: str
    markers: int
    first: str
    second: str
    masks: int
    difference_mm: float | None
    p: float | None

    @property
    def holds(self) -> bool:
        """Whether the first errs less, with p below 0.05."""
        return (
            self.p is not None
            and self.p < 0.05
            and self.difference_mm is not None
            and self.difference_mm < 0.0
        )


@dataclass(frozen=True)
class Point:
    """One point of Fig. 3b, on masks that are used for nothing else."""

    take: str
    markers: int
    method: str
    weight: float
    masks: int
    mean_mm: float
    sd_mm: float


@dataclass(frozen=True)
class Ordering:
    """Whether GS-LR < S-LR < nuclear norm and WPCA, by their means, and in every test of a pair."""

    take: str
    markers: int
    best_first: tuple[str, ...]
    by_means: bool
    by_tests: bool


@dataclass(frozen=True)
class Example:
    """One gap as it was and as it was filled (Fig. 3a), mm."""

    take: str
    marker: str
    start: int
    truth: tuple[tuple[float, ...], ...]
    filled: tuple[tuple[float, ...], ...]


@dataclass(frozen=True)
class Kamali:
    """The whole experiment.

    Attributes
    ----------
    cycles
        The cycle of every take.
    cycles_in_window
        Cycles that a window holds.
    labels
        The markers of every set on every take.
    """

    seed: int
    masks: int
    cycles_in_window: dict[str, int]
    cycles: dict[str, Cycle]
    labels: dict[str, dict[str, tuple[str, ...]]]
    cells: tuple[Cell, ...]
    pairs: tuple[Pair, ...]
    sweep: tuple[Point, ...]
    orderings: tuple[Ordering, ...]
    examples: tuple[Example, ...]
    splits: tuple[Split, ...]

    def to_json(self) -> dict[str, Any]:
        """Give it in the form of ``markermend evaluate kamali --json``."""
        record = asdict(self)
        record["pairs"] = [{**asdict(pair), "holds": pair.holds} for pair in self.pairs]
        return {"version": 1, "experiment": "kamali", **record}

    def tables(self) -> list[Table]:
        """Give titles, columns and rows for the terminal."""
        return [
            (
                "Cycles, and how alike one is to the next (1 = exactly)",
                ("take", "cycle s", "likeness", "cycles in a window"),
                [
                    (
                        name,
                        f"{cycle.seconds:.3f}",
                        f"{cycle.likeness:.4f}",
                        str(self.cycles_in_window[name]),
                    )
                    for name, cycle in self.cycles.items()
                ],
            ),
            self._sweep_table(),
            (
                f"Errors in mm over {self.masks} masks (Fig. 4)",
                (
                    "take", "markers", "method", "lambda", "mean", "sd", "median", "RMSE", "gaps",
                    "refused", "unconverged",
                ),
                [
                    (
                        cell.take,
                        str(cell.markers),
                        cell.method,
                        "-" if cell.weight is None else f"{cell.weight:g}",
                        *map(_mm, (cell.mean_mm, cell.sd_mm, cell.median_mm, cell.rmse_mm)),
                        str(cell.gaps),
                        str(cell.refused),
                        str(cell.unconverged),
                    )
                    for cell in self.cells
                ],
            ),
            *(self._split_table(by, title) for by, title in SPLITS.items()),
            (
                "Wilcoxon signed-rank tests over masks (Table 1)",
                ("take", "markers", "first", "second", "masks", "difference", "p", "holds"),
                [
                    (
                        pair.take,
                        str(pair.markers),
                        pair.first,
                        pair.second,
                        str(pair.masks),
                        _mm(pair.difference_mm),
                        "-" if pair.p is None else f"{pair.p:.4f}",
                        "yes" if pair.holds else "no",
                    )
                    for pair in self.pairs
                ],
            ),
            (
                "The paper's ordering: GS-LR < S-LR < nuclear norm (svt) and PCA (wpca)",
                ("take", "markers", "in the means", "in all tests", "best first"),
                [
                    (
                        one.take,
                        str(one.markers),
                        "yes" if one.by_means else "no",
                        "yes" if one.by_tests else "no",
                        " < ".join(one.best_first),
                    )
                    for one in self.orderings
                ],
            ),
        ]  # fmt: skip

    def _split_table(self, by: str, title: str) -> Table:
        rows: dict[tuple[str, int, str], dict[str, str]] = {}
        for one in self.splits:
            if one.by == by:
                row = rows.setdefault((one.take, one.markers, one.method), {})
                row[one.name] = f"{_mm(one.mean_mm)} ({one.n})"
        classes = tuple(dict.fromkeys(one.name for one in self.splits if one.by == by))
        return (
            title,
            ("take", "markers", "method", *classes),
            [
                (take, str(markers), name, *(row[c] for c in classes))
                for (take, markers, name), row in rows.items()
            ],
        )

    def _sweep_table(self) -> Table:
        weights = sorted({point.weight for point in self.sweep})
        rows: dict[tuple[str, int, str], dict[float, Point]] = {}
        for point in self.sweep:
            rows.setdefault((point.take, point.markers, point.method), {})[point.weight] = point
        return (
            "Mean error in mm by lambda, on masks of their own (Fig. 3b)",
            ("take", "markers", "method", *(f"{weight:g}" for weight in weights)),
            [
                (take, str(markers), name, *(_mm(points[w].mean_mm) for w in weights))
                for (take, markers, name), points in rows.items()
            ],
        )


def _mm(value: float | None) -> str:
    return "-" if value is None else f"{value:.2f}"


def ordering(take: str, markers: int, cells: Sequence[Cell], pairs: Sequence[Pair]) -> Ordering:
    """Compare with the paper's ordering on one take with one set of markers."""
    means = {cell.method: cell.mean_mm for cell in cells if cell.mean_mm is not None}
    gslr, slr = means.get("gslr"), means.get("slr")
    others = [means[name] for name in ("svt", "wpca") if name in means]
    return Ordering(
        take,
        markers,
        tuple(sorted(means, key=lambda name: means[name])),
        by_means=gslr is not None and slr is not None and gslr < slr < min(others, default=-1.0),
        by_tests=all(pair.holds for pair in pairs if pair.first != "auto"),
    )
