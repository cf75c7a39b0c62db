"""What a trainee says is wrong with a take, one record for each marker and span."""

from collections.abc import Iterable
from dataclasses import dataclass

from markermend.model import Kind, Span
from markermend.review import Judgement, Review


@dataclass(frozen=True)
class Claim:
    """One accepted finding; a swap makes one for each of its two markers.

    Attributes
    ----------
    marker, span, kind
        What was said.
    finding
        Id of the finding.
    method
        The repair chosen, empty for the default of the kind.
    """

    marker: str
    span: Span
    kind: Kind
    finding: str
    method: str


def claims(review: Review) -> tuple[Claim, ...]:
    """Give what was accepted, each marker, span and kind once, ordered by time."""
    found: dict[tuple[str, Span, Kind], Claim] = {}
    for judgement in review:
        if judgement.decision.verdict == "accepted" and not judgement.replaced_by:
            for claim in _of(judgement):
                found.setdefault((claim.marker, claim.span, claim.kind), claim)
    return tuple(sorted(found.values(), key=lambda c: (c.span, c.marker, c.kind)))


def rejected(review: Review) -> tuple[Claim, ...]:
    """Give what was called a false alarm, as it was found."""
    return tuple(
        claim
        for judgement in review
        if judgement.decision.verdict == "rejected" and not judgement.replaced_by
        for claim in _of(judgement)
    )


def _of(judgement: Judgement) -> Iterable[Claim]:
    finding = judgement.finding
    for marker in (finding.marker, finding.partner):
        if marker is not None:
            yield Claim(
                marker, judgement.span, judgement.kind, finding.id, judgement.decision.method
            )
