"""What can go wrong, as one tree; every message is one sentence with a way out.

::

    MarkerMendError
    ├── BadInput                what was handed in cannot be used as it is
    │   ├── UnreadableTake      the file is no take, is broken, or is beyond a limit
    │   ├── Lacking             the file does not say its unit or its rate
    │   ├── UnknownName         no such marker, method, detector, kind or parameter
    │   ├── BadParameter        a value outside its bounds
    │   └── BadDecisions        a decision file that does not fit
    ├── CannotRepair            a method does not apply to this span
    ├── CannotWrite             the export would not be faithful, or the disk refused
    └── StoreError              the store of reviews cannot be used
        ├── Unreachable         the database does not answer
        ├── Taken               somebody else is at this review
        └── Conflict            somebody else wrote first

Messages follow one grammar: what is wrong, with the value that was given, then what would help.
"""

import unicodedata
from collections.abc import Iterable, Sequence
from typing import Any

_MOST_NAMES, _LONGEST_NAME = 60, 100
_SPACES = {"Cc", "Zl", "Zp"}
"""Categories of Unicode of what moves the pen: tabs, line ends, terminal codes."""


def legible(text: str) -> str:
    """Give a text without what cannot be seen, for it may come from a file of anybody's.

    Control characters and line ends become spaces; marks that turn the direction of writing or
    have no width vanish; halves of surrogate pairs become U+FFFD. Letters of every script stay.
    """
    if text.isprintable():
        return text
    return "".join(map(_legible, text))


def _legible(character: str) -> str:
    category = unicodedata.category(character)
    if category in _SPACES:
        return " "
    return {"Cf": "", "Cs": "\N{REPLACEMENT CHARACTER}"}.get(category, character)


class MarkerMendError(Exception):
    """Base of all errors that MarkerMend raises on purpose.

    A message may quote a file or its name; whatever in it cannot be seen is left out.
    """

    def __init__(self, message: str = "") -> None:
        super().__init__(legible(message))

    def __reduce__(self) -> tuple[Any, ...]:
        """Let it come out of another process with all that it carries."""
        return _again, (type(self), self.args, vars(self))


def _again(
    kind: type[MarkerMendError], arguments: tuple[Any, ...], carried: dict[str, Any]
) -> MarkerMendError:
    error = kind.__new__(kind, *arguments)
    vars(error).update(carried)
    return error


class BadInput(MarkerMendError, ValueError):
    """What was handed in cannot be used as it is."""


class UnreadableTake(BadInput):
    """The file is no take, is broken, or is beyond a limit."""


class Lacking(BadInput):
    """The file does not say something that is needed.

    Attributes
    ----------
    what
        ``"units"`` or ``"rate"``: the argument of `markermend.read` that supplies it.
    """

    def __init__(self, message: str, what: str) -> None:
        super().__init__(message)
        self.what = what


class UnknownName(BadInput):
    """No such marker, method, detector, kind or parameter."""

    @classmethod
    def among(cls, what: str, given: str, known: Iterable[str]) -> "UnknownName":
        """Say which names would have been right."""
        names = list(known)
        said = ", ".join(names[:_MOST_NAMES]) or "none"
        if len(names) > _MOST_NAMES:
            said += f" and {len(names) - _MOST_NAMES} more"
        return cls(f"There is no {what} {given[:_LONGEST_NAME]!r}; known are {said}.")


class BadParameter(BadInput):
    """A value outside its bounds."""


class BadDecisions(BadInput):
    """A decision file that does not fit."""


class CannotRepair(MarkerMendError):
    """A method does not apply to this span; the message says why."""


class CannotWrite(MarkerMendError):
    """The export would not be faithful, or the disk refused."""


class StoreError(MarkerMendError):
    """The store of reviews cannot be used."""


class Unreachable(StoreError):
    """The database does not answer; whether it got the last write is not known."""


class Taken(StoreError):
    """Somebody else is at this review; nothing of ours was written.

    Attributes
    ----------
    by
        Name of that person.
    """

    def __init__(self, message: str, by: str) -> None:
        super().__init__(message)
        self.by = by


class Conflict(StoreError):
    """Somebody else wrote to the same review first; nothing of ours was written.

    Attributes
    ----------
    mine
        The commands that were not written, or empty where the store alone was asked.
    theirs
        What was done in between: lines of the journal.
    """

    def __init__(
        self, message: str, mine: Sequence[object] = (), theirs: Sequence[object] = ()
    ) -> None:
        super().__init__(message)
        self.mine, self.theirs = tuple(mine), tuple(theirs)
