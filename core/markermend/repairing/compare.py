"""Compare methods on one span: values, bands, expected errors, checks, and which to take."""

import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from markermend.errors import CannotRepair
from markermend.model import Kind, Span, Take
from markermend.registry import Method
from markermend.repairing.checks import Checks, Inspector
from markermend.repairing.problem import Problem, Repair
from markermend.repairing.run import REPAIRS, Wish, accept, moved, nearby, pose, solve
from markermend.repairing.trust import REFERENCE, SLOW, Bench, Trust

EXACT = "swap"
"""The method that, where it applies, gives back what was recorded."""
HOPELESS = 2.0
"""Methods that expect so many times the error of AUTO are not shown to the detector."""


@dataclass(frozen=True, eq=False)
class Row:
    """One method on the span.

    Attributes
    ----------
    method, title
        Its name and what the operator reads.
    repair
        What it would write, in frames of the take, or None where it refuses.
    trust
        Its errors on pseudo-gaps, or None where nothing could be hidden for it.
    checks
        How the repair fits what is around it, or None.
    seconds
        Time that the repair took.
    refusal
        Why it does not apply, or empty.
    """

    method: str
    title: str
    repair: Repair | None
    trust: Trust | None
    checks: Checks | None
    seconds: float
    refusal: str = ""

    @property
    def expected_mm(self) -> float:
        """Mean error to be expected; infinite where nothing is known of it."""
        return np.inf if self.trust is None else self.trust.expected_mm

    @property
    def brings_nothing_new(self) -> bool:
        """Whether the detector was run and finds nothing in what it would write."""
        return self.checks is not None and self.checks.detected and not self.checks.artefacts


@dataclass(frozen=True, eq=False)
class Comparison:
    """All methods on one span.

    Attributes
    ----------
    marker, span, kind
        What was repaired.
    rows
        The lowest expected error first, then those of unknown error, then those that refuse.
    recommended
        Name of the method to take.
    why
        One sentence for the operator.
    """

    marker: str
    span: Span
    kind: Kind
    rows: tuple[Row, ...]
    recommended: str
    why: str

    def row(self, method: str) -> Row:
        """Give the row of one method; KeyError where it was not compared."""
        return {row.method: row for row in self.rows}[method]


def compare(
    take: Take,
    marker: str,
    span: Span | tuple[int, int],
    methods: Iterable[str] | None = None,
    *,
    kind: Kind = "gap",
    partner: str | None = None,
    masked: Iterable[tuple[str, Span]] = (),
    training: Sequence[Take] = (),
) -> Comparison:
    """Try methods on one span and say which to take.

    Parameters
    ----------
    take, marker, span, kind, partner, masked, training
        As in `markermend.repairing.repair`.
    methods
        Names; by default all registered ones.

    Raises
    ------
    UnknownName, BadInput
        If marker, span or a method cannot be used.
    """
    span = span if isinstance(span, Span) else Span(*span)
    rows = compare_iter(
        take, marker, span, methods, kind=kind, partner=partner, masked=masked, training=training
    )
    return concluded(marker, span, kind, rows, partner)


def compare_iter(
    take: Take,
    marker: str,
    span: Span | tuple[int, int],
    methods: Iterable[str] | None = None,
    *,
    kind: Kind = "gap",
    partner: str | None = None,
    masked: Iterable[tuple[str, Span]] = (),
    training: Sequence[Take] = (),
) -> Iterator[Row]:
    """Give the rows of `compare` one by one: the quick methods first, else in the order given."""
    span = span if isinstance(span, Span) else Span(*span)
    names = REPAIRS.names() if methods is None else tuple(methods)
    chosen = [REPAIRS.get(name) for name in sorted(names, key=lambda name: name in SLOW)]
    near, first, hidden = nearby(take, span, masked)
    wish = Wish(marker, moved(span, -first), kind, partner)
    return _rows(pose(near, wish, hidden, training), chosen, span)


def _rows(problem: Problem, methods: Sequence[Method], span: Span) -> Iterator[Row]:
    bench = Bench(problem)
    inspector = Inspector(bench.problem, span.start - bench.problem.span.start)
    known = bench.reference
    worth = np.inf if known is None else HOPELESS * known.expected_mm
    for method in methods:
        began = time.perf_counter()
        try:
            done = _solved(bench, method)
        except CannotRepair as refusal:
            yield Row(method.name, method.title, None, None, None, 0.0, str(refusal))
            continue
        seconds = time.perf_counter() - began
        trust = bench.trust(method, {})
        checks = None
        if method.name != "leave":
            checks = inspector.check(done.values, trust is None or trust.expected_mm <= worth)
        if trust is not None:
            done = replace(done, band=trust.band, expected_mm=trust.expected_mm)
        done = replace(done, span=span)
        yield Row(method.name, method.title, done, trust, checks, seconds)


def _solved(bench: Bench, method: Method) -> Repair:
    if method.name == REFERENCE:
        return accept(bench.problem, method, bench.reference_outcome(), {})
    return solve(bench.problem, method, {})


def concluded(
    marker: str, span: Span, kind: Kind, rows: Iterable[Row], partner: str | None = None
) -> Comparison:
    """Sort the rows, and recommend the lowest expected error that brings nothing new.

    Where labels were exchanged with a partner, and changing them back makes both go on more
    smoothly, that is exact and nothing else is recommended. Where no error could be measured, the
    method for unknown errors that brings nothing new is taken, and where all bring something new,
    the lowest expected error.
    """
    ordered = sorted(rows, key=lambda r: (r.repair is None, r.expected_mm, r.method != REFERENCE))
    exact = next((row.repair for row in ordered if row.method == EXACT and row.repair), None)
    if partner and exact is not None:
        why = f"Labels were exchanged, and changing them back is exact. {exact.note}"
        return Comparison(marker, span, kind, tuple(ordered), EXACT, why)
    fills = [row for row in ordered if row.repair is not None and row.method != "leave"]
    clean = [row for row in fills if row.brings_nothing_new]
    looked = any(row.checks is not None and row.checks.detected for row in fills)
    best = next(iter(clean or fills), None)
    if best is None:
        name, why = "leave", "No method applies here; leave the gap."
    else:
        name, why = best.method, _why(best, fills, bool(clean), looked)
    return Comparison(marker, span, kind, tuple(ordered), name, why)


def _why(best: Row, fills: Sequence[Row], clean: bool, looked: bool) -> str:
    if best.trust is None:
        return f"{best.title}: no stretch of this length could be hidden to measure errors by."
    text = (
        f"{best.title}: {best.trust.expected_mm:.1f} mm expected from "
        f"{best.trust.n_pseudo_gaps} pseudo-gaps on this marker"
    )
    if not looked:
        return f"{text}, the lowest of {len(fills)} methods; the detector was not asked."
    if not clean:
        return f"{text}, but every repair leaves something that the detector finds."
    lower = [row for row in fills if row.expected_mm < best.expected_mm]
    if lower:
        return f"{text}; {lower[0].title} expects less but brings a new artefact."
    return f"{text}, the lowest of {len(fills)} methods, and nothing new for the detector."
