"""What every component of the page that is written in JavaScript has in common."""

from collections.abc import Callable
from functools import wraps
from typing import Any, ParamSpec, TypeVar

from panel.custom import JSComponent
from panel.io import with_lock
from panel.io.document import unlocked

P = ParamSpec("P")
T = TypeVar("T")


def at_once(change: Callable[P, T]) -> Callable[P, T]:
    """Let all that a function changes reach the browser as one message.

    A message for each property costs as much as what it says, and the browser would draw a figure
    several times on the way from one finding to the next.
    """

    @wraps(change)
    def changed(*given: P.args, **named: P.kwargs) -> T:
        with unlocked():
            return change(*given, **named)

    return changed


class Component(JSComponent):
    """A component whose messages and changes are heard while the document is locked.

    Otherwise what is heard while the answer to something else is still being sent may not change
    the page: an intention of the operator would be lost.
    """

    __abstract = True

    @with_lock
    async def _event_coroutine(self, *given: Any) -> None:
        await super()._event_coroutine(*given)

    @with_lock
    async def _change_coroutine(self, *given: Any, **named: Any) -> None:
        await super()._change_coroutine(*given, **named)

    def _process_event(self, event: Any) -> None:
        at_once(super()._process_event)(event)

    def _process_events(self, events: dict[str, Any]) -> None:
        at_once(super()._process_events)(events)
