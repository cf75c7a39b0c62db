"""Judgements as JSON, read back with every field checked: files may come from anywhere."""

import math
from collections.abc import Mapping
from typing import Any

from markermend.errors import BadDecisions, BadInput
from markermend.model import AXES, KINDS, Finding, Span
from markermend.review.state import VERDICTS, Decision, Judgement, plain

MAX_TEXT = 10_000
MAX_FRAMES = 1_000_000_000
MAX_PARAMETERS = 100


def judgement_to_json(judgement: Judgement) -> dict[str, Any]:
    """Give a judgement as a JSON object."""
    return {
        **plain(judgement.finding).to_json(),
        "decision": decision_to_json(judgement.decision),
        "added": judgement.added,
        "replaced_by": list(judgement.replaced_by),
    }


def decision_to_json(decision: Decision) -> dict[str, Any]:
    """Give a decision as a JSON object."""
    return {
        "verdict": decision.verdict,
        "kind": decision.kind,
        "span": None if decision.span is None else [decision.span.start, decision.span.stop],
        "method": decision.method,
        "parameters": dict(decision.parameters),
        "note": decision.note,
    }


def judgement_from_json(given: Any, where: str) -> Judgement:
    """Read a judgement; unknown fields are passed over.

    Parameters
    ----------
    given
        What stood in the file, whatever it is.
    where
        How to name it in a message.

    Raises
    ------
    BadDecisions
        If a field is missing, has the wrong type, or lies outside what is possible.
    """
    record = Record(given, where)
    try:
        finding = _finding(record)
        decision = decision_from_json(record.value("decision", {}), where)
    except BadDecisions:
        raise
    except BadInput as error:
        raise BadDecisions(f"{where} is not valid: {error}") from None
    if record.text("id", finding.id) != finding.id:
        raise BadDecisions(
            f"{where} has the id {_short(record.value('id'))}, but its marker, kind and span make "
            f"{finding.id}; put changed edges or kinds under its decision."
        )
    return Judgement(
        finding=finding,
        decision=decision,
        added=record.flag("added", False),
        replaced_by=record.texts("replaced_by", ()),
    )


def decision_from_json(given: Any, where: str) -> Decision:
    """Read a decision.

    Raises
    ------
    BadDecisions
        As `judgement_from_json`.
    BadInput
        If a parameter is none that could be stored.
    """
    said = Record(given, f"The decision of {where}")
    edges = said.value("span", None)
    parameters = said.value("parameters", {})
    if (
        not isinstance(parameters, dict)
        or len(parameters) > MAX_PARAMETERS
        or not all(isinstance(v, str | bool | int | float) for v in parameters.values())
    ):
        raise said.wrong("parameters", "an object of texts and numbers by name", parameters)
    return Decision(
        verdict=said.one_of("verdict", (*VERDICTS, None), None),
        kind=said.one_of("kind", (*KINDS, None), None),
        span=None if edges is None else _span(said, edges),
        method=said.text("method", ""),
        parameters=parameters,
        note=said.text("note", ""),
    )


class Record:
    """A JSON object whose fields are taken out with a check each."""

    def __init__(self, given: Any, where: str) -> None:
        if not isinstance(given, dict):
            raise BadDecisions(f"{where} must be an object; got {_short(given)}.")
        self.fields: Mapping[str, Any] = given
        self.where = where

    def wrong(self, name: str, wanted: str, given: Any) -> BadDecisions:
        """Give the error for a field."""
        return BadDecisions(f"{self.where}: {name} must be {wanted}; got {_short(given)}.")

    def value(self, name: str, *default: Any) -> Any:
        """Give a field as it is, or the default if there is one."""
        if name in self.fields:
            return self.fields[name]
        if not default:
            raise BadDecisions(f"{self.where} has no {name!r}; it is no file of decisions or cut.")
        return default[0]

    def text(self, name: str, *default: str) -> str:
        """Give a text of reasonable length."""
        value = self.value(name, *default)
        if not isinstance(value, str) or len(value) > MAX_TEXT:
            raise self.wrong(name, f"text of at most {MAX_TEXT} characters", value)
        return value

    def texts(self, name: str, default: tuple[str, ...]) -> tuple[str, ...]:
        """Give a list of short texts."""
        value = self.value(name, list(default))
        if not isinstance(value, list) or not all(
            isinstance(item, str) and len(item) <= MAX_TEXT for item in value
        ):
            raise self.wrong(name, "a list of texts", value)
        return tuple(value)

    def flag(self, name: str, default: bool) -> bool:
        """Give true or false."""
        value = self.value(name, default)
        if not isinstance(value, bool):
            raise self.wrong(name, "true or false", value)
        return value

    def whole(self, name: str, low: int, high: int) -> int:
        """Give a whole number within bounds."""
        return self.check_whole(name, self.value(name), low, high)

    def check_whole(self, name: str, value: Any, low: int, high: int) -> int:
        """Check that a value is a whole number within bounds."""
        if not isinstance(value, int) or isinstance(value, bool) or not low <= value <= high:
            raise self.wrong(name, f"a whole number in {low} to {high}", value)
        return value

    def number(self, name: str, low: float, high: float, *default: float) -> float:
        """Give a finite number within bounds."""
        value = self.value(name, *default)
        good = isinstance(value, int | float) and not isinstance(value, bool)
        if not good or not low <= value <= high or not math.isfinite(value):
            raise self.wrong(name, f"a number in {low:g} to {high:g}", value)
        return float(value)

    def number_or_none(self, name: str, low: float, high: float) -> float | None:
        """Give a finite number within bounds, or None where it is null or missing."""
        return None if self.value(name, None) is None else self.number(name, low, high)

    def one_of(self, name: str, allowed: tuple[Any, ...], *default: Any) -> Any:
        """Give one of the allowed values."""
        value = self.value(name, *default)
        if not isinstance(value, str | None) or value not in allowed:
            words = ", ".join("null" if word is None else str(word) for word in allowed)
            raise self.wrong(name, f"one of {words}", value)
        return value

    def text_or_none(self, name: str) -> str | None:
        """Give a text, or None where it is null or missing."""
        return None if self.value(name, None) is None else self.text(name)


def _finding(record: Record) -> Finding:
    start = record.whole("start", 0, MAX_FRAMES)
    axes = record.texts("axes", AXES)
    if len(axes) > len(AXES) or not set(axes) <= set(AXES):
        raise record.wrong("axes", "among x, y, z", list(axes))
    return plain(
        Finding(
            marker=record.text("marker"),
            span=Span(start, record.whole("stop", start + 1, MAX_FRAMES)),
            kind=record.one_of("kind", KINDS),
            score=record.number("score", 0, 1, 1.0),
            axes=axes,
            amplitude=record.number_or_none("amplitude", -1e12, 1e12),
            detector=record.text("detector", "operator"),
            strength=record.number("strength", 0, 1e12, 1.0),
            partner=record.text_or_none("partner"),
            group=record.text_or_none("group"),
        )
    )


def _span(record: Record, edges: Any) -> Span:
    if not isinstance(edges, list) or len(edges) != 2:
        raise record.wrong("span", "[start, stop] or null", edges)
    start = record.check_whole("span", edges[0], 0, MAX_FRAMES - 1)
    return Span(start, record.check_whole("span", edges[1], start + 1, MAX_FRAMES))


def _short(value: Any) -> str:
    # repr of a huge value is itself an attack; a type says enough where a text would be long.
    if value is None or isinstance(value, bool | float):
        return repr(value)
    if isinstance(value, int):
        return str(value) if abs(value) < 10**18 else "a number beyond all bounds"
    if isinstance(value, str):
        return repr(value) if len(value) <= 40 else f"{value[:40]!r} and more"
    return "a list" if isinstance(value, list) else "an object"
