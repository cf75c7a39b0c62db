"""The start of a third review, made of two or more that were done apart."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from markermend.comparing.grouping import Group, Said, groups, sayings
from markermend.errors import BadInput
from markermend.evaluate.matching import IOU
from markermend.model import KINDS, Finding
from markermend.review import Adopt, Decision, Judgement, Review


@dataclass(frozen=True)
class Case:
    """One thing that somebody judged, and what each person said of it.

    Attributes
    ----------
    said
        One entry per person, None where that person said nothing of it.
    """

    said: tuple[Said | None, ...]

    @property
    def first(self) -> Judgement:
        """The judgement of the first person who has one."""
        return Group(self.said).first.judgement

    @property
    def finding(self) -> Finding:
        """The finding that stands for it: that of the first person who has one."""
        return self.first.finding

    @property
    def agreed(self) -> bool:
        """Whether all decided alike: the same verdict, and if accepted kind, span and repair."""
        opinions = [None if said is None else _opinion(said) for said in self.said]
        return opinions[0] is not None and len(set(opinions)) == 1

    def decision(self, person: int) -> Decision:
        """Give what it would mean for `finding` to follow one person.

        Who said nothing of it called nothing wrong there.
        """
        said = self.said[person]
        if said is None:
            return Decision("rejected")
        theirs = said.judgement.decision
        return replace(
            theirs,
            kind=None if said.kind == self.finding.kind else said.kind,
            span=None if said.span == self.finding.span else said.span,
        )


def cases(reviews: Sequence[Review], *, iou: float = IOU) -> tuple[Case, ...]:
    """Give every thing that one of the reviews judged, ordered by time; a swap is one thing.

    Parameters
    ----------
    reviews
        Reviews of one take.
    iou
        Overlap from which two spans are about the same thing.
    """
    people = [_by_finding(review) for review in reviews]
    return tuple(Case(group.said) for group in groups(people, iou, 0))


def adjudication(
    reviews: Sequence[Review], names: Sequence[str] = (), *, iou: float = IOU
) -> Review:
    """Take over what all reviews decided alike, and leave open what they did not.

    Alike means the same verdict, kind, span and repair.  Where they differ, the finding of the
    first review that has one stands open, with a note of who said what; a group that some did not
    see at all is open too.

    Parameters
    ----------
    reviews
        Reviews of one take.
    names
        Who made them, for the notes; by default they are numbered.
    iou
        Overlap from which two spans are about the same thing.

    Raises
    ------
    BadInput
        If there are not as many names as reviews.
    """
    people = tuple(names) or tuple(str(number) for number in range(1, len(reviews) + 1))
    if len(people) != len(reviews):
        raise BadInput(f"{len(reviews)} reviews need as many names; got {len(people)}.")
    judged = [_settled(case, people) for case in cases(reviews, iou=iou)]
    return Review({judgement.finding.id: judgement for judgement in judged})


def taken_over(review: Review) -> Adopt:
    """Give the one command that makes this review of an empty one.

    Raises
    ------
    BadInput
        If the review is empty.
    """
    if not len(review):
        raise BadInput("Nobody has judged anything, so there is nothing to take over.")
    judged = tuple(review)
    return Adopt(
        tuple(judgement.finding for judgement in judged),
        tuple(judgement.decision for judgement in judged),
        tuple(judgement.added for judgement in judged),
    )


def _by_finding(review: Review) -> list[Said]:
    """Give one saying per judgement: a swap is decided on once."""
    return [said for said in sayings(review, KINDS) if said.marker == said.judgement.finding.marker]


def _settled(case: Case, names: Sequence[str]) -> Judgement:
    if case.agreed:
        return case.first
    words = "; ".join(
        f"{name}: {_words(said)}" for name, said in zip(names, case.said, strict=True)
    )
    return replace(case.first, decision=Decision(note=words))


def _opinion(said: Said) -> tuple[object, ...]:
    decision = said.judgement.decision
    if decision.verdict != "accepted":
        return (decision.verdict,)
    parameters = tuple(decision.parameters.items())
    return ("accepted", said.kind, said.span, decision.method, parameters)


def _words(said: Said | None) -> str:
    if said is None:
        return "nothing here"
    decision = said.judgement.decision
    text = f"{decision.verdict or 'open'} as {said.kind} {said.span.start}-{said.span.stop}"
    return f"{text} with {decision.method}" if decision.method else text
