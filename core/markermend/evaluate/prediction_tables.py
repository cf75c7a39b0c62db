"""The tables of how well markers can be predicted."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

Printed = tuple[str, Sequence[str], Sequence[Sequence[str]]]
"""Title, columns and rows of a table for the terminal."""


@dataclass(frozen=True)
class Lagged:
    """Correlation of one coordinate of two markers over lags in frames (Fig. 3b)."""

    first: str
    second: str
    relation: str
    lags: tuple[int, ...]
    values: tuple[float, ...]


@dataclass(frozen=True)
class Correlation:
    """Correlation of x over all pairs of markers (Fig. 3a), markers in the order of the body."""

    labels: tuple[str, ...]
    matrix: tuple[tuple[float, ...], ...]
    lagged: tuple[Lagged, ...]


@dataclass(frozen=True)
class ResidualFit:
    """Histogram of one marker's residual and the Laplace density on it (Fig. 6, Eq. 5).

    Attributes
    ----------
    marker, variant
        Whose residual; ``"neighbours"``, or ``"with own past"``.
    sigma, b
        Standard deviation in mm, and b = sigma / sqrt(2).
    b_likelihood
        b by maximum likelihood: the mean absolute residual.
    edges, density
        Histogram.
    laplace
        Eq. 5 at the middle of each bin.
    """

    marker: str
    variant: str
    sigma: float
    b: float
    b_likelihood: float
    edges: tuple[float, ...]
    density: tuple[float, ...]
    laplace: tuple[float, ...]


@dataclass(frozen=True)
class SweepPoint:
    """P_k^L at one order and context: residual in mm, learnt and held out, and seconds a marker."""

    parameter: str
    order: int
    context: int
    learnt_mm: float
    held_out_mm: float
    seconds: float


@dataclass(frozen=True)
class ReplicaResidual:
    """Standard deviation in mm of each replica's residual, and of their mean (Fig. 9)."""

    marker: str
    replicas: tuple[float, ...]
    mean: float


@dataclass(frozen=True)
class RegressorScore:
    """One regressor: residual in mm, learnt and held out, what it shows of an artefact, seconds.

    `shown` is 1 where the residual holds the whole artefact and 0 where the prediction follows it.
    """

    name: str
    learnt_mm: float
    held_out_mm: float
    shown: float
    seconds: float


@dataclass(frozen=True)
class Predictors:
    """The tables that were asked for; the others are empty."""

    n_frames: int
    rate: float
    markers: tuple[str, ...]
    seed: int
    correlation: Correlation | None = None
    residuals: tuple[ResidualFit, ...] = ()
    sweep: tuple[SweepPoint, ...] = ()
    replicas: tuple[ReplicaResidual, ...] = ()
    regressors: tuple[RegressorScore, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """Give it in the form of ``markermend evaluate predictors --json``."""
        return {"version": 1, "experiment": "predictors", **asdict(self)}

    def tables(self) -> tuple[Printed, ...]:
        """Give title, columns and rows of each table for the terminal, curves left out."""
        made: list[Printed] = []
        if self.correlation is not None:
            peaks = [
                (lag.first, lag.second, lag.relation, f"{max(lag.values, key=abs):.3f}")
                for lag in self.correlation.lagged
            ]
            made.append(("correlation", ("marker", "with", "relation", "largest"), peaks))
        if self.residuals:
            fits = [
                (fit.marker, fit.variant, f"{fit.sigma:.3f}", f"{fit.b:.3f}")
                for fit in self.residuals
            ]
            made.append(("residuals", ("marker", "regressors", "sigma mm", "b mm"), fits))
        if self.sweep:
            points = [
                (str(p.order), str(p.context), f"{p.learnt_mm:.2f}", f"{p.held_out_mm:.2f}")
                for p in self.sweep
            ]
            made.append(("sweep", ("L", "k", "learnt mm", "held out mm"), points))
        if self.replicas:
            outputs = [
                (r.marker, " ".join(f"{x:.2f}" for x in r.replicas), f"{r.mean:.2f}")
                for r in self.replicas
            ]
            made.append(("replicas", ("marker", "each mm", "mean of all mm"), outputs))
        if self.regressors:
            scores = [
                (
                    r.name,
                    f"{r.learnt_mm:.2f}",
                    f"{r.held_out_mm:.2f}",
                    f"{r.shown:.2f}",
                    f"{r.seconds:.2f}",
                )
                for r in self.regressors
            ]
            columns = ("regressor", "learnt mm", "held out mm", "shown of an artefact", "seconds")
            made.append(("regressors", columns, scores))
        return tuple(made)
