"""One frozen class per intention of an operator, each with one pure ``apply``.

There is no inverse anywhere: undo goes back to an earlier review (see `markermend.review.session`).
A command carries the findings themselves, so that a journal of commands is complete without the
detector. One gesture is one command, also when it decides on many findings at once.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any, ClassVar

from markermend.errors import BadInput, UnknownName
from markermend.model import KINDS, Finding, Kind, Span
from markermend.review.records import decision_from_json, decision_to_json
from markermend.review.state import Decision, Judgement, Review, Verdict, frozen_parameters, plain


@dataclass(frozen=True)
class Command(ABC):
    """An intention on one or more findings."""

    name: ClassVar[str]
    verb: ClassVar[str]

    findings: tuple[Finding, ...]

    def __post_init__(self) -> None:
        given = (self.findings,) if isinstance(self.findings, Finding) else self.findings
        unique = {finding.id: plain(finding) for finding in given}
        if not unique:
            raise BadInput(f"{self.verb} needs a finding; none was given.")
        object.__setattr__(self, "findings", tuple(unique.values()))
        if "parameters" in _fields(type(self)):
            object.__setattr__(self, "parameters", frozen_parameters(self.parameters))  # type: ignore[attr-defined]

    @property
    def finding(self) -> Finding:
        """The first finding."""
        return self.findings[0]

    @abstractmethod
    def apply(self, review: Review) -> Review:
        """Return the review after this command.

        Raises
        ------
        BadInput
            If the command makes no sense on this review.
        """

    def describe(self) -> str:
        """Say in one line what it does, in frames, for the list of things to undo."""
        return f"{self.verb} {_named(self.findings)}{self._detail()}"

    def _detail(self) -> str:
        return ""

    def to_json(self) -> dict[str, Any]:
        """Give it as a JSON object that `command_from_json` reads."""
        record: dict[str, Any] = {"command": self.name}
        for name in _fields(type(self)):
            value = getattr(self, name)
            record[name] = _WRITE[name](value) if name in _WRITE else value
        return record

    def _decide(self, review: Review, change: Callable[[Judgement], Decision]) -> Review:
        judged = [_standing(review, finding) for finding in self.findings]
        return review.with_judgements(*(replace(j, decision=change(j)) for j in judged))


@dataclass(frozen=True)
class _Verdict(Command):
    """A command that sets the verdict and keeps everything else that was said."""

    verdict: ClassVar[Verdict | None]

    def apply(self, review: Review) -> Review:
        return self._decide(review, lambda j: replace(j.decision, verdict=self.verdict))


@dataclass(frozen=True)
class Reject(_Verdict):
    """False alarm: keep the data."""

    name, verb, verdict = "reject", "Reject", "rejected"


@dataclass(frozen=True)
class Defer(_Verdict):
    """Set aside; the data stays as it is until somebody decides."""

    name, verb, verdict = "defer", "Set aside", "deferred"


@dataclass(frozen=True)
class Reopen(_Verdict):
    """Take the verdict back; kind, span, method and note stay."""

    name, verb, verdict = "reopen", "Reopen", None


@dataclass(frozen=True)
class Choose(Command):
    """Choose a repair without deciding; an empty method means the default of the kind."""

    name, verb = "choose", "Choose"
    method: str = ""
    parameters: Mapping[str, Any] = field(default_factory=dict, hash=False)

    def apply(self, review: Review) -> Review:
        """Set method and parameters."""
        return self._decide(
            review,
            lambda j: replace(j.decision, method=self.method, parameters=self.parameters),
        )

    def describe(self) -> str:
        """Say which repair was chosen for what."""
        return f"Choose {self.method or 'the default repair'} for {_named(self.findings)}"


@dataclass(frozen=True)
class Accept(Command):
    """Repair it; without a method, with the one chosen before."""

    name, verb = "accept", "Accept"
    method: str = ""
    parameters: Mapping[str, Any] = field(default_factory=dict, hash=False)

    def apply(self, review: Review) -> Review:
        """Set the verdict, and method and parameters where a method is given."""

        def accepted(judgement: Judgement) -> Decision:
            decision = replace(judgement.decision, verdict="accepted")
            if not self.method:
                return decision
            return replace(decision, method=self.method, parameters=self.parameters)

        return self._decide(review, accepted)

    def _detail(self) -> str:
        return f" with {self.method}" if self.method else ""


@dataclass(frozen=True)
class Reclassify(Command):
    """Say that it is of another kind."""

    name, verb = "reclassify", "Reclassify"
    kind: Kind

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.kind not in KINDS:
            raise UnknownName.among("kind", str(self.kind), KINDS)

    def apply(self, review: Review) -> Review:
        """Set the kind; the detector's own kind clears the change."""
        return self._decide(
            review,
            lambda j: replace(j.decision, kind=None if self.kind == j.finding.kind else self.kind),
        )

    def _detail(self) -> str:
        return f" as {self.kind}"


@dataclass(frozen=True)
class MoveEdges(Command):
    """Say where one finding really starts and stops."""

    name, verb = "move-edges", "Move"
    span: Span

    def apply(self, review: Review) -> Review:
        """Set the span; the detector's own span clears the change."""
        _one(self)
        return self._decide(
            review,
            lambda j: replace(j.decision, span=None if self.span == j.finding.span else self.span),
        )

    def _detail(self) -> str:
        return f" to {_frames(self.span)}"


@dataclass(frozen=True)
class Annotate(Command):
    """Leave a note; an empty one removes it."""

    name, verb = "annotate", "Note on"
    note: str

    def apply(self, review: Review) -> Review:
        """Set the note."""
        return self._decide(review, lambda j: replace(j.decision, note=self.note))


@dataclass(frozen=True)
class Adopt(Command):
    """Take over what somebody else decided on each of the findings, whole.

    Attributes
    ----------
    decisions
        One for each finding.
    added
        For each finding whether that person had put it there.
    """

    name, verb = "adopt", "Take over the decision on"
    decisions: tuple[Decision, ...]
    added: tuple[bool, ...]

    def __post_init__(self) -> None:
        super().__post_init__()
        if not len(self.findings) == len(self.decisions) == len(self.added):
            raise BadInput(
                f"Taking over needs one decision for each of the {len(self.findings)} findings; "
                f"got {len(self.decisions)}."
            )

    def apply(self, review: Review) -> Review:
        """Set the decisions; who is known as added stays so."""
        return review.with_judgements(
            *(
                replace(standing, decision=decision, added=standing.added or added)
                for finding, decision, added in zip(
                    self.findings, self.decisions, self.added, strict=True
                )
                for standing in [_standing(review, finding)]
            )
        )


@dataclass(frozen=True)
class AddFinding(Command):
    """Add findings that the detector missed."""

    name, verb = "add", "Add"

    def apply(self, review: Review) -> Review:
        """Add them, open; one that is already there is refused."""
        for finding in self.findings:
            if finding.id in review.judgements and not review.is_replaced(finding):
                raise BadInput(f"There is already a {_named((finding,))}; decide on that one.")
        return review.with_judgements(*(Judgement(f, added=True) for f in self.findings))


@dataclass(frozen=True)
class RemoveAdded(Command):
    """Take back findings that were added by hand, by splitting or by merging.

    What a finding had replaced comes back when the last of its replacements is removed.
    """

    name, verb = "remove", "Remove"

    def apply(self, review: Review) -> Review:
        """Remove them; a detected finding cannot be removed, only rejected."""
        for finding in self.findings:
            if not _standing(review, finding).added:
                raise BadInput(f"{_named((finding,))} was not added by hand; reject it instead.")
        return review.without(finding.id for finding in self.findings)


@dataclass(frozen=True)
class Split(Command):
    """Make two open findings of one, before and from frame ``at``."""

    name, verb = "split", "Split"
    at: int

    def apply(self, review: Review) -> Review:
        """Replace the finding by its two parts."""
        _one(self)
        judged = _standing(review, self.finding)
        span = judged.span
        if not span.start < self.at < span.stop:
            raise BadInput(
                f"Frame {self.at} does not divide {_frames(span)}; "
                f"split at {span.start + 1} to {span.stop - 1}."
            )
        parts = [Span(span.start, self.at), Span(self.at, span.stop)]
        whole = judged.as_judged
        return _replaced(review, [judged], [_by_hand(whole, span=part) for part in parts])

    def _detail(self) -> str:
        return f" at {self.at}"


@dataclass(frozen=True)
class Merge(Command):
    """Make one open finding of several of one marker, from the first start to the last stop.

    The kind is that of the longest.
    """

    name, verb = "merge", "Merge"

    def apply(self, review: Review) -> Review:
        """Replace the findings by one that covers them all."""
        judged = [_standing(review, finding) for finding in self.findings]
        markers = {j.finding.marker for j in judged}
        if len(judged) < 2 or len(markers) > 1:
            raise BadInput(
                f"Merging needs two or more findings of one marker; got {len(judged)} "
                f"of {', '.join(sorted(markers))}."
            )
        whole = Span(min(j.span.start for j in judged), max(j.span.stop for j in judged))
        longest = max(judged, key=lambda j: len(j.span)).as_judged
        amplitudes = [j.finding.amplitude for j in judged if j.finding.amplitude is not None]
        axes = {axis for j in judged for axis in j.finding.axes}
        merged = _by_hand(
            longest,
            span=whole,
            score=max(j.finding.score for j in judged),
            strength=max(j.finding.strength for j in judged),
            amplitude=max(amplitudes, default=None),
            axes=tuple(sorted(axes)),
        )
        return _replaced(review, judged, [merged])


COMMANDS: Mapping[str, type[Command]] = {
    kind.name: kind
    for kind in (
        Accept,
        Reject,
        Defer,
        Reopen,
        Choose,
        Reclassify,
        MoveEdges,
        Annotate,
        Adopt,
        AddFinding,
        RemoveAdded,
        Split,
        Merge,
    )
}


def command_from_json(record: Mapping[str, Any]) -> Command:
    """Read a command that `Command.to_json` wrote.

    Raises
    ------
    UnknownName
        If there is no such command: a newer version wrote it.
    """
    name = record["command"]
    if name not in COMMANDS:
        raise UnknownName.among("command", str(name), COMMANDS)
    kind = COMMANDS[name]
    given = {key: record[key] for key in _fields(kind)}
    return kind(**{key: _READ[key](v) if key in _READ else v for key, v in given.items()})


_WRITE: Mapping[str, Callable[[Any], Any]] = {
    "findings": lambda findings: [finding.to_json() for finding in findings],
    "span": lambda span: [span.start, span.stop],
    "parameters": dict,
    "decisions": lambda decisions: [decision_to_json(decision) for decision in decisions],
}
_READ: Mapping[str, Callable[[Any], Any]] = {
    "findings": lambda records: tuple(Finding.from_json(record) for record in records),
    "span": lambda pair: Span(*pair),
    "decisions": lambda given: tuple(decision_from_json(one, "A journal") for one in given),
    "added": tuple,
}


def _fields(kind: type[Command]) -> tuple[str, ...]:
    return tuple(f.name for f in fields(kind))


def _one(command: Command) -> None:
    if len(command.findings) != 1:
        raise BadInput(
            f"{command.verb} takes one finding; got {len(command.findings)}. Merge them first."
        )


def _standing(review: Review, finding: Finding) -> Judgement:
    """Give the judgement of a finding that can still be decided on."""
    if review.is_replaced(finding):
        raise BadInput(f"{_named((finding,))} was split or merged; decide on what replaced it.")
    return replace(review.judgement(finding), finding=finding)


def _by_hand(finding: Finding, **changes: Any) -> Finding:
    return replace(finding, detector="operator", **changes)


def _replaced(review: Review, old: list[Judgement], new: list[Finding]) -> Review:
    """Put `new` findings, open and with all notes, in the place of `old` ones.

    A new finding may be one of the old ones (its span covers the others): then it stays, open
    again. Or it may be one that already stands for itself: then its decision is kept.
    """
    before = {judgement.finding.id: judgement for judgement in old}
    ids = tuple(finding.id for finding in new)
    note = "; ".join(dict.fromkeys(j.decision.note for j in old if j.decision.note))
    fresh = [
        Judgement(finding, Decision(note=note), added=before[id_].added if id_ in before else True)
        for id_, finding in zip(ids, new, strict=True)
        if id_ in before or id_ not in review.judgements or review.is_replaced(finding)
    ]
    hidden = [replace(j, replaced_by=ids) for j in old]  # overruled below for one that stays
    return review.with_judgements(*hidden, *fresh)


def _frames(span: Span) -> str:
    return f"{span.start}-{span.stop}"


def _named(findings: tuple[Finding, ...]) -> str:
    if len(findings) == 1:
        finding = findings[0]
        return f"{finding.marker} {finding.kind} {_frames(finding.span)}"
    kinds = {finding.kind for finding in findings}
    of_kind = f"{next(iter(kinds))} " if len(kinds) == 1 else ""
    return f"{len(findings)} {of_kind}findings"
