"""What a trainee gets back: a mark for every artefact and decision, and what they add up to."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, Literal

from markermend.model import KINDS, Kind, Span

Outcome = Literal["right", "misclassified", "missed", "invented", "partial", "dismissed"]

ROWS: tuple[str, ...] = (*KINDS, "nothing")
"""Rows of the confusion matrix: what it was."""
COLUMNS: tuple[str, ...] = (*KINDS, "missed")
"""Columns of the confusion matrix: what it was called."""


@dataclass(frozen=True)
class Repaired:
    """What a repair is worth, in mm to what the marker really did.

    Attributes
    ----------
    method
        The repair that was used, after defaults.
    error_mm
        Mean distance over all frames that are wrong or were repaired; None where the data was
        given up or nobody knows the truth.
    best, best_mm
        The method with the lowest error on the true span, with all that is wrong masked, among
        those compared, and that error;
        empty and None where none was compared.
    recommended, recommended_mm
        The method that a comparison without the truth recommends, and its error.
    new_artefacts
        What the detector finds after this repair and does not find in the true movement; None
        where it was not looked for.
    """

    method: str
    error_mm: float | None
    best: str = ""
    best_mm: float | None = None
    recommended: str = ""
    recommended_mm: float | None = None
    new_artefacts: tuple[Kind, ...] | None = None


@dataclass(frozen=True)
class Mark:
    """One artefact, or one decision that concerns none.

    Attributes
    ----------
    outcome
        ``"right"``: found and named. ``"misclassified"``: found, another kind. ``"missed"``.
        ``"invented"``: nothing was wrong. ``"partial"``: a decision on an artefact that covers too
        little of it or comes second; it counts neither for nor against. ``"dismissed"``: a false
        alarm called one.
    marker, span, kind
        The artefact; for a decision that concerns none, what was said.
    called, called_span
        What was said of an artefact, or None.
    finding
        Id of the finding that was decided on, or empty.
    iou
        How well the edges agree, 0 to 1, or None.
    repaired
        What the repair is worth, or None where nothing was repaired.
    why
        One sentence or two.
    """

    outcome: Outcome
    marker: str
    span: Span
    kind: Kind
    called: Kind | None = None
    called_span: Span | None = None
    finding: str = ""
    iou: float | None = None
    repaired: Repaired | None = None
    why: str = ""

    def to_json(self) -> dict[str, Any]:
        """Give it as a record of plain values."""
        said = self.called_span
        return {
            "outcome": self.outcome,
            "marker": self.marker,
            "start": self.span.start,
            "stop": self.span.stop,
            "kind": self.kind,
            "called": self.called,
            "called_span": None if said is None else [said.start, said.stop],
            "finding": self.finding,
            "iou": self.iou,
            "repaired": None if self.repaired is None else asdict(self.repaired),
            "why": self.why,
        }


@dataclass(frozen=True)
class KindScore:
    """How a trainee does with one kind.

    Attributes
    ----------
    true, found, right
        Artefacts of the kind, those of them that were found, and found and named.
    called, wrong
        Accepted findings that were called this, and those of them that were another kind or
        nothing.
    mcc
        Matthews correlation coefficient over samples (Skurowski & Pawlyta, Eq. 37), or None where
        it would be 0 / 0, and for gaps, whose samples are no decision.
    iou
        Mean agreement of the edges of those found, or None.
    error_mm, best_mm, recommended_mm
        Mean error of the repairs, and of the best and the recommended method on those for which
        all three are known, or None.
    """

    true: int
    found: int
    right: int
    called: int
    wrong: int
    mcc: float | None
    iou: float | None
    error_mm: float | None
    best_mm: float | None
    recommended_mm: float | None

    @property
    def sensitivity(self) -> float | None:
        """Share of the artefacts that were found and named."""
        return self.right / self.true if self.true else None

    @property
    def false_discovery(self) -> float | None:
        """Share of what was called this that was not."""
        return self.wrong / self.called if self.called else None

    def to_json(self) -> dict[str, Any]:
        """Give it as a record."""
        return {
            **asdict(self),
            "sensitivity": self.sensitivity,
            "false_discovery": self.false_discovery,
        }


@dataclass(frozen=True)
class Grade:
    """The whole result of one exercise.

    Attributes
    ----------
    level, hidden
        Which exercise.
    marks
        Ordered by time.
    kinds
        Scores of the kinds that were in the take or that were named.
    matrix
        `ROWS` by `COLUMNS`: number of artefacts and inventions; the last cell, nothing and missed,
        counts false alarms that were called so.
    rmse_before_mm, rmse_after_mm
        Root mean square distance to the truth over the samples that are wrong or were changed, as
        handed out and as given back; None where nothing of it is known. Gaps have no error
        before, so they are left out here; a sample that was deleted counts as it was.
    refused
        Why repairs were not possible.
    seconds_per_finding
        Median time between two decisions, without pauses, or None where it is not known.
    verdict
        One sentence about the whole.
    """

    level: int
    hidden: bool
    marks: tuple[Mark, ...]
    kinds: Mapping[Kind, KindScore]
    matrix: tuple[tuple[int, ...], ...]
    rmse_before_mm: float | None
    rmse_after_mm: float | None
    refused: tuple[str, ...]
    seconds_per_finding: float | None
    verdict: str

    def count(self, outcome: Outcome) -> int:
        """Count the marks of one outcome."""
        return sum(mark.outcome == outcome for mark in self.marks)

    @property
    def worse(self) -> bool:
        """Whether the take was left worse than it was."""
        return is_worse(self.rmse_before_mm, self.rmse_after_mm)

    def to_json(self) -> dict[str, Any]:
        """Give it in the form of ``markermend train --grade --json``."""
        return {
            "version": 1,
            "level": self.level,
            "hidden": self.hidden,
            "verdict": self.verdict,
            "rmse_before_mm": self.rmse_before_mm,
            "rmse_after_mm": self.rmse_after_mm,
            "worse": self.worse,
            "seconds_per_finding": self.seconds_per_finding,
            "kinds": {kind: score.to_json() for kind, score in self.kinds.items()},
            "rows": list(ROWS),
            "columns": list(COLUMNS),
            "matrix": [list(row) for row in self.matrix],
            "marks": [mark.to_json() for mark in self.marks],
            "refused": list(self.refused),
        }


def is_worse(before: float | None, after: float | None) -> bool:
    """Say whether an error has grown, by more than rounding."""
    return before is not None and after is not None and after > before + 1e-6
