"""The start of a third review, made of two or more that were done apart."""

from collections.abc import Sequence
from dataclasses import replace

from markermend.comparing.grouping import Group, Said, groups, sayings
from markermend.evaluate.matching import IOU
from markermend.model import KINDS
from markermend.review import Decision, Judgement, Review


def adjudication(reviews: Sequence[Review], *, iou: float = IOU) -> Review:
    """Take over what all reviews decided alike, and leave open what they did not.

    Alike means the same verdict, kind, span and repair.  Where they differ, the finding of the
    first review that has one stands open, with a note of who said what; a group that some did not
    see at all is open too.

    Parameters
    ----------
    reviews
        Reviews of one take.
    iou
        Overlap from which two spans are about the same thing.
    """
    people = [_by_finding(review) for review in reviews]
    judged = [_settled(group) for group in groups(people, iou, 0)]
    return Review({judgement.finding.id: judgement for judgement in judged})


def _by_finding(review: Review) -> list[Said]:
    """Give one saying per judgement: a swap is decided on once."""
    return [said for said in sayings(review, KINDS) if said.marker == said.judgement.finding.marker]


def _settled(group: Group) -> Judgement:
    first = group.first.judgement
    opinions = [None if said is None else _opinion(said) for said in group.said]
    if opinions[0] is not None and all(opinion == opinions[0] for opinion in opinions):
        return first
    words = "; ".join(f"{number}: {_words(said)}" for number, said in enumerate(group.said, 1))
    return replace(first, decision=Decision(note=words))


def _opinion(said: Said) -> tuple[object, ...]:
    decision = said.judgement.decision
    if decision.verdict != "accepted":
        return (decision.verdict,)
    return ("accepted", said.kind, said.span, decision.method, decision.parameters)


def _words(said: Said | None) -> str:
    if said is None:
        return "nothing here"
    decision = said.judgement.decision
    text = f"{decision.verdict or 'open'} as {said.kind} {said.span.start}-{said.span.stop}"
    return f"{text} with {decision.method}" if decision.method else text
