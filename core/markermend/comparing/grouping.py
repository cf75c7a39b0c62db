"""Which judgements of several people are about the same thing."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

from markermend.evaluate.matching import overlap
from markermend.model import Kind, Span
from markermend.review import Judgement, Review, Verdict


@dataclass(frozen=True)
class Said:
    """What one person said of one span of one marker.

    Attributes
    ----------
    marker, span, kind
        Where, and what it is in that person's eyes.
    verdict
        What was decided, or None where it is open.
    judgement
        The judgement that it comes from.
    """

    marker: str
    span: Span
    kind: Kind
    verdict: Verdict | None
    judgement: Judgement


@dataclass(frozen=True)
class Group:
    """One thing that somebody judged: at most one saying of each person.

    Attributes
    ----------
    said
        One entry per person, None where that person said nothing of it.
    """

    said: tuple[Said | None, ...]

    @property
    def first(self) -> Said:
        """The saying of the first person who has one."""
        return next(said for said in self.said if said is not None)


def sayings(review: Review, kinds: Sequence[str]) -> tuple[Said, ...]:
    """Give what a review says of these kinds, a swap once for each of its markers."""
    found: dict[tuple[str, Span, Kind], Said] = {}
    for judgement in review:
        if judgement.replaced_by or judgement.kind not in kinds:
            continue
        finding, verdict = judgement.finding, judgement.decision.verdict
        for marker in (finding.marker, finding.partner):
            if marker is not None:
                said = Said(marker, judgement.span, judgement.kind, verdict, judgement)
                found.setdefault((marker, said.span, said.kind), said)
    return tuple(found.values())


def groups(people: Sequence[Sequence[Said]], least: float, slack: int) -> tuple[Group, ...]:
    """Put together what is about the same thing, the best overlap first, kinds aside.

    Two sayings of different people belong together if they are on one marker and their `overlap`
    is at least `least`.  Two groups are joined by such a pair where no person is in both.
    """
    items = [(person, said) for person, all_said in enumerate(people) for said in all_said]
    by_marker: dict[str, list[int]] = {}
    for i, (_, said) in enumerate(items):
        by_marker.setdefault(said.marker, []).append(i)
    candidates = sorted(
        (-share, i, j)
        for same in by_marker.values()
        for i, j in combinations(same, 2)
        if items[i][0] != items[j][0]
        and (share := overlap(items[i][1].span, items[j][1].span, slack)) >= least
    )
    group_of = {i: {person: said} for i, (person, said) in enumerate(items)}
    for _, i, j in candidates:
        one, other = group_of[i], group_of[j]
        if one is other or one.keys() & other.keys():
            continue
        one |= other
        for k, known in group_of.items():
            if known is other:
                group_of[k] = one
    unique = {id(group): group for group in group_of.values()}
    made = (Group(tuple(g.get(p) for p in range(len(people)))) for g in unique.values())
    return tuple(sorted(made, key=lambda g: (g.first.span, g.first.marker)))
