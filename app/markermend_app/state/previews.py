"""The repairs offered for one finding, row by row as they are computed."""

import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

from markermend.errors import CannotRepair
from markermend.model import Kind, Span, Take
from markermend.repairing import DEFAULTS, REPAIRS, Repair
from markermend.repairing.checks import Checks
from markermend.repairing.compare import Row, concluded
from markermend.repairing.problem import Problem
from markermend.repairing.run import moved, nearby, pose, solve
from markermend.repairing.trust import SLOW, Trust
from markermend.review import Judgement
from markermend_app.state.turns import TURNS

AT_HAND = ("unstep", "rigid", "butterworth", "pchip", "linear", "leave")
"""Methods that take a few milliseconds; what they give is shown before anything is compared."""
SOONEST = (
    "swap", "auto", "linear", "pchip", "spline", "savgol", "butterworth", "join", "pattern",
    "unstep", "rigid", "lgrnn", "wpca", "lpr", "rlk", "glr", "kinematic", "pma",
)  # fmt: skip
"""The order of comparing: what the others are measured by, then by the time they take."""


@dataclass(frozen=True, eq=False)
class Preview:
    """One row of the table of repairs: pending, ready, refused, or only tried on request.

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
    trust, checks
        Its errors on pseudo-gaps and how it fits, once they are known.
    compared
        Whether nothing more will become known of it.
    slow
        Whether it takes so long that it is computed on request only.
    """

    name: str
    title: str
    repair: Repair | None = None
    reason: str = ""
    seconds: float = 0.0
    trust: Trust | None = None
    checks: Checks | None = None
    compared: bool = False
    slow: bool = False

    @property
    def summary(self) -> str:
        """What the method does, in one line."""
        return REPAIRS.get(self.name).summary

    @property
    def pending(self) -> bool:
        """Whether it is still to be computed."""
        return self.repair is None and not self.reason

    @property
    def row(self) -> Row:
        """The same as a row of a comparison."""
        return Row(
            self.name, self.title, self.repair, self.trust, self.checks, self.seconds, self.reason
        )


@dataclass(frozen=True, eq=False)
class Offer:
    """All rows for one finding as far as they are known, and the one that is recommended.

    ``best`` is empty until something can be said; ``complete`` tells that all quick ones are done.
    """

    rows: tuple[Preview, ...]
    best: str = ""
    why: str = ""
    complete: bool = False


def at_hand(
    take: Take, judged: Judgement, masked: Sequence[tuple[str, Span]], names: Sequence[str]
) -> tuple[Preview, ...]:
    """Give the rows of these methods, those computed that cost nothing: the first preview."""
    wanted = (*(["swap"] if judged.finding.partner else []), *AT_HAND)
    wish = judged.wish
    near, first, hidden = nearby(take, wish.span, [(wish.marker, wish.span), *masked])
    with TURNS:
        problem = pose(near, replace(wish, span=moved(wish.span, -first)), hidden)
    rows = []
    for name in sorted(names, key=lambda name: wanted.index(name) if name in wanted else 99):
        row = Preview(name, REPAIRS.get(name).title, slow=name in SLOW)
        rows.append(_computed(row, problem, wish.span) if name in wanted else row)
    return tuple(rows)


def _computed(row: Preview, problem: Problem, span: Span) -> Preview:
    with TURNS:
        began = time.perf_counter()
        try:
            done = solve(problem, REPAIRS.get(row.name), {})
        except CannotRepair as refusal:
            return replace(row, reason=str(refusal), compared=True)
        # Not a view of an array that would be kept with it.
        done = replace(done, span=span, values=done.values.copy())
        return replace(row, repair=done, seconds=time.perf_counter() - began)


def compared(
    computed: Iterable[Row], judged: Judgement, rows: Sequence[Preview], n_methods: int
) -> Iterator[Offer]:
    """Take in what was tried on pseudo-gaps; give all rows again after each method."""
    known = {row.name: row for row in rows}
    for done, row in enumerate(computed, 1):
        known[row.method] = replace(
            known[row.method],
            repair=row.repair,
            reason=row.refusal,
            seconds=row.seconds,
            trust=row.trust,
            checks=row.checks,
            compared=True,
        )
        yield recommended(tuple(known.values()), judged, complete=done == n_methods)


def quick(rows: Iterable[Preview]) -> tuple[str, ...]:
    """Name the methods that are compared without being asked, in the order of doing it."""
    names = [row.name for row in rows if not row.slow]
    return tuple(
        sorted(names, key=lambda name: SOONEST.index(name) if name in SOONEST else len(SOONEST))
    )


def recommended(rows: Sequence[Preview], judged: Judgement, *, complete: bool) -> Offer:
    """Say which row to take: by measured errors where there are any, else the kind's default."""
    tried = [row.row for row in rows if row.compared]
    kind = judged.kind
    if complete or any(row.trust is not None for row in tried):
        finding = judged.finding
        found = concluded(finding.marker, judged.span, kind, tried, finding.partner)
        return Offer(in_order(rows), found.recommended, found.why, complete)
    return Offer(in_order(rows), _default(rows, kind), "", complete)


def _default(rows: Sequence[Preview], kind: Kind) -> str:
    """Give the first of the kind's defaults that is there; where none is, leave the gap.

    Labels that were exchanged are exchanged back, whatever else there is.
    """
    state = {row.name: row for row in rows}
    for name in ("swap", *DEFAULTS[kind], "leave"):
        row = state.get(name)
        if row is not None and row.repair is not None:
            return name
    return ""


def in_order(rows: Iterable[Preview]) -> tuple[Preview, ...]:
    """Sort: lowest expected error first, then what is being computed, ``leave`` after all fills."""
    return tuple(
        sorted(
            rows,
            key=lambda r: (
                bool(r.reason),
                r.name == "leave",
                r.slow and r.pending,
                r.row.expected_mm,
                not r.compared and r.pending,
            ),
        )
    )
