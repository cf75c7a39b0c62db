"""What a batch may repair by itself: only what an explicit policy names, within its limits."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from markermend.errors import BadInput, UnknownName
from markermend.model import KINDS, Finding, Kind, Take
from markermend.params import checked
from markermend.repairing import REPAIRS, Repair, Wish
from markermend.review.mending import Mended, accepted_all, mend
from markermend.review.records import Record
from markermend.review.state import Decision, Review

SCHEMA = "markermend/policy"
_MOST_BYTES = 1_000_000
_LONGEST_S = 1e6
_LARGEST_MM = 1e6


@dataclass(frozen=True)
class Rule:
    """How findings of one kind are repaired.

    Attributes
    ----------
    method, parameters
        The repair; an empty method means the default of the kind.
    most_mm
        A repair that is expected to be further off, or cannot say, is not made.
    most_s
        Longer spans are not repaired.
    """

    method: str = ""
    parameters: Mapping[str, Any] = field(default_factory=dict)
    most_mm: float | None = None
    most_s: float | None = None


@dataclass(frozen=True)
class Policy:
    """What is repaired, by kind; every other kind stays as it is."""

    rules: Mapping[Kind, Rule]

    @property
    def kinds(self) -> tuple[Kind, ...]:
        """The kinds that are repaired."""
        return tuple(kind for kind in KINDS if kind in self.rules)

    def to_json(self) -> dict[str, Any]:
        """Give it as the content of a policy file."""
        rules = {
            kind: {
                "method": rule.method,
                "parameters": dict(rule.parameters),
                "most_mm": rule.most_mm,
                "most_s": rule.most_s,
            }
            for kind, rule in sorted(self.rules.items())
        }
        return {"schema": SCHEMA, "version": 1, "repair": rules}


@dataclass(frozen=True)
class Stay:
    """A finding of a kind that is repaired, which stays, and why."""

    wish: Wish
    reason: str

    def to_json(self) -> dict[str, Any]:
        """Give it as in the report of a repair."""
        return {
            "marker": self.wish.marker,
            "start": self.wish.span.start,
            "stop": self.wish.span.stop,
            "kind": self.wish.kind,
            "reason": self.reason,
        }


def read_policy(said: str, most_mm: float | None = None) -> Policy:
    """Understand a policy: kinds with commas between, or the path of a policy file.

    Parameters
    ----------
    said
        ``"gap"``, ``"gap,peak"``, or a file ``*.json`` that holds ``{"schema": "markermend/policy",
        "version": 1, "repair": {"gap": {"method": "auto", "most_mm": 5, "most_s": 0.5}}}``.
    most_mm
        A limit on the expected error for all kinds that have none of their own.

    Raises
    ------
    BadInput
        If it is neither, or names an unknown kind, method or parameter.
    """
    policy = _from_file(Path(said)) if said.endswith(".json") else _from_words(said)
    if most_mm is None:
        return policy
    return Policy(
        {
            kind: rule if rule.most_mm is not None else replace(rule, most_mm=most_mm)
            for kind, rule in policy.rules.items()
        }
    )


def _from_words(said: str) -> Policy:
    # "gaps" is what people say.
    words = [word.strip() for word in said.split(",") if word.strip()]
    kinds = [word.removesuffix("s") if word.removesuffix("s") in KINDS else word for word in words]
    unknown = [word for word in kinds if word not in KINDS]
    if unknown or not kinds:
        raise BadInput(
            f"--repair takes some of {', '.join(KINDS)} with commas between, or a policy file "
            f"that ends in .json; got {said!r}."
        )
    return Policy({kind: Rule() for kind in KINDS if kind in kinds})


def _from_file(path: Path) -> Policy:
    try:
        if path.stat().st_size > _MOST_BYTES:
            raise BadInput(f"{path} is too large for a policy; give the file of a policy.")
        given = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise BadInput(f"The policy {path} cannot be read: {error.strerror or error}.") from None
    except (ValueError, RecursionError):
        raise BadInput(
            f"The policy {path} is no JSON; mend it or give kinds, as gap,peak."
        ) from None
    where = f"The policy {path.name}"
    record = Record(given, where)
    record.one_of("schema", (SCHEMA,))
    if record.whole("version", 1, 1_000_000) != 1:
        raise BadInput(f"{where} was written by a newer version; update markermend.")
    return policy_from_json(record.value("repair"), where)


def policy_from_json(rules: Any, where: str) -> Policy:
    """Read the rules of a policy: what stands under ``repair`` in its file.

    Raises
    ------
    BadInput
        If they are no rules, or name an unknown kind, method or parameter.
    """
    if not isinstance(rules, dict) or not rules:
        raise Record({}, where).wrong("repair", "an object with a rule by kind", rules)
    return Policy(
        {_kind(kind): _rule(Record(rule, f"{where}: {kind}")) for kind, rule in rules.items()}
    )


def _kind(word: str) -> Kind:
    for kind in KINDS:
        if kind == word:
            return kind
    raise UnknownName.among("kind", word, KINDS)


def _rule(record: Record) -> Rule:
    known = ("method", "parameters", "most_mm", "most_s")
    for name in record.fields:
        if name not in known:
            raise UnknownName.among(f"field of a rule ({record.where})", str(name), known)
    method, parameters = record.text("method", ""), record.value("parameters", {})
    if not isinstance(parameters, dict) or (parameters and not method):
        raise record.wrong("parameters", "an object, beside the method they belong to", parameters)
    if method:
        checked(REPAIRS.get(method).function, parameters)
    return Rule(
        method,
        parameters,
        record.number_or_none("most_mm", 0, _LARGEST_MM),
        record.number_or_none("most_s", 0, _LONGEST_S),
    )


def mend_by(
    policy: Policy, take: Take, findings: Sequence[Finding]
) -> tuple[Review, Mended, tuple[Stay, ...]]:
    """Compute the repairs that a policy makes in a take; nothing is written.

    Gaps at the ends of the take stay.  Every repair is computed with all repaired spans masked,
    and one that is beyond its limit is given up and the others are computed anew without it: the
    decision file therefore makes the same file again.

    Parameters
    ----------
    policy
        What is repaired.
    take, findings
        The take, and everything that was found in it.

    Returns
    -------
    review
        The decisions: repaired findings accepted, those beyond a limit set aside with the reason.
    mended
        The computed repairs.
    stays
        What was not repaired and why.

    Raises
    ------
    BadInput
        If two repairs would write the same sample.
    """
    wanted = [f for f in findings if f.kind in policy.rules and _inner(f, take)]
    review = _with_methods(policy, accepted_all(wanted))
    stays: dict[str, Stay] = {}
    review, stays = _set_aside(review, _too_long(policy, review, take.rate))
    while True:
        wishes = review.accepted()
        mended = mend(take, wishes)
        review, beyond = _set_aside(review, _too_far_off(policy, review, mended.repairs))
        stays |= beyond
        if not beyond:
            break
    refused = tuple(Stay(refusal.wish, refusal.reason) for refusal in mended.refusals)
    return review, mended, (*stays.values(), *refused)


def _inner(finding: Finding, take: Take) -> bool:
    span = finding.span
    return finding.kind != "gap" or (span.start > 0 and span.stop < take.n_frames)


def _with_methods(policy: Policy, review: Review) -> Review:
    return review.with_judgements(
        *(
            replace(
                judgement,
                decision=Decision(
                    "accepted",
                    method=policy.rules[judgement.kind].method,
                    parameters=policy.rules[judgement.kind].parameters,
                ),
            )
            for judgement in review
        )
    )


def _set_aside(review: Review, reasons: Mapping[str, str]) -> tuple[Review, dict[str, Stay]]:
    stays = {key: Stay(review.judgements[key].wish, reason) for key, reason in reasons.items()}
    changed = (
        replace(review.judgements[key], decision=Decision("deferred", note=reason))
        for key, reason in reasons.items()
    )
    return review.with_judgements(*changed), stays


def _too_long(policy: Policy, review: Review, rate: float) -> dict[str, str]:
    reasons = {}
    for key, judgement in review.judgements.items():
        most, lasts = policy.rules[judgement.kind].most_s, len(judgement.span) / rate
        if most is not None and lasts > most:
            reasons[key] = f"it lasts {lasts:.2f} s, and the policy repairs at most {most:g} s"
    return reasons


def _too_far_off(policy: Policy, review: Review, repairs: Sequence[Repair]) -> dict[str, str]:
    made = {(done.marker, done.span): done for done in repairs}
    reasons = {}
    for key, judgement in review.judgements.items():
        done = made.get((judgement.finding.marker, judgement.span))
        most = policy.rules[judgement.kind].most_mm
        if done is None or most is None or judgement.decision.verdict != "accepted":
            continue
        if done.expected_mm is None:
            reasons[key] = f"{done.method} cannot say how far off it is; the policy asks for it"
        elif not done.expected_mm <= most:
            reasons[key] = (
                f"{done.method} expects to be {done.expected_mm:.1f} mm off, and the policy allows "
                f"{most:g} mm"
            )
    return reasons
