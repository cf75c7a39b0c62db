"""Table 2 of Skurowski & Pawlyta (experiment E2), from the reviews of people."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from markermend.detection import detect
from markermend.evaluate.operators import judge
from markermend.evaluate.scores import CLASSES
from markermend.model import Take
from markermend.review import Review

KINDS = CLASSES[1:]


@dataclass(frozen=True)
class TableRow:
    """One row of the table; gaps are left out.

    Attributes
    ----------
    operator
        Whose version; ``"none"`` for the take as recorded.
    human
        Errors that the person pointed out.
    algorithm
        Errors that the detector pointed out.
    approved, rejected, missed
        What was said of the detector's: right, wrong, and what it does not have.
    """

    operator: str
    human: int
    algorithm: int
    approved: int
    rejected: int
    missed: int

    def to_json(self) -> dict[str, Any]:
        """Give it as a record."""
        return asdict(self)


def own_row(name: str, review: Review) -> TableRow:
    """Count a person's own verdicts on what the detector showed on the take as recorded.

    What was not judged does not count; ``missed`` is what the person added and accepted.
    """
    judged = [j for j in review if j.kind in KINDS and not j.replaced_by and j.decision.settled]
    shown = [j for j in judged if not j.added]
    approved = sum(j.decision.verdict == "accepted" for j in shown)
    added = sum(j.decision.verdict == "accepted" for j in judged if j.added)
    return TableRow(name, approved + added, len(shown), approved, len(shown) - approved, added)


def table2(
    take: Take,
    versions: Mapping[str, Take],
    reviews: Mapping[str, Review],
    expert: str,
    *,
    detector: str = "published",
    tolerance_mm: float = 3.0,
) -> tuple[TableRow, ...]:
    """Search what every operator leaves, and hold that against the expert's version.

    Parameters
    ----------
    take, versions, reviews
        The take as recorded; by operator the repaired take and the review.
    expert
        The operator whose version is the reference.
    detector
        Name of a registered detector.
    tolerance_mm
        As in `markermend.evaluate.operators.judge`.

    Returns
    -------
    The take as recorded first (its human count is the expert's), then the operators.
    """
    reference = versions[expert]
    rows = []
    everybody: Sequence[tuple[str, str, Take]] = [
        ("none", expert, take),
        *((name, name, version) for name, version in versions.items()),
    ]
    for name, counted, version in everybody:
        found = detect(version, detector, kinds=KINDS)
        verdicts = judge(version, reference, found, tolerance_mm)
        human = own_row(counted, reviews[counted]).human
        rows.append(
            TableRow(name, human, len(found), verdicts.approved, verdicts.rejected, verdicts.missed)
        )
    return tuple(rows)
