"""A process beside the server that computes, so that the server has only to answer.

Requests of several threads are answered in the order in which they came, and a stream of results is
asked for step by step, so that nobody waits for longer than one step of somebody else. The process
ends when the server has ended, however that came about; when it crashes, another one is started
with the next request. Its own side is `markermend_app.state.apart`.
"""

import itertools
import os
import pickle
import shutil
import subprocess
import sys
import tempfile
import threading
import weakref
from collections.abc import Callable, Generator, Iterator
from concurrent.futures import Future
from contextlib import suppress
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import joblib

from markermend.errors import MarkerMendError
from markermend.model import Take

P = ParamSpec("P")
T = TypeVar("T")

_ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}


class WorkerEnded(MarkerMendError):
    """The process that computes is gone; the next request starts another one."""

    def __init__(self, code: int | None) -> None:
        super().__init__(
            f"The process that computes has ended (code {code}), perhaps for want of memory; "
            "go on, or choose this finding again: another one is started."
        )


class Worker:
    """The side that asks; any thread may."""

    def __init__(self) -> None:
        self._running: _Running | None = None
        self._lock = threading.Lock()
        self._lent: weakref.WeakKeyDictionary[Take, Path] = weakref.WeakKeyDictionary()
        self._folder: Path | None = None
        self._numbers = itertools.count(1)

    @property
    def pid(self) -> int | None:
        """Number of the process, if it runs."""
        running = self._running
        return running.process.pid if running is not None and running.alive else None

    def warm_up(self) -> None:
        """Start the process, unless it runs."""
        self._ready()

    def call(self, function: Callable[P, T], *given: P.args, **named: P.kwargs) -> T:
        """Let a function of a module be called there, and wait for what it gives.

        Raises
        ------
        MarkerMendError
            If it is refused, fails, or the process ends meanwhile (`WorkerEnded`).
        """
        answer: T = self._ready().ask("call", function, given, named).result()
        return answer

    def stream(
        self, function: Callable[P, Iterator[T]], *given: P.args, **named: P.kwargs
    ) -> Generator[T]:
        """Give what a generator gives there, one by one; nothing is computed ahead.

        Raises
        ------
        MarkerMendError
            As in `call`.
        """
        running = self._ready()
        stream = running.ask("begin", function, given, named).result()
        try:
            while True:
                more, value = running.ask("next", stream).result()
                if not more:
                    return
                yield value
        finally:
            running.ask("drop", stream)

    def lend(self, take: Take) -> Path:
        """Put a take where the process finds it; it is written the first time only."""
        with self._lock:
            path = self._lent.get(take)
            if path is None:
                if self._folder is None:
                    self._folder = Path(tempfile.mkdtemp(prefix="markermend-"))
                    weakref.finalize(self, shutil.rmtree, self._folder, ignore_errors=True)
                path = self._folder / f"{next(self._numbers)}.take"
                joblib.dump(take, path)
                self._lent[take] = path
                weakref.finalize(take, path.unlink, missing_ok=True)
            return path

    def end(self) -> None:
        """End the process, whatever it does; the next request starts another one."""
        running, self._running = self._running, None
        if running is not None:
            running.end()

    def _ready(self) -> "_Running":
        with self._lock:
            if self._running is None or not self._running.alive:
                self.end()
                self._running = _Running()
            return self._running


class _Running:
    """One process, and who waits for its answers."""

    def __init__(self) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-P", "-m", "markermend_app.state.apart"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env=os.environ | _ONE_THREAD,
            start_new_session=os.name == "posix",  # Ctrl+C is for the server
            creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
        )
        self._waiting: dict[int, Future[Any]] = {}
        self._keys = itertools.count(1)
        self._lock = threading.Lock()
        self._code: int | None = None
        self._ears = threading.Thread(target=self._listen, daemon=True, name="markermend-answers")
        self._ears.start()

    @property
    def alive(self) -> bool:
        return self._ears.is_alive() and self.process.poll() is None

    def ask(self, *message: Any) -> "Future[Any]":
        """Send a request; what it asks for, or why not, comes later."""
        future: Future[Any] = Future()
        data = pickle.dumps(message)
        with self._lock:
            if not self._ears.is_alive():
                future.set_exception(WorkerEnded(self._code))
                return future
            key = next(self._keys)
            self._waiting[key] = future
            with suppress(OSError, ValueError):  # whoever listens will hear that it has ended
                assert self.process.stdin is not None
                pickle.dump(key, self.process.stdin)
                self.process.stdin.write(data)
                self.process.stdin.flush()
        return future

    def end(self) -> None:
        self.process.kill()
        self._ears.join()

    def _listen(self) -> None:
        """Hand answers to those who wait for them, until there are no more."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        with suppress(OSError, EOFError, ValueError, pickle.UnpicklingError):
            while True:
                key, fault, value = pickle.load(self.process.stdout)
                future = self._waiting.pop(key)
                if fault is None:
                    future.set_result(value)
                else:
                    future.set_exception(MarkerMendError(fault))
        self.process.kill()
        self._code = self.process.wait()
        with self._lock:
            left, self._waiting = self._waiting, {}
            for pipe in (self.process.stdin, self.process.stdout):
                with suppress(OSError):
                    pipe.close()
        for future in left.values():
            future.set_exception(WorkerEnded(self._code))
