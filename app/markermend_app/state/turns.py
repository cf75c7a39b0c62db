"""Who may compute: in one process Python runs one thread at a time, and a page waits for its turn.

With many pages in a process, their comparisons would each take their share of the interpreter, and
the one thread that answers all pages would get as little as any of them. So comparisons take turns
among themselves, and hand the interpreter over often.
"""

import sys
import threading
from collections.abc import Iterable, Iterator
from typing import TypeVar

T = TypeVar("T")

AT_ONCE = 2
SWITCH_S = 0.001
"""How long a computing thread may keep an answering one waiting."""


class Turns:
    """How many threads of a process compute at once."""

    def __init__(self, at_once: int = AT_ONCE) -> None:
        self._free = threading.Semaphore(at_once)

    def narrow(self, at_once: int) -> None:
        """Let fewer compute at once; said before any page is there."""
        self._free = threading.Semaphore(at_once)

    def __enter__(self) -> None:
        self._free.acquire()

    def __exit__(self, *_: object) -> None:
        self._free.release()

    def each(self, rows: Iterable[T]) -> Iterator[T]:
        """Give rows that are computed as they are asked for, each in a turn of its own."""
        waiting = iter(rows)
        while True:
            with self:
                try:
                    row = next(waiting)
                except StopIteration:
                    return
            yield row


TURNS = Turns()


def answer_first() -> None:
    """Let a server with many pages answer before it computes."""
    sys.setswitchinterval(SWITCH_S)
    TURNS.narrow(1)
