"""What the experiment of Li et al. gives: rows of tables, which are points of its figures too."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

Table = tuple[str, tuple[str, ...], list[tuple[str, ...]]]


@dataclass(frozen=True)
class Row:
    """One method under one condition, over all pieces.

    Attributes
    ----------
    figure
        The table and figures of the paper that it belongs to.
    dims
        3 (errors in mm), or 2 (in px): a simulated camera.
    given
        What the methods see: the piece and, where they learn, a training set; or the whole take.
    setting, x
        The condition in words, and as a number.
    method
        Name in the table.
    gaps, refused
        Gaps, and those that it did not fill.
    mean, sd
        Mean distance over the frames of a gap (Eq. 17), averaged over the gaps of a piece: mean
        and standard deviation over the pieces.
    rmse
        Root mean square over all gaps.
    first, middle, last
        Mean distance in these frames of a gap (Figs. 10 and 11).
    pieces
        The mean of each piece (Fig. 4); None where nothing was filled.
    markers
        The mean of each marker over the pieces (Figs. 6 and 7).
    """

    figure: str
    dims: int
    given: str
    setting: str
    x: float
    method: str
    gaps: int
    refused: int
    mean: float | None
    sd: float | None
    rmse: float | None
    first: float | None
    middle: float | None
    last: float | None
    pieces: tuple[float | None, ...]
    markers: dict[str, float | None]


@dataclass(frozen=True)
class Sample:
    """A trajectory as it was and as it was filled (Figs. 5, 10 and 11).

    Attributes
    ----------
    frames
        Frames of the piece.
    truth, filled
        (n_frames, n_dims) in mm or px.
    """

    figure: str
    dims: int
    setting: str
    method: str
    marker: str
    frames: tuple[int, ...]
    truth: tuple[tuple[float, ...], ...]
    filled: tuple[tuple[float, ...], ...]


@dataclass(frozen=True)
class Weighting:
    """The rank and the weights W that Eq. 13 chose for the blackouts of one length.

    Attributes
    ----------
    scales
        Of the candidates, in frames: weights fall off by exp(-distance / scale); None is all alike.
    ranks
        Rank chosen in each piece.
    chosen
        Index of the scale chosen in each piece.
    diagonal
        The w_l of the scale chosen most often, from the farthest to the nearest frame before the
        blackout, largest 1.
    """

    dims: int
    setting: str
    scales: tuple[float | None, ...]
    ranks: tuple[int, ...]
    chosen: tuple[int, ...]
    diagonal: tuple[float, ...]


@dataclass(frozen=True)
class Timing:
    """Seconds for the five gaps of one piece (Table 4): the least of three runs."""

    method: str
    training_frames: int
    seconds: float


@dataclass(frozen=True)
class Li:
    """The whole experiment.

    Attributes
    ----------
    starts
        The take and the first frame of every piece.
    labels
        The markers, in three dimensions if those were asked for first.
    projected
        What the two dimensions are; empty without them.
    """

    seed: int
    rate: float
    pieces: int
    piece_frames: int
    starts: tuple[tuple[int, int], ...]
    labels: tuple[str, ...]
    projected: str
    rows: tuple[Row, ...]
    weights: tuple[Weighting, ...]
    samples: tuple[Sample, ...]
    times: tuple[Timing, ...]

    def to_json(self) -> dict[str, Any]:
        """Give it in the form of ``markermend evaluate li --json``."""
        return {"version": 1, "experiment": "li", **asdict(self)}

    def tables(self) -> list[Table]:
        """Give titles, columns and rows for the terminal."""
        groups: dict[tuple[str, int, str], list[Row]] = {}
        for row in self.rows:
            groups.setdefault((row.figure, row.dims, row.given), []).append(row)
        shown = [self._errors(*key, rows) for key, rows in groups.items()]
        ratios = self._ratios()
        if ratios:
            columns = ("", "blackout", "best rank", "its mean", "auto", "ratio", "spline", "ratio")
            shown.append(("AUTO beside the best rank of Eq. 16 and the spline", columns, ratios))
        if self.weights:
            shown.append(self._weights())
        if self.times:
            shown.append(
                (
                    "Table 4: seconds for five gaps",
                    ("method", "training frames", "seconds"),
                    [(t.method, str(t.training_frames), f"{t.seconds:.4f}") for t in self.times],
                )
            )
        return shown

    def _errors(self, figure: str, dims: int, given: str, rows: Sequence[Row]) -> Table:
        settings = list(dict.fromkeys(row.setting for row in rows))
        lines: dict[str, dict[str, Row]] = {}
        for row in rows:
            lines.setdefault(row.method, {})[row.setting] = row
        unit = "mm" if dims == 3 else "px of a simulated camera"
        title = (
            f"{figure}, {dims}D, given {given}: mean error ± sd over {self.pieces} pieces, "
            f"(RMSE), in {unit}; *: not all gaps filled"
        )
        return (
            title,
            ("method", *settings),
            [
                (method, *(_error(found.get(setting)) for setting in settings))
                for method, found in lines.items()
            ],
        )

    def _ratios(self) -> list[tuple[str, ...]]:
        """Compare over all gaps of a length; the rank is chosen with the errors in sight."""
        groups: dict[tuple[int, str], dict[str, float]] = {}
        for row in self.rows:
            if row.figure.startswith("Blackouts") and row.mean is not None:
                groups.setdefault((row.dims, row.setting), {})[row.method] = row.mean
        shown: list[tuple[str, ...]] = []
        for (dims, setting), means in groups.items():
            ranks = [name for name in means if " rank " in name]
            if not ranks or not {"auto", "spline"} <= means.keys():
                continue
            best = min(ranks, key=lambda name: means[name])
            auto = means["auto"]
            shown.append(
                (
                    f"{dims}D",
                    setting,
                    best.split()[-1],
                    f"{means[best]:.2f}",
                    f"{auto:.2f}",
                    f"{auto / means[best]:.2f}",
                    f"{means['spline']:.2f}",
                    f"{auto / means['spline']:.2f}",
                )
            )
        return shown

    def _weights(self) -> Table:
        rows: list[tuple[str, ...]] = []
        for one in self.weights:
            names = ["all alike" if s is None else f"{s:g} frames" for s in one.scales]
            counts = (f"{names[i]}: {one.chosen.count(i)}" for i in sorted(set(one.chosen)))
            ranks = f"{min(one.ranks)} to {max(one.ranks)}"
            rows.append((f"{one.dims}D", one.setting, ranks, ", ".join(counts)))
        return "Eq. 13: rank, and weights by scale", ("", "blackout", "rank", "pieces"), rows


def _error(row: Row | None) -> str:
    if row is None:
        return ""
    if row.mean is None or row.sd is None or row.rmse is None:
        return "refused"
    star = "*" if row.refused else ""
    return f"{row.mean:.2f} ± {row.sd:.2f} ({row.rmse:.2f}){star}"
