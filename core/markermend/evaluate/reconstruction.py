"""Experiment E3: how much of an artefact a repair removes, with perfect and with detected spans."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from markermend.detection import detect, overlapping
from markermend.errors import BadInput
from markermend.evaluate.contamination import contaminate
from markermend.evaluate.parallel import in_order
from markermend.model import Finding, FloatArray, Kind, Span, Take
from markermend.repairing import REPAIRS, Wish, apply, repair_all
from markermend.truth import Truth

KINDS: tuple[Kind, ...] = ("peak", "noise", "step", "slow")
METHODS = ("linear", "savgol", "spline", "ffnn", "")
"""The four of the paper, and the default of each kind."""
SPANS = ("perfect", "detected")
MARGIN = 4
"""Frames at 100 Hz by which found spans are widened on each side: their ends are not known to the
frame, and one frame that is left distorted is worse than several that are filled."""


@dataclass(frozen=True)
class Reconstruction:
    """One cell of the paper's Tables 3 to 5, averaged over simulations.

    Attributes
    ----------
    kind, share, method, spans
        What was put in, what mended it (empty: the default of the kind), and where: at the true
        spans or at those that the detector found.
    simulations
        Number of simulations.
    rmse_mm, sd_mm
        Root mean square error over all coordinates and frames (Eq. 38), and its standard deviation
        over simulations.
    distorted_mm
        The same before the repair.
    in_span_mm
        Root mean square error over the distorted coordinates in the true spans.
    refused
        Spans that the method could not repair, of all.
    repaired
        Spans handed to the method.
    """

    kind: Kind
    share: float
    method: str
    spans: str
    simulations: int
    rmse_mm: float
    sd_mm: float
    distorted_mm: float
    in_span_mm: float
    refused: int
    repaired: int


@dataclass(frozen=True)
class Reconstructions:
    """The whole experiment on one take."""

    n_frames: int
    n_markers: int
    rate: float
    seed: int
    amplitude_mm: float
    detector: str
    cells: tuple[Reconstruction, ...]

    def to_json(self) -> dict[str, Any]:
        """Give it in the form of ``markermend evaluate e3 --json``."""
        return {
            "version": 1,
            "experiment": "e3",
            **{k: v for k, v in asdict(self).items() if k != "cells"},
            "cells": [asdict(cell) for cell in self.cells],
        }

    def table(self) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
        """Give the columns and rows of a table for the terminal."""
        columns = (
            "share", "kind", "method", "spans", "distorted", "RMSE mm", "sd", "in span mm",
            "refused",
        )  # fmt: skip
        return columns, [
            (
                f"{cell.share:g}",
                cell.kind,
                cell.method or "default",
                cell.spans,
                f"{cell.distorted_mm:.5f}",
                f"{cell.rmse_mm:.5f}",
                f"{cell.sd_mm:.5f}",
                f"{cell.in_span_mm:.3f}",
                f"{cell.refused}/{cell.repaired}",
            )
            for cell in self.cells
        ]


@dataclass(frozen=True, eq=False)
class _Task:
    take: Take
    kind: Kind
    share: float
    methods: tuple[str, ...]
    amplitude_mm: float
    detector: str
    seed: int


def e3(
    take: Take,
    *,
    methods: Sequence[str] = METHODS,
    shares: Sequence[float] = (0.05, 0.1, 0.2),
    kinds: Sequence[Kind] = KINDS,
    amplitude_mm: float = 10.0,
    detector: str,
    simulations: int = 20,
    jobs: int = 1,
    seed: int = 0,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Reconstructions:
    """Distort a take, mend it, and measure what is left.

    Parameters
    ----------
    take
        A take without artefacts or gaps in its measured markers.
    methods
        Names of registered repairs; an empty name is the default of the kind.
    shares, kinds, amplitude_mm
        Of the contamination; one kind and one axis at a time.
    detector
        Name of the detector for the rows with detected spans; every finding of whatever kind is
        repaired, as in the paper, over its span and a few frames more.
    simulations, jobs, seed, progress
        As in `markermend.evaluate.e1`.

    Raises
    ------
    BadInput
        If there is nothing to simulate.
    UnknownName
        If a method or detector is unknown.

    Notes
    -----
    Skurowski & Pawlyta, sections 4.1.2 and 4.2.3, Tables 3 to 5. One coordinate is distorted at a
    time, so that the error over everything is the error in the spans times
    sqrt(share / (3 n_markers)).
    """
    if simulations < 1 or not (methods and shares and kinds):
        raise BadInput("Nothing to simulate; give a method, a share, a kind and a simulation.")
    for name in methods:
        if name:
            REPAIRS.get(name)
        if name == "leave":
            raise BadInput("A span that is left as a gap has no error; choose another method.")
    conditions = [(share, kind) for share in shares for kind in kinds]
    tasks = [
        _Task(
            take,
            kind,
            share,
            tuple(methods),
            amplitude_mm,
            detector,
            int(np.random.SeedSequence((seed, simulation)).generate_state(1)[0]),
        )
        for share, kind in conditions
        for simulation in range(simulations)
    ]
    results = in_order(_simulate, tasks, jobs, lambda done: progress(done, len(tasks)))
    cells: list[Reconstruction] = []
    for share, kind in conditions:
        some = [next(results) for _ in range(simulations)]
        for i, (spans, method) in enumerate((s, m) for m in methods for s in SPANS):
            figures = np.array([one[i] for one in some])
            rmse, distorted, in_span = figures[:, :3].T
            cells.append(
                Reconstruction(
                    kind,
                    share,
                    method,
                    spans,
                    simulations,
                    float(rmse.mean()),
                    float(rmse.std()),
                    float(distorted.mean()),
                    float(np.sqrt(np.mean(in_span**2))),
                    int(figures[:, 3].sum()),
                    int(figures[:, 4].sum()),
                )
            )
    return Reconstructions(
        take.n_frames, len(take.measured), take.rate, seed, amplitude_mm, detector, tuple(cells)
    )


def _simulate(task: _Task) -> list[tuple[float, ...]]:
    distorted, truths = contaminate(
        task.take, (task.kind,), amplitude_mm=task.amplitude_mm, share=task.share, seed=task.seed
    )
    clean = task.take.positions[:, task.take.measured]
    before = _rms(distorted.positions[:, task.take.measured] - clean)
    found = detect(distorted, task.detector, kinds=KINDS)
    wanted: dict[str, list[tuple[str, Span, Kind, str | None]]] = {
        "perfect": [(t.marker, t.span, t.kind, None) for t in truths],
        "detected": [_one(group) for group in overlapping(_widened(found, task.take))],
    }
    figures: list[tuple[float, ...]] = []
    for method in task.methods:
        for spans in SPANS:
            wishes = [
                Wish(marker, span, kind, partner, method)
                for marker, span, kind, partner in wanted[spans]
            ]
            repairs, refusals = repair_all(distorted, wishes)
            mended = apply(distorted, repairs)
            away = mended.positions[:, task.take.measured] - clean
            inside = _inside(task.take, mended, truths)
            figures.append((_rms(away), before, inside, len(refusals), len(wishes)))
    return figures


def _widened(found: Sequence[Finding], take: Take) -> list[Finding]:
    """Let spans begin before and end after what was found, except those of single frames."""
    margin = max(1, round(MARGIN * take.rate / 100.0))
    return [
        one if one.kind == "peak" else replace(one, span=one.span.padded(margin, take.n_frames))
        for one in found
    ]


def _one(group: Sequence[Finding]) -> tuple[str, Span, Kind, str | None]:
    longest = max(group, key=lambda finding: len(finding.span))
    span = Span(min(f.span.start for f in group), max(f.span.stop for f in group))
    return longest.marker, span, longest.kind, longest.partner


def _inside(clean: Take, mended: Take, truths: Sequence[Truth]) -> float:
    """Root mean square error on the distorted axes within the true spans."""
    errors = []
    for truth in truths:
        marker = clean.index(truth.marker)
        away = (
            mended.positions[truth.span.frames, marker] - clean.positions[truth.span.frames, marker]
        )
        errors.append(away[:, ["xyz".index(axis) for axis in truth.axes]].ravel())
    return _rms(np.concatenate(errors)) if errors else 0.0


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.nanmean(values**2)))
