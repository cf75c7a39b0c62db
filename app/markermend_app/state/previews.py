"""The repairs offered for one finding, row by row as they are computed."""

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from markermend.errors import CannotRepair
from markermend.model import Kind, Span, Take
from markermend.repairing import DEFAULTS, REPAIRS, Repair, repair
from markermend.review import Judgement


@dataclass(frozen=True, eq=False)
class Preview:
    """One row of the table of repairs: pending, ready or refused.

    Attributes
    ----------
    name, title
        Of the method.
    repair
        The values, once they are there.
    reason
        Why the method does not apply here, or empty.
    seconds
        How long it took.
    change_mm
        Largest distance between the repaired and the recorded marker in the span, in mm; None
        where nothing was recorded.
    """

    name: str
    title: str
    repair: Repair | None = None
    reason: str = ""
    seconds: float = 0.0
    change_mm: float | None = None

    @property
    def summary(self) -> str:
        """What the method does, in one line."""
        return REPAIRS.get(self.name).summary

    @property
    def pending(self) -> bool:
        """Whether it is still to be computed."""
        return self.repair is None and not self.reason


def compute(
    take: Take, judged: Judgement, masked: Sequence[tuple[str, Span]]
) -> Iterator[tuple[Preview, ...]]:
    """Yield all rows again and again, one more of them computed each time.

    The defaults of the kind come first; ``leave`` stands last and is there at once.
    """
    first = DEFAULTS[judged.kind]
    rest = [name for name in REPAIRS.names() if name not in (*first, "leave")]
    rows = [Preview(name, REPAIRS.get(name).title) for name in (*first, *rest, "leave")]
    for at in (len(rows) - 1, *range(len(rows) - 1)):
        row = rows[at]
        began = time.perf_counter()
        try:
            done = repair(
                take,
                judged.finding.marker,
                judged.span,
                row.name,
                kind=judged.kind,
                partner=judged.finding.partner,
                masked=masked,
            )
            rows[at] = replace(
                row,
                repair=done,
                seconds=time.perf_counter() - began,
                change_mm=done.largest_change(take),
            )
        except CannotRepair as refusal:
            rows[at] = replace(row, reason=str(refusal))
        yield tuple(rows)


def recommended(rows: Sequence[Preview], kind: Kind) -> str:
    """Give the first of the kind's defaults that applies; where none does, leave the gap.

    Empty as long as that is not known.
    """
    state = {row.name: row for row in rows}
    for name in (*DEFAULTS[kind], "leave"):
        row = state.get(name)
        if row is None or row.pending:
            return ""
        if row.repair is not None:
            return name
    return ""
