"""Methods are found, not listed: one file in a folder, or an entry point of another package.

A file ``linear.py`` in the folder holds a function ``linear`` under `method`; its name is the
name of the method. Another distribution registers a function of its own with an entry point in
the registry's group. Nothing else has to be edited: titles, parameters, help, widgets and
contract tests are read from the function.
"""

import importlib
import pkgutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from importlib.metadata import EntryPoint, entry_points
from typing import Any, TypeVar

from markermend.errors import MarkerMendError, UnknownName
from markermend.params import Parameter, checked, parameters_of

F = TypeVar("F", bound=Callable[..., Any])
_MARK = "__markermend_method__"


@dataclass(frozen=True)
class Method:
    """A registered function with what screens and documents say of it."""

    function: Callable[..., Any]
    title: str
    kinds: tuple[str, ...]
    source: str

    @property
    def name(self) -> str:
        """Name in the API, on the command line and in decision files."""
        return self.function.__name__

    @property
    def summary(self) -> str:
        """First line of the docstring."""
        return (self.function.__doc__ or "").strip().split("\n")[0]

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The keyword-only arguments, with bounds and units."""
        return parameters_of(self.function)

    def __call__(self, *arguments: Any, **parameters: Any) -> Any:
        """Call the function with checked parameters."""
        return self.function(*arguments, **checked(self.function, parameters))


def method(*, title: str, kinds: tuple[str, ...], source: str) -> Callable[[F], F]:
    """Mark a function as a method.

    Parameters
    ----------
    title
        What the operator reads.
    kinds
        The kinds of finding that it detects, or that it is meant to repair.
    source
        The paper and equation, or the library, that it follows.
    """

    def mark(function: F) -> F:
        setattr(function, _MARK, Method(function, title, kinds, source))
        return function

    return mark


class Registry:
    """The methods of one sort, imported one by one when asked for.

    Parameters
    ----------
    what
        The word for one of them, for messages.
    package
        Import name of the folder.
    group
        Entry-point group by which other distributions add theirs.
    """

    def __init__(self, what: str, package: str, group: str) -> None:
        self.what, self.package, self.group = what, package, group

    @cached_property
    def _own(self) -> tuple[str, ...]:
        folder = importlib.import_module(self.package)
        found = (module.name for module in pkgutil.iter_modules(folder.__path__))
        return tuple(sorted(name for name in found if not name.startswith("_")))

    @cached_property
    def _foreign(self) -> dict[str, EntryPoint]:
        return {e.name: e for e in entry_points(group=self.group) if e.name not in self._own}

    def names(self) -> tuple[str, ...]:
        """All names; imports none of the methods."""
        return (*self._own, *sorted(self._foreign))

    def get(self, name: str) -> Method:
        """Import and return one method.

        Raises
        ------
        UnknownName
            If no file and no entry point has this name.
        MarkerMendError
            If what is found there is not a method.
        """
        if name in self._own:
            found = getattr(importlib.import_module(f"{self.package}.{name}"), name, None)
        elif name in self._foreign:
            found = self._foreign[name].load()
        else:
            raise UnknownName.among(self.what, name, self.names())
        marked = getattr(found, _MARK, None)
        if not isinstance(marked, Method) or marked.name != name:
            raise MarkerMendError(
                f"{self.what} {name!r} is no function of that name under @method; mark it so."
            )
        return marked

    def __iter__(self) -> Iterator[Method]:
        return (self.get(name) for name in self.names())
