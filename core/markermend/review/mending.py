"""From decisions to a repaired file: compute, write, and put the decisions beside it."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

from markermend.detection import overlapping
from markermend.io import Written, export
from markermend.io.disk import refuse_existing
from markermend.model import Finding, Kind, Span, Take
from markermend.repairing import Refusal, Repair, Wish, apply, repair_all
from markermend.review.decisions import Attribution, decisions_on
from markermend.review.state import Decision, Judgement, Review


@dataclass(frozen=True, eq=False)
class Mended:
    """A take with its accepted repairs computed, nothing written yet.

    Attributes
    ----------
    original, repaired
        The take as recorded and as it would be exported.
    repairs, refusals
        What was done, and what no method could do and why.
    """

    original: Take
    repaired: Take
    repairs: tuple[Repair, ...]
    refusals: tuple[Refusal, ...]

    @property
    def spans(self) -> tuple[tuple[str, Span], ...]:
        """Everything that may differ from the original."""
        return tuple(
            (label, done.span)
            for done in self.repairs
            for label in (done.marker, *(partner for partner, _ in done.also))
        )


def mend(
    take: Take,
    wishes: Sequence[Wish],
    training: Sequence[Take] = (),
    progress: Callable[[int], None] = lambda _: None,
) -> Mended:
    """Compute all repairs from the take as recorded and put them in.

    Raises
    ------
    BadInput
        If two wishes would write the same sample.
    """
    repairs, refusals = repair_all(take, wishes, training, progress)
    return Mended(take, apply(take, repairs), repairs, refusals)


def save(
    mended: Mended,
    review: Review,
    path: Path,
    *,
    decided: Mapping[str, Attribution] | None = None,
    overwrite: bool = False,
) -> tuple[Written, Path]:
    """Write the repaired take, verified, and its decision file beside it.

    Parameters
    ----------
    mended, review
        What is written, and the decisions that it follows from.
    path
        The target.
    decided
        Finding id -> who decided and when, as far as known.
    overwrite
        Whether files of these two names are replaced.

    Returns
    -------
    written
        What was changed in the file.
    decisions
        Path of the decision file.

    Raises
    ------
    CannotWrite
        As `markermend.io.export`.
    """
    beside = decisions_path(path)
    refuse_existing(beside, overwrite=overwrite)  # before the other file is there
    written = export(mended.original, mended.repaired, path, mended.spans, overwrite=overwrite)
    decisions_on(mended.original, review, repairs=mended.repairs, decided=decided).write(beside)
    return written, beside


def decisions_path(path: Path) -> Path:
    """Give the name of the decision file beside an export."""
    return path.with_name(f"{path.name}.decisions.json")


def accepted_all(findings: Iterable[Finding], method: str = "") -> Review:
    """Give the review in which every one of these findings is accepted.

    Findings of one marker that overlap are accepted as one, of the kind of the longest, since two
    repairs cannot write one sample.

    Parameters
    ----------
    findings
        What is to be repaired.
    method
        Name of the repair, or empty for the default of each kind.
    """
    decision = Decision("accepted", method=method)
    judgements = [
        _joined(group, decision) if len(group) > 1 else Judgement(group[0], decision)
        for group in overlapping(findings)
    ]
    return Review({judgement.finding.id: judgement for judgement in judgements})


def _joined(group: Sequence[Finding], decision: Decision) -> Judgement:
    longest = max(group, key=lambda finding: len(finding.span))
    kind: Kind = longest.kind
    span = Span(min(f.span.start for f in group), max(f.span.stop for f in group))
    axes = sorted(set(chain.from_iterable(f.axes for f in group)))
    sizes = [f.amplitude for f in group if f.amplitude is not None]
    finding = Finding(
        longest.marker,
        span,
        kind,
        score=max(f.score for f in group),
        axes=tuple(axes),
        amplitude=max(sizes, default=None),
        detector=longest.detector,
        partner=longest.partner,
    )
    return Judgement(finding, decision, added=True)
