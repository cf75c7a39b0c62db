"""Compute once what several methods ask of the same problem."""

from collections.abc import Callable
from functools import wraps
from typing import Concatenate, ParamSpec, TypeVar

Thing = TypeVar("Thing")
P = ParamSpec("P")
Result = TypeVar("Result")


def remembered(
    function: Callable[Concatenate[Thing, P], Result],
) -> Callable[Concatenate[Thing, P], Result]:
    """Remember the results of a pure function with the frozen object that is its first argument.

    As with a cached property they live as long as the object. The other arguments must be
    hashable, and nobody may write into a result.
    """
    name = f"_{function.__module__}.{function.__qualname__}"

    @wraps(function)
    def of(thing: Thing, /, *args: P.args, **kwargs: P.kwargs) -> Result:
        known = vars(thing).setdefault(name, {})
        asked = (args, tuple(sorted(kwargs.items())))
        if asked not in known:
            known[asked] = function(thing, *args, **kwargs)
        result: Result = known[asked]
        return result

    return of
