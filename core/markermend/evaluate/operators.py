"""Experiment E2: what a detector still finds after operators of different skill have worked."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from markermend.detection import DETECTORS, detect
from markermend.detection.run import DEFAULT
from markermend.errors import BadInput
from markermend.evaluate.contamination import MEAN_LENGTH, contaminate
from markermend.evaluate.parallel import in_order
from markermend.evaluate.scores import CLASSES
from markermend.model import BoolArray, Finding, Span, Take, runs
from markermend.repairing.run import REPAIRS, Wish, apply, repair_all
from markermend.truth import Truth

KINDS = CLASSES[1:]
# Remaining deviations closer to each other than this many frames at 100 Hz are one error.
APART = 10


@dataclass(frozen=True)
class Operator:
    """A simulated operator of known skill.

    Attributes
    ----------
    name
        What the row is called.
    notices
        Probability of noticing an artefact.
    false_edits
        Stretches per minute that are repaired though nothing is wrong with them.
    method
        The repair used for everything; a poor choice makes new errors, as in the paper's beginners.
        Empty for one who brings back what was there before the artefact.
    """

    name: str
    notices: float
    false_edits: float
    method: str


OPERATORS = (
    Operator("expert", 0.98, 0.0, ""),
    Operator("intermediate", 0.9, 0.5, ""),
    Operator("beginner 1", 0.5, 4.0, "linear"),
    Operator("beginner 2", 0.5, 6.0, "linear"),
)


@dataclass(frozen=True)
class Verdicts:
    """What an expert says of the findings: how many are right, wrong and lacking."""

    approved: int
    rejected: int
    missed: int


def judge(
    version: Take, reference: Take, findings: Sequence[Finding], tolerance_mm: float = 3.0
) -> Verdicts:
    """Hold findings against a reference, in the place of an expert.

    Parameters
    ----------
    version
        The take that was searched.
    reference
        The same take as it should be.
    findings
        What was found in `version`; gaps are left out.
    tolerance_mm
        A marker farther than this from its reference is in error.  A finding is approved if it
        covers an error, an error is missed if no finding covers any of it.

    Raises
    ------
    BadInput
        If the two takes do not have the same frames and markers.
    """
    if version.positions.shape != reference.positions.shape or version.labels != reference.labels:
        raise BadInput("The version has other frames or markers than the reference; give a pair.")
    with np.errstate(invalid="ignore"):
        away = np.linalg.norm(version.positions - reference.positions, axis=2) > tolerance_mm
    covered = np.zeros_like(away)
    approved = rejected = 0
    for finding in findings:
        if finding.kind == "gap":
            continue
        marker = version.index(finding.marker)
        covered[finding.span.frames, marker] = True
        if away[finding.span.frames, marker].any():
            approved += 1
        else:
            rejected += 1
    apart = max(1, round(APART * version.rate / 100.0))
    missed = sum(
        not covered[error.frames, marker].any()
        for marker in version.measured
        for error in _errors(away[:, marker], apart)
    )
    return Verdicts(approved, rejected, missed)


def _errors(away: BoolArray, apart: int) -> list[Span]:
    """Give the stretches in error, joined where they lie close to each other."""
    joined: list[Span] = []
    for run in runs(away):
        if joined and run.start - joined[-1].stop < apart:
            joined[-1] = Span(joined[-1].start, run.stop)
        else:
            joined.append(run)
    return joined


@dataclass(frozen=True)
class Row:
    """One row of Table 2, averaged over the simulations.

    Attributes
    ----------
    operator
        Whose version was searched; ``"none"`` for the take as recorded.
    human, algorithm
        Errors that the operator, and the detector afterwards, pointed out.
    approved, rejected, missed
        The expert's verdicts on the detector.
    """

    operator: str
    human: float
    algorithm: float
    approved: float
    rejected: float
    missed: float


@dataclass(frozen=True)
class Comparison:
    """Table 2, for simulated operators."""

    detector: str
    simulations: int
    seed: int
    rows: tuple[Row, ...]

    def to_json(self) -> dict[str, Any]:
        """Give it in the form of ``markermend evaluate e2 --json``."""
        return {
            "version": 1,
            "experiment": "e2",
            "detector": self.detector,
            "simulations": self.simulations,
            "seed": self.seed,
            "rows": [asdict(row) for row in self.rows],
        }

    def table(self) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
        """Give the columns and rows of a table for the terminal."""
        columns = ("operator", "human", "algorithm", "approved", "rejected", "missed")
        return columns, [
            (row.operator, *(f"{value:.1f}" for value in list(asdict(row).values())[1:]))
            for row in self.rows
        ]


@dataclass(frozen=True)
class _Task:
    take: Take
    operators: tuple[Operator, ...]
    detector: str
    amplitude_mm: float
    share: float
    tolerance_mm: float
    seed: int
    parameters: dict[str, Any]


def e2(
    take: Take,
    *,
    operators: Sequence[Operator] = OPERATORS,
    detector: str = DEFAULT,
    amplitude_mm: float = 10.0,
    share: float = 0.02,
    tolerance_mm: float = 3.0,
    simulations: int = 1,
    jobs: int = 1,
    seed: int = 0,
    progress: Callable[[int, int], None] = lambda done, total: None,
    **parameters: Any,
) -> Comparison:
    """Let simulated operators clean a contaminated take, and search what they leave.

    Parameters
    ----------
    take
        A take without artefacts: the reference of the expert.
    operators
        Who works on it.
    detector
        Name of a registered detector.
    amplitude_mm, share
        Of the contamination.
    tolerance_mm
        What the expert lets pass.
    simulations, jobs, seed, progress
        As in `e1`.
    **parameters
        Of the detector.

    Raises
    ------
    UnknownName, BadParameter, BadInput
        If a detector, a repair, a parameter or a number is not usable.

    Notes
    -----
    Skurowski & Pawlyta, section 4.2.2 and Table 2, with operators that are simulated: an operator
    notices each artefact with a known probability, repairs it by one method, and repairs some
    stretches that were right.  `judge` does the same for versions made by people.
    """
    if simulations < 1:
        raise BadInput(f"simulations must be at least 1; got {simulations}.")
    DETECTORS.get(detector)
    for operator in operators:
        if operator.method:
            REPAIRS.get(operator.method)
    tasks = [
        _Task(
            take,
            tuple(operators),
            detector,
            amplitude_mm,
            share,
            tolerance_mm,
            int(np.random.SeedSequence((seed, simulation)).generate_state(1)[0]),
            parameters,
        )
        for simulation in range(simulations)
    ]
    results = list(in_order(_simulate, tasks, jobs, lambda done: progress(done, len(tasks))))
    names = ("none", *(operator.name for operator in operators))
    means = np.mean(results, axis=0)
    rows = tuple(Row(name, *map(float, mean)) for name, mean in zip(names, means, strict=True))
    return Comparison(detector, simulations, seed, rows)


def _simulate(task: _Task) -> list[tuple[int, int, int, int, int]]:
    raw, truths = contaminate(
        task.take, amplitude_mm=task.amplitude_mm, share=task.share, seed=task.seed
    )
    rows = []
    for place, operator in enumerate((None, *task.operators)):
        rng = np.random.default_rng((task.seed, place))
        edits = [] if operator is None else _edits(operator, raw, truths, rng)
        version = _edited(raw, task.take, edits)
        found = detect(version, task.detector, kinds=KINDS, **task.parameters)
        verdicts = judge(version, task.take, found, task.tolerance_mm)
        human = len(truths) if operator is None else len(edits)
        rows.append((human, len(found), verdicts.approved, verdicts.rejected, verdicts.missed))
    return rows


def _edited(raw: Take, reference: Take, edits: Sequence[Wish]) -> Take:
    version = apply(raw, repair_all(raw, [edit for edit in edits if edit.method])[0])
    restored = [edit for edit in edits if not edit.method]
    if not restored:
        return version
    positions = version.positions.copy()
    for edit in restored:
        marker = raw.index(edit.marker)
        positions[edit.span.frames, marker] = reference.positions[edit.span.frames, marker]
    return version.with_positions(positions)


def _edits(
    operator: Operator, raw: Take, truths: Sequence[Truth], rng: np.random.Generator
) -> list[Wish]:
    """Draw what an operator repairs, right or wrong; no two stretches of a marker overlap."""
    n_false = int(rng.poisson(operator.false_edits * raw.duration_s / 60.0))
    stretches = [
        (truth.marker, truth.span.padded(1, raw.n_frames))
        for truth in truths
        if rng.random() < operator.notices
    ]
    for _ in range(n_false):
        length = min(raw.n_frames, max(2, int(rng.poisson(MEAN_LENGTH * raw.rate / 100.0))))
        start = int(rng.integers(0, raw.n_frames - length + 1))
        marker = raw.labels[int(rng.choice(raw.measured))]
        stretches.append((marker, Span(start, start + length)))
    kept: list[tuple[str, Span]] = []
    for marker, span in stretches:
        seen = raw.seen[span.frames, raw.index(marker)].all()
        if seen and not any(marker == other and span.overlaps(taken) for other, taken in kept):
            kept.append((marker, span))
    return [Wish(marker, span, method=operator.method) for marker, span in kept]
