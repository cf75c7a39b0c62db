"""Parameters are said once, in the signature of a method; checks, help and widgets read them there.

A parameter is a keyword-only argument with a default, annotated with its bounds and unit::

    def savgol(problem, *, window: Annotated[int, Within(5, 501, "frames")] = 101): ...
"""

import inspect
import math
import typing
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

from markermend.errors import BadParameter, UnknownName


@dataclass(frozen=True)
class Within:
    """Inclusive bounds of a number, and its unit."""

    low: float
    high: float
    unit: str = ""

    def __str__(self) -> str:
        return f"{self.low:g} to {self.high:g} {self.unit}".rstrip()


@dataclass(frozen=True)
class OneOf:
    """The words that a parameter may be."""

    choices: tuple[str, ...]

    def __init__(self, *choices: str) -> None:
        object.__setattr__(self, "choices", choices)

    def __str__(self) -> str:
        return ", ".join(self.choices)


@dataclass(frozen=True)
class Parameter:
    """One tunable value of a method, as its signature and docstring give it."""

    name: str
    type: type
    default: Any
    bounds: Within | OneOf | None
    doc: str

    def check(self, value: Any) -> Any:
        """Return `value` in the parameter's type, or raise.

        Raises
        ------
        BadParameter
            If the value has the wrong type or lies outside the bounds.
        """
        try:
            converted = self._convert(value)
        except (TypeError, ValueError):
            raise BadParameter(f"{self.name} must be {self._wanted()}; got {value!r}.") from None
        inside = True
        if isinstance(self.bounds, Within):
            inside = math.isfinite(converted) and self.bounds.low <= converted <= self.bounds.high
        elif isinstance(self.bounds, OneOf):
            inside = converted in self.bounds.choices
        if not inside:
            raise BadParameter(f"{self.name} must be {self._wanted()}; got {value!r}.")
        return converted

    def _convert(self, value: Any) -> Any:
        if self.type is bool:
            words = {"true": True, "yes": True, "1": True, "false": False, "no": False, "0": False}
            if isinstance(value, str) and value.lower() in words:
                return words[value.lower()]
            if isinstance(value, bool):
                return value
            raise ValueError(value)
        if self.type is int and not isinstance(value, str) and int(value) != value:
            raise ValueError(value)
        return self.type(value)

    def _wanted(self) -> str:
        kind = {int: "a whole number", float: "a number", bool: "true or false"}.get(
            self.type, "one of"
        )
        return f"{kind} {'' if self.type in (str, bool) else 'in '}{self.bounds or ''}".rstrip()


@cache
def parameters_of(function: Callable[..., Any]) -> tuple[Parameter, ...]:
    """Read the keyword-only arguments of `function` as parameters."""
    hints = typing.get_type_hints(function, include_extras=True)
    docs = _documented(inspect.getdoc(function) or "")
    found = []
    for name, argument in inspect.signature(function).parameters.items():
        if argument.kind is not inspect.Parameter.KEYWORD_ONLY:
            continue
        hint, bounds = hints[name], None
        if typing.get_origin(hint) is typing.Annotated:
            hint, *extras = typing.get_args(hint)
            bounds = next((e for e in extras if isinstance(e, Within | OneOf)), None)
        found.append(Parameter(name, hint, argument.default, bounds, docs.get(name, "")))
    return tuple(found)


def checked(function: Callable[..., Any], given: Mapping[str, Any]) -> dict[str, Any]:
    """Check `given` against the parameters of `function` and complete it with the defaults.

    Raises
    ------
    UnknownName
        If `function` has no such parameter.
    BadParameter
        If a value lies outside its bounds.
    """
    known = {p.name: p for p in parameters_of(function)}
    for name in given:
        if name not in known:
            raise UnknownName.among(f"parameter of {function.__name__}", name, known)
    return {
        name: parameter.check(given[name]) if name in given else parameter.default
        for name, parameter in known.items()
    }


def _documented(docstring: str) -> dict[str, str]:
    """Take the descriptions out of a numpydoc *Parameters* section."""
    lines = docstring.splitlines()
    try:
        at = next(i for i, line in enumerate(lines) if line.strip() == "Parameters") + 2
    except StopIteration:
        return {}
    docs: dict[str, str] = {}
    names: list[str] = []
    for line in lines[at:]:
        if line and not line.startswith(" "):
            if set(line) == {"-"}:  # the next section's underline: its title was no parameter
                for name in names:
                    docs.pop(name, None)
                break
            names = [name.strip() for name in line.split(":")[0].split(",")]
            docs |= dict.fromkeys(names, "")
        elif line.strip():
            for name in names:
                docs[name] = f"{docs[name]} {line.strip()}".strip()
    return docs
