"""The process that computes: ``python -m markermend_app.state.apart``, see `worker`.

What is asked for comes in by stdin, answers go out by stdout, both as pickles.
"""

import os
import pickle
import queue
import shutil
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from typing import IO, Any

from markermend.errors import MarkerMendError
from markermend_app.state.computing import FOLDERS
from markermend_app.state.memory import give_back, keep_little

PRIORITY = 5
"""Nicer than the server by so much: an answer to the operator comes first."""


class Streams:
    """What is being asked for step by step."""

    def __init__(self) -> None:
        self._open: dict[int, Iterator[Any]] = {}
        self._number = 0

    def call(self, function: Callable[..., Any], given: Any, named: Mapping[str, Any]) -> Any:
        """Call a function."""
        return function(*given, **named)

    def begin(self, function: Callable[..., Any], given: Any, named: Mapping[str, Any]) -> int:
        """Make a generator; nothing is computed yet."""
        self._number += 1
        self._open[self._number] = iter(function(*given, **named))
        return self._number

    def next(self, number: int) -> tuple[bool, Any]:
        """Give whether there was one more, and it."""
        for value in self._open[number]:
            return True, value
        return False, None

    def drop(self, number: int) -> None:
        """Forget a generator, and give back the memory that it took."""
        self._open.pop(number, None)
        give_back()


def _hear(requests: "queue.SimpleQueue[tuple[int, Any]]", source: IO[bytes]) -> None:
    """Take requests in; when nobody can send any more, end, whatever is being done."""
    try:
        while True:
            key, message = pickle.load(source), pickle.load(source)
            requests.put((key, message))
    except EOFError:
        pass  # the server has ended
    except Exception:  # noqa: BLE001  what cannot be read cannot be answered
        sys.excepthook(*sys.exc_info())
    finally:
        for folder in FOLDERS:  # a server that was killed has not cleared up
            shutil.rmtree(folder, ignore_errors=True)
        os._exit(0)


def main() -> None:
    """Answer until nobody asks any more."""
    keep_little()
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a library prints is no answer
    if hasattr(os, "nice"):
        os.nice(PRIORITY)
    requests: queue.SimpleQueue[tuple[int, Any]] = queue.SimpleQueue()
    threading.Thread(target=_hear, args=(requests, sys.stdin.buffer), daemon=True).start()
    streams = Streams()
    while True:
        key, (what, *given) = requests.get()
        fault: str | None = None
        value = None
        try:
            value = getattr(streams, what)(*given)
        except MarkerMendError as refusal:
            fault = str(refusal)
        except Exception:  # noqa: BLE001  the server says it in a sentence
            sys.excepthook(*sys.exc_info())
            fault = "That failed inside MarkerMend; the log says why."
        pickle.dump((key, fault, value), answers)
        answers.flush()


if __name__ == "__main__":
    main()
