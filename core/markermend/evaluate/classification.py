"""Experiment E1: how well detectors find and classify artefacts that were put in."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from markermend.detection import detect
from markermend.detection.likelihood.star import confirmed, star_jumps
from markermend.detection.run import DEFAULT
from markermend.errors import BadInput
from markermend.evaluate.contamination import contaminate
from markermend.evaluate.parallel import in_order
from markermend.evaluate.scores import (
    CLASSES,
    Matches,
    Rates,
    confusion,
    match,
    overall_f,
    overall_mcc,
    rates,
    standard_errors,
)
from markermend.model import FloatArray, Take

KINDS = CLASSES[1:]


@dataclass(frozen=True)
class SpanFigures:
    """What an operator meets, of one kind.

    Attributes
    ----------
    true, found
        Artefacts put in over all simulations, and those found: right marker, right kind, IoU of
        at least 0.5.
    called
        Findings over all simulations.
    false_per_minute
        Findings that overlap no artefact, per minute of the take.
    unmodified_per_minute
        Findings on the take as it is, per minute.
    confirmed_per_minute
        Those among them that jump without any model's help: the marker's distances to its mates
        jump there, and those among the mates do not. They are hardly false.
    """

    true: int
    found: int
    called: int
    false_per_minute: float
    unmodified_per_minute: float
    confirmed_per_minute: float = 0.0

    @property
    def found_percent(self) -> float | None:
        """Share of the artefacts that were found."""
        return 100.0 * self.found / self.true if self.true else None


@dataclass(frozen=True, eq=False)
class Cell:
    """One detector at one amplitude and one share.

    Attributes
    ----------
    detector, amplitude_mm, share, simulations
        What was done.
    matrix
        (5, 5) mean number of samples, truth by finding, in the order of `CLASSES` (Figs. 12, 13).
    classes
        Measures of each class, clear included.
    f, mcc
        Over all classes; clear samples dominate both.
    spans
        Figures per kind.
    errors
        Standard errors of ``tpr`` and ``fpr`` of each class over the simulations, in per cent.
    """

    detector: str
    amplitude_mm: float
    share: float
    simulations: int
    matrix: FloatArray
    classes: Mapping[str, Rates]
    f: float | None
    mcc: float | None
    spans: Mapping[str, SpanFigures]
    errors: Mapping[str, tuple[float | None, float | None]] = field(default_factory=dict)

    def to_json(self) -> dict[str, Any]:
        """Give it as a record."""
        return {
            "detector": self.detector,
            "amplitude_mm": self.amplitude_mm,
            "share": self.share,
            "simulations": self.simulations,
            "matrix": self.matrix.tolist(),
            "classes": {name: asdict(rate) for name, rate in self.classes.items()},
            "errors": {name: {"tpr": tpr, "fpr": fpr} for name, (tpr, fpr) in self.errors.items()},
            "f": self.f,
            "mcc": self.mcc,
            "spans": {
                kind: {**asdict(figures), "found_percent": figures.found_percent}
                for kind, figures in self.spans.items()
            },
        }


@dataclass(frozen=True, eq=False)
class Classification:
    """The whole experiment on one take."""

    n_frames: int
    n_markers: int
    rate: float
    seed: int
    cells: tuple[Cell, ...]
    parameters: Mapping[str, Any] = field(default_factory=dict)

    def to_json(self) -> dict[str, Any]:
        """Give it in the form of ``markermend evaluate e1 --json``."""
        return {
            "version": 1,
            "experiment": "e1",
            "n_frames": self.n_frames,
            "n_markers": self.n_markers,
            "rate": self.rate,
            "seed": self.seed,
            "parameters": dict(self.parameters),
            "classes": list(CLASSES),
            "cells": [cell.to_json() for cell in self.cells],
        }

    def table(self) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
        """Give the columns and rows of a table for the terminal: one row per kind, one of all."""
        columns = (
            "detector", "mm", "share", "class", "TPR %", "+-", "FPR %", "+-", "F", "MCC", "found %",
            "false/min", "unmodified/min", "of these jump",
        )  # fmt: skip
        rows = []
        for cell in self.cells:
            for kind in KINDS:
                rate, spans = cell.classes[kind], cell.spans[kind]
                off = cell.errors.get(kind, (None, None))
                numbers = (
                    rate.tpr, off[0], rate.fpr, off[1], rate.f, rate.mcc, spans.found_percent
                )  # fmt: skip
                digits = (1, 1, 1, 1, 3, 3, 1)
                rows.append(
                    (
                        cell.detector,
                        f"{cell.amplitude_mm:g}",
                        f"{cell.share:g}",
                        kind,
                        *map(_rounded, numbers, digits),
                        f"{spans.false_per_minute:.1f}",
                        f"{spans.unmodified_per_minute:.1f}",
                        f"{spans.confirmed_per_minute:.1f}",
                    )
                )
            # Clear samples dominate what is said of all.
            rows.append(
                (
                    cell.detector,
                    f"{cell.amplitude_mm:g}",
                    f"{cell.share:g}",
                    "all",
                    *("-",) * 4,
                    _rounded(cell.f, 4),
                    _rounded(cell.mcc, 4),
                    *("-",) * 4,
                )
            )
        return columns, rows


def _rounded(number: float | None, digits: int) -> str:
    return "-" if number is None else f"{number:.{digits}f}"


@dataclass(frozen=True)
class _Task:
    take: Take
    detector: str
    amplitude_mm: float
    share: float
    seed: int
    parameters: Mapping[str, Any]


def e1(
    take: Take,
    *,
    detectors: Sequence[str] = (DEFAULT,),
    amplitudes: Sequence[float] = (5.0, 10.0),
    shares: Sequence[float] = (0.05, 0.1, 0.2),
    simulations: int = 100,
    jobs: int = 1,
    seed: int = 0,
    progress: Callable[[int, int], None] = lambda done, total: None,
    **parameters: Any,
) -> Classification:
    """Contaminate a take many times and count what detectors make of it.

    Parameters
    ----------
    take
        A take without artefacts, or as good as.
    detectors
        Names of registered detectors; all see the same contaminated takes.
    amplitudes
        Mean amplitudes in mm.
    shares
        Shares of the time that each kind takes.
    simulations
        Contaminations per amplitude and share.
    jobs
        Processes; the result does not depend on it.
    seed
        Of everything; simulation i is the same at any number of simulations.
    progress
        Called with the number of simulations done and of all.
    **parameters
        Of the detectors.

    Raises
    ------
    BadInput
        If there is nothing to simulate.
    UnknownName, BadParameter
        If a detector or a parameter is unknown or out of bounds.

    Notes
    -----
    Skurowski & Pawlyta, sections 4.1.2 and 4.2.1: all four kinds in equal proportions, Eq. 31 to
    37, averaged confusion matrices as in Figs. 12 and 13.
    """
    if simulations < 1 or not detectors or not amplitudes or not shares:
        raise BadInput(
            "Nothing to simulate; give at least one detector, amplitude, share and simulation."
        )
    jumps = star_jumps(take)
    unmodified = {}
    for detector in detectors:
        found = detect(take, detector, kinds=KINDS, **parameters)
        ids = confirmed(found, jumps)
        unmodified[detector] = [(finding.kind, finding.id in ids) for finding in found]
    cells = [(d, a, s) for d in detectors for a in amplitudes for s in shares]
    tasks = [
        _Task(take, detector, amplitude, share, _seed(seed, simulation), parameters)
        for detector, amplitude, share in cells
        for simulation in range(simulations)
    ]
    results = in_order(_simulate, tasks, jobs, lambda done: progress(done, len(tasks)))
    measured = []
    for detector, amplitude, share in cells:
        some = [next(results) for _ in range(simulations)]
        measured.append(_cell(take, detector, amplitude, share, some, unmodified[detector]))
    n_markers = len(take.measured)
    return Classification(
        take.n_frames, n_markers, take.rate, seed, tuple(measured), dict(parameters)
    )


def _seed(seed: int, simulation: int) -> int:
    return int(np.random.SeedSequence((seed, simulation)).generate_state(1)[0])


def _simulate(task: _Task) -> tuple[NDArray[np.int64], Mapping[str, Matches]]:
    dirty, truths = contaminate(
        task.take, amplitude_mm=task.amplitude_mm, share=task.share, seed=task.seed
    )
    found = detect(dirty, task.detector, kinds=KINDS, **task.parameters)
    return confusion(dirty, truths, found), match(truths, found)


def _cell(
    take: Take,
    detector: str,
    amplitude: float,
    share: float,
    results: Sequence[tuple[NDArray[np.int64], Mapping[str, Matches]]],
    unmodified: Sequence[tuple[str, bool]],
) -> Cell:
    matrix = np.mean([counts for counts, _ in results], axis=0)
    minutes = take.duration_s / 60.0
    spans = {
        kind: SpanFigures(
            true=sum(matches[kind].true for _, matches in results),
            found=sum(matches[kind].found for _, matches in results),
            called=sum(matches[kind].called for _, matches in results),
            false_per_minute=sum(m[kind].false for _, m in results) / len(results) / minutes,
            unmodified_per_minute=sum(k == kind for k, _ in unmodified) / minutes,
            confirmed_per_minute=unmodified.count((kind, True)) / minutes,
        )
        for kind in KINDS
    }
    return Cell(
        detector=detector,
        amplitude_mm=float(amplitude),
        share=float(share),
        simulations=len(results),
        matrix=matrix,
        classes={name: rates(matrix, i) for i, name in enumerate(CLASSES)},
        f=overall_f(matrix),
        mcc=overall_mcc(matrix),
        spans=spans,
        errors={
            name: standard_errors([counts for counts, _ in results], i)
            for i, name in enumerate(CLASSES)
        },
    )
