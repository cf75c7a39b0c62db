"""What an export would change, and what it did."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from markermend.io.disk import write_whole
from markermend.model import Finding, Kind, Span
from markermend.repairing import REPAIRS, Refusal, Repair
from markermend.review import Counts, Review
from markermend.review.mending import Mended, mend, save
from markermend.review.report import report as report_on
from markermend.review.session import ReviewSession
from markermend_app.state.workspace import Opened


@dataclass(frozen=True)
class Change:
    """One repaired span, for the table of the export."""

    marker: str
    kind: Kind
    start_s: float
    stop_s: float
    n_frames: int
    method: str
    largest_mm: float | None
    expected_mm: float | None
    left: bool


@dataclass(frozen=True, eq=False)
class Plan:
    """An export that is prepared, or done.

    Attributes
    ----------
    name, target
        Of the source, and the file to be written.
    promise
        How the file will be written, in a sentence.
    counts
        Verdicts.
    changes, refusals
        What changes, and what cannot be repaired.
    n_changed, n_samples
        Positions that change, of all that there are.
    mended, review, findings
        What will be written, and all that there was to decide on.
    verified
        What the verification found, in sentences, once it is written.
    """

    name: str
    target: Path
    promise: str
    counts: Counts
    changes: tuple[Change, ...]
    refusals: tuple[Refusal, ...]
    n_changed: int
    n_samples: int
    mended: Mended
    review: Review
    findings: tuple[Finding, ...]
    verified: tuple[str, ...] = ()


def plan(
    opened: Opened,
    review: Review,
    findings: Sequence[Finding],
    expected: Mapping[tuple[str, Span, str], float | None],
    progress: Callable[[int], None] = lambda _: None,
) -> Plan:
    """Compute all accepted repairs and count what they change.

    Parameters
    ----------
    opened, review, findings
        The take, the decisions, and what there is to look at.
    expected
        Expected errors that are known from the desk: (marker, span, method) -> mm.
    progress
        Called with the number of repairs computed.

    Raises
    ------
    BadInput
        If two accepted findings would write the same samples.
    """
    take = opened.take
    known = {key: error for key, error in expected.items() if error is not None}
    mended = mend(take, review.accepted(), progress=progress)
    before, after = take.positions, mended.repaired.positions
    same = (before == after) | (np.isnan(before) & np.isnan(after))
    source = take.source.path if take.source else Path("take.npz")
    kinds = {(wish.marker, wish.span): wish.kind for wish in review.accepted()}
    return Plan(
        name=opened.name,
        target=source.with_name(f"{source.stem}_mended{source.suffix}"),
        promise="Everything else stays bit for bit.",
        counts=review.counts(findings),
        changes=tuple(
            _change(
                opened,
                done,
                kinds[done.marker, done.span],
                known.get((done.marker, done.span, done.method), done.expected_mm),
            )
            for done in mended.repairs
        ),
        refusals=mended.refusals,
        n_changed=int((~same.all(axis=2)).sum()),
        n_samples=take.n_frames * take.n_markers,
        mended=mended,
        review=review,
        findings=tuple(findings),
    )


def _change(opened: Opened, done: Repair, kind: Kind, expected_mm: float | None) -> Change:
    take = opened.take
    return Change(
        marker=done.marker,
        kind=kind,
        start_s=done.span.start / take.rate,
        stop_s=done.span.stop / take.rate,
        n_frames=len(done.span),
        method=REPAIRS.get(done.method).title,
        largest_mm=done.largest_change(take),
        expected_mm=expected_mm,
        left=done.method == "leave",
    )


def write(
    opened: Opened,
    planned: Plan,
    session: ReviewSession,
    target: Path,
    *,
    overwrite: bool,
    report: bool = False,
) -> Plan:
    """Write the file, its decisions and a report, and say what the verification found.

    Raises
    ------
    CannotWrite
        If the export would not be faithful, or the disk refuses.
    """
    take = opened.take
    written, beside = save(
        planned.mended, planned.review, target, decided=session.decided, overwrite=overwrite
    )
    how = {
        "patched": "The source was copied and only the repaired samples were overwritten.",
        "copied": "Nothing was to be changed: the file is a copy of the source.",
        "rewritten": f"The file was written anew: {written.why}",
    }[written.mode]
    verified = [
        how,
        (
            f"{written.n_changed:,} samples differ from {planned.name}, all of them in the "
            f"{len(planned.changes)} accepted spans; none outside."
        ),
        (
            f"Repaired positions read back within {written.deviation_mm:.2g} {take.units} "
            f"(the file's own resolution is {written.resolution_mm:.2g} {take.units})."
        ),
        f"Decisions: {beside.name}",
        f"SHA-256: {written.sha256}",
    ]
    if report:
        page = target.with_name(f"{target.name}.report.html")
        write_report(page, opened, planned, session, verified, overwrite=overwrite)
        verified.append(f"Report: {page.name}")
    return replace(planned, target=target, verified=tuple(verified))


def write_report(
    page: Path,
    opened: Opened,
    planned: Plan,
    session: ReviewSession,
    said: Sequence[str] = (),
    *,
    overwrite: bool,
) -> None:
    """Write the report of a take as one HTML page.

    Raises
    ------
    CannotWrite
        If the page is there already, or the disk refuses.
    """
    html = report_on(
        opened.take,
        planned.review,
        planned.review.live(planned.findings),
        planned.mended.repairs,
        planned.refusals,
        name=planned.name,
        written=said,
        decided=session.decided,
    )
    write_whole(page, html.encode(), overwrite=overwrite)
