"""What an operator decided on one take: frozen, whole, and free of positions."""

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any, Literal, get_args

from markermend.errors import BadInput, BadParameter, UnknownName
from markermend.model import KINDS, Finding, Kind, Span
from markermend.repairing.run import Wish

Verdict = Literal["accepted", "rejected", "deferred"]
VERDICTS: tuple[Verdict, ...] = get_args(Verdict)


@dataclass(frozen=True)
class Decision:
    """What an operator said of one finding; without a verdict the finding is still open.

    Attributes
    ----------
    verdict
        ``"accepted"`` (repair it), ``"rejected"`` (a false alarm, keep the data), ``"deferred"``
        (set aside), or None. To leave a gap is to accept it with the method ``"leave"``.
    kind, span
        What it is and where instead, or None where the finding is right.
    method, parameters
        The repair chosen; an empty method means the default of the kind.
    note
        The operator's own words.

    Raises
    ------
    UnknownName
        If there is no such verdict or kind.
    BadParameter
        If a parameter is no text, truth value or finite number.
    """

    verdict: Verdict | None = None
    kind: Kind | None = None
    span: Span | None = None
    method: str = ""
    parameters: Mapping[str, Any] = field(default_factory=dict, hash=False)
    note: str = ""

    def __post_init__(self) -> None:
        if self.verdict is not None and self.verdict not in VERDICTS:
            raise UnknownName.among("verdict", str(self.verdict), VERDICTS)
        if self.kind is not None and self.kind not in KINDS:
            raise UnknownName.among("kind", str(self.kind), KINDS)
        object.__setattr__(self, "parameters", frozen_parameters(self.parameters))

    @property
    def settled(self) -> bool:
        """Whether nothing is left to say: accepted or rejected."""
        return self.verdict in ("accepted", "rejected")


def frozen_parameters(given: Mapping[str, Any]) -> Mapping[str, Any]:
    """Copy parameters into a mapping that nobody can change.

    Raises
    ------
    BadParameter
        If a value is no text, truth value or finite number, since it could not be stored.
    """
    for name, value in given.items():
        plain = isinstance(value, str | bool | int | float)
        if not plain or (isinstance(value, float) and not math.isfinite(value)):
            raise BadParameter(f"{name} must be text, true or false, or a number; got {value!r}.")
    return MappingProxyType({name: given[name] for name in sorted(given)})


_UNTOUCHED = Decision()


@dataclass(frozen=True)
class Judgement:
    """A finding with its decision, complete without the detector that once found it.

    Attributes
    ----------
    finding
        As it was found or added, without its evidence.
    decision
        What was said of it.
    added
        Whether the operator put it there.
    replaced_by
        Ids of the findings that took its place when it was split or merged; it is no longer
        looked at while there are any.
    """

    finding: Finding
    decision: Decision = Decision()
    added: bool = False
    replaced_by: tuple[str, ...] = ()

    @property
    def kind(self) -> Kind:
        """What it is in the operator's eyes."""
        return self.decision.kind or self.finding.kind

    @property
    def span(self) -> Span:
        """Where it is in the operator's eyes."""
        return self.decision.span or self.finding.span

    @property
    def as_judged(self) -> Finding:
        """The finding with the operator's kind and span; its id is another where they differ."""
        if self.decision.kind is None and self.decision.span is None:
            return self.finding
        return replace(self.finding, kind=self.kind, span=self.span)

    @property
    def wish(self) -> Wish:
        """The repair that acceptance asks for."""
        return Wish(
            marker=self.finding.marker,
            span=self.span,
            kind=self.kind,
            partner=self.finding.partner,
            method=self.decision.method,
            parameters=dict(self.decision.parameters),
        )


@dataclass(frozen=True)
class Counts:
    """How many findings stand where."""

    accepted: int = 0
    rejected: int = 0
    deferred: int = 0
    open: int = 0

    @property
    def settled(self) -> int:
        """Accepted or rejected."""
        return self.accepted + self.rejected

    @property
    def total(self) -> int:
        """All findings."""
        return self.settled + self.deferred + self.open


@dataclass(frozen=True)
class Review:
    """All decisions on one take: the whole state that undo goes back to.

    Only findings that somebody touched are in it; a finding that a later detection does not find
    again keeps its place and its decision.

    Attributes
    ----------
    judgements
        Finding id -> judgement, in the order in which they were first touched.
    """

    judgements: Mapping[str, Judgement] = field(default_factory=dict, hash=False)

    def __post_init__(self) -> None:
        if not isinstance(self.judgements, MappingProxyType):
            object.__setattr__(self, "judgements", MappingProxyType(_copy(self.judgements)))

    def __len__(self) -> int:
        return len(self.judgements)

    def __iter__(self) -> Iterator[Judgement]:
        return iter(self.judgements.values())

    def decision(self, finding: Finding | str) -> Decision:
        """Give the decision on a finding or an id; an empty one where nobody touched it."""
        judgement = self.judgements.get(_id(finding))
        return _UNTOUCHED if judgement is None else judgement.decision

    def judgement(self, finding: Finding) -> Judgement:
        """Give the judgement on a finding; an empty one where nobody touched it."""
        return self.judgements.get(finding.id) or Judgement(replace(finding, evidence=None))

    def is_replaced(self, finding: Finding | str) -> bool:
        """Whether the finding was split or merged, so that others stand for it."""
        judgement = self.judgements.get(_id(finding))
        return judgement is not None and bool(judgement.replaced_by)

    def with_judgements(self, *changed: Judgement) -> "Review":
        """Return the review with these judgements put in or replaced."""
        merged = _copy(self.judgements) | {j.finding.id: j for j in changed}
        return Review(MappingProxyType(merged))

    def without(self, ids: Iterable[str]) -> "Review":
        """Return the review as if the findings of these ids had never been added."""
        gone = set(ids)
        return Review(
            {
                key: replace(j, replaced_by=tuple(r for r in j.replaced_by if r not in gone))
                if gone.intersection(j.replaced_by)
                else j
                for key, j in self.judgements.items()
                if key not in gone
            }
        )

    def live(self, detected: Iterable[Finding] = ()) -> tuple[Finding, ...]:
        """Give every finding that there is to look at, each once.

        These are the ones detected (with their evidence), those added by hand, and those decided
        on that the detection no longer finds; without the ones that were split or merged.
        """
        found = {f.id: f for f in detected}
        for key, judgement in self.judgements.items():
            found.setdefault(key, judgement.finding)
        return tuple(f for key, f in found.items() if not self.is_replaced(key))

    def accepted(self) -> tuple[Wish, ...]:
        """Give the repairs that the accepted findings ask for, in the order of marker and time.

        All of them together are what `markermend.repairing.repair_all` computes from the take as
        recorded, each with all their spans masked.
        """
        wishes = [j.wish for j in self if j.decision.verdict == "accepted" and not j.replaced_by]
        return tuple(sorted(wishes, key=lambda wish: (wish.marker, wish.span, wish.kind)))

    def clashes(self) -> tuple[tuple[Wish, Wish], ...]:
        """Give pairs of accepted repairs that would write the same samples.

        An export refuses them; merging the two findings or giving one up resolves it.
        """
        touched: dict[str, list[Wish]] = {}
        for wish in self.accepted():
            for marker in {wish.marker, wish.partner or wish.marker}:
                touched.setdefault(marker, []).append(wish)
        pairs: dict[tuple[int, int], tuple[Wish, Wish]] = {}
        for wishes in touched.values():
            reaching: list[Wish] = []
            for wish in sorted(wishes, key=lambda wish: wish.span):
                reaching = [w for w in reaching if w.span.stop > wish.span.start]
                for other in reaching:
                    pairs.setdefault((id(other), id(wish)), (other, wish))
                reaching.append(wish)
        return tuple(pairs.values())

    def counts(self, detected: Iterable[Finding] = ()) -> Counts:
        """Count verdicts over all `live` findings."""
        numbers = dict.fromkeys((*VERDICTS, "open"), 0)
        for finding in self.live(detected):
            numbers[self.decision(finding).verdict or "open"] += 1
        return Counts(**numbers)

    def changed(self, other: "Review") -> tuple[str, ...]:
        """Give the ids on which two reviews differ."""
        mine, theirs = self.judgements, other.judgements

        def differs(key: str) -> bool:
            one, two = mine.get(key), theirs.get(key)
            return one is not two and one != two  # most are the very same: this must be fast

        return tuple(key for key in _copy(mine) | _copy(theirs) if differs(key))


def plain(finding: Finding) -> Finding:
    """Give the finding as it is stored: without evidence, numbers rounded as in JSON.

    A review rebuilt from its journal is therefore equal to the one that was never closed.

    Raises
    ------
    BadInput
        If one of its numbers is not finite.
    """
    numbers = (finding.score, finding.strength, finding.amplitude or 0.0)
    if not all(math.isfinite(number) for number in numbers):
        raise BadInput(
            f"The finding on {finding.marker} at {finding.span.start} has a score, strength or "
            f"amplitude that is not finite: {numbers}; mend the detector {finding.detector!r}."
        )
    return Finding.from_json(finding.to_json())


def _copy(judgements: Mapping[str, Judgement]) -> dict[str, Judgement]:
    # dict(proxy) asks for every key by itself and is thirty times slower.
    return judgements.copy() if isinstance(judgements, MappingProxyType) else dict(judgements)


def _id(finding: Finding | str) -> str:
    return finding if isinstance(finding, str) else finding.id
