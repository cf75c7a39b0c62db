"""What every component of the page that is written in JavaScript has in common."""

from typing import Any

from panel.custom import JSComponent
from panel.io import with_lock


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
