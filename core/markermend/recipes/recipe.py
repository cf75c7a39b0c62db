"""A recipe: which detector looks how closely for what, and what may be repaired by which method."""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any, get_args

from markermend import detection
from markermend.batch.policy import Policy, policy_from_json
from markermend.batch.settings import Settings
from markermend.detection import DETECTORS
from markermend.detection.progress import Progress, unheard
from markermend.errors import BadInput, UnknownName
from markermend.io.disk import write_whole
from markermend.io.jsontext import json_text
from markermend.model import KINDS, Finding, Kind, Take
from markermend.params import checked
from markermend.review.records import Record

SCHEMA = "markermend/recipe"
LEAST, MOST = 0.1, 10.0
"""Bounds of a sensitivity: it divides the threshold of its kind."""
_MOST_BYTES = 1_000_000
_FIELDS = (
    "schema",
    "version",
    "detector",
    "parameters",
    "kinds",
    "sensitivity",
    "repair",
    "note",
)


@dataclass(frozen=True)
class Recipe:
    """How takes are looked at.

    Attributes
    ----------
    detector, parameters
        Name of the detector, and what of it is set otherwise than by default.
    kinds
        The kinds that are looked for.
    sensitivity
        By kind, 1 as designed, 2 for half the threshold; kinds that are not named have 1.
    policy
        What may be repaired and how, or None for nothing.
    note
        What it is for, in the words of whoever saved it.

    Raises
    ------
    UnknownName, BadParameter, BadInput
        If a name is unknown or a number is out of its bounds.
    """

    detector: str = detection.DEFAULT
    parameters: Mapping[str, Any] = field(default_factory=dict)
    kinds: tuple[Kind, ...] = KINDS
    sensitivity: Mapping[str, float] = field(default_factory=dict)
    policy: Policy | None = None
    note: str = ""

    def __post_init__(self) -> None:
        function = DETECTORS.get(self.detector).function
        known = checked(function, self.parameters)
        for kind in (*self.kinds, *self.sensitivity):
            if kind not in KINDS:
                raise UnknownName.among("kind", str(kind), KINDS)
        if not self.kinds:
            raise BadInput(f"A recipe looks for some of {', '.join(KINDS)}; got none of them.")
        for kind, factor in self.sensitivity.items():
            if not (math.isfinite(factor) and LEAST <= factor <= MOST):
                raise BadInput(
                    f"The sensitivity for {kind} must be in {LEAST:g} to {MOST:g}; got {factor!r}."
                )
        given = {name: known[name] for name in sorted(self.parameters)}
        object.__setattr__(self, "parameters", MappingProxyType(given))
        object.__setattr__(self, "sensitivity", MappingProxyType(dict(self.sensitivity)))

    def detect(self, take: Take, progress: Progress = unheard) -> tuple[Finding, ...]:
        """Find in a take what this recipe looks for; `progress` as for `detection.detect`."""
        return detection.detect(
            take,
            self.detector,
            kinds=self.kinds,
            sensitivity=self.sensitivity,
            progress=progress,
            **self.parameters,
        )

    def settings(self, *, repair: bool = False, **lacking: Any) -> Settings:
        """Give the settings of a batch after this recipe.

        Parameters
        ----------
        repair
            Whether what the recipe may repair is repaired.
        **lacking
            What files lack; see `Settings`.

        Raises
        ------
        BadInput
            If repairs are wanted and the recipe has none.
        """
        if repair and self.policy is None:
            raise BadInput("This recipe repairs nothing; say with --repair what is repaired.")
        return Settings(
            detector=self.detector,
            kinds=self.kinds,
            parameters=dict(self.parameters),
            sensitivity=dict(self.sensitivity),
            policy=self.policy if repair else None,
            **lacking,
        )

    def to_json(self) -> dict[str, Any]:
        """Give it as the content of a recipe file."""
        return {
            "schema": SCHEMA,
            "version": 1,
            "detector": self.detector,
            "parameters": dict(self.parameters),
            "kinds": list(self.kinds),
            "sensitivity": {k: self.sensitivity[k] for k in KINDS if k in self.sensitivity},
            "repair": None if self.policy is None else self.policy.to_json()["repair"],
            "note": self.note,
        }


def recipe_from_json(given: Any, where: str) -> Recipe:
    """Read a recipe; what it does not say is as by default, what nobody knows is refused.

    Parameters
    ----------
    given
        What stood in the file, whatever it is.
    where
        How to name it in a message.

    Raises
    ------
    BadInput
        If it is no recipe, or names an unknown kind, detector, method or parameter.
    """
    record = Record(given, where)
    record.one_of("schema", (SCHEMA,))
    if record.whole("version", 1, 1_000_000) != 1:
        raise BadInput(f"{where} was written by a newer version; update markermend.")
    for name in record.fields:
        if name not in _FIELDS:
            raise UnknownName.among(f"field of a recipe ({where})", str(name), _FIELDS)
    parameters = record.value("parameters", {})
    if not isinstance(parameters, dict):
        raise record.wrong("parameters", "an object", parameters)
    factors = record.value("sensitivity", {})
    if not isinstance(factors, dict):
        raise record.wrong("sensitivity", "an object with a number by kind", factors)
    by_kind = Record(factors, f"{where}: sensitivity")
    repair = record.value("repair", None)
    return Recipe(
        detector=record.text("detector", detection.DEFAULT),
        parameters=parameters,
        kinds=tuple(_kind(word) for word in record.texts("kinds", KINDS)),
        sensitivity={_kind(word): by_kind.number(word, LEAST, MOST) for word in factors},
        policy=None if repair is None else policy_from_json(repair, where),
        note=record.text("note", ""),
    )


def read_recipe(path: str | Path) -> Recipe:
    """Read the file of a recipe.

    Raises
    ------
    BadInput
        If it cannot be read or is no recipe.
    """
    path = Path(path)
    try:
        if path.stat().st_size > _MOST_BYTES:
            raise BadInput(f"{path} is too large for a recipe; give the file of a recipe.")
        given = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise BadInput(f"The recipe {path} cannot be read: {error.strerror or error}.") from None
    except (ValueError, RecursionError):
        raise BadInput(f"The recipe {path} is no JSON; write one with recipe show -o.") from None
    return recipe_from_json(given, f"The recipe {path.name}")


def write_recipe(recipe: Recipe, path: str | Path, *, overwrite: bool = False) -> None:
    """Write the file of a recipe, whole or not at all.

    Raises
    ------
    CannotWrite
        If the file exists or the disk refuses.
    """
    write_whole(Path(path), json_text(recipe.to_json()).encode(), overwrite=overwrite)


def _kind(word: str) -> Kind:
    for kind in get_args(Kind):
        if kind == word:
            return kind  # type: ignore[no-any-return]
    raise UnknownName.among("kind", word, KINDS)
