"""A process that works on one take after another, and may crash or hang without harm.

It is spawned, never forked; killing it ends what it started too. It ends by itself when whoever
started it is gone, however that ended, and when nobody has asked for anything for a while.

Run as ``python -m markermend.batch.hand`` it is that process: tasks come in by stdin, answers go
out by stdout, each as its length and its pickle.
"""

import faulthandler
import os
import pickle
import queue
import signal
import struct
import subprocess
import sys
import threading
from contextlib import suppress
from typing import IO

from markermend.batch.work import Result, Task, died, work
from markermend.io import second_reader

IDLE_S = 120.0
TIME_LIMIT_S = 1800.0
"""Nobody knows how fast the machine is, so this is long: it is for what never ends."""
_LENGTH = struct.Struct("<Q")
_BEGUN = "begun"
_TRIES = 3
_POSIX = os.name == "posix"


class Hand:
    """The side that asks.

    Parameters
    ----------
    limit_s
        Seconds after which the work on one take is ended.
    """

    def __init__(self, limit_s: float = TIME_LIMIT_S) -> None:
        self.limit_s = limit_s
        self._process: subprocess.Popen[bytes] | None = None
        self._closed = False

    def work(self, task: Task) -> Result:
        """Work on one take; if the process dies of it, the take has failed."""
        code: int | None = None
        for _ in range(_TRIES):
            process = self._ready()
            overdue = threading.Event()
            timer = threading.Timer(self.limit_s, _end_overdue, (process, overdue))
            timer.daemon = True
            timer.start()
            begun, result = _ask(process, task)
            timer.cancel()
            if result is not None:
                return result
            code = _ended(process)
            # One that ended while it had nothing to do is no fault of the take.
            if begun or overdue.is_set() or self._closed:
                return died(task, code, self.limit_s if overdue.is_set() else None)
        return Result(task.name, "failed", f"no process to work in can be started here ({code})")

    def close(self) -> None:
        """End the process, whatever it does; nothing is worked on after that."""
        self._closed = True
        if self._process is not None:
            _ended(self._process)

    def _ready(self) -> "subprocess.Popen[bytes]":
        if self._process is not None and self._process.poll() is not None:
            _ended(self._process)
            self._process = None
        if self._process is None:
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-m", __name__],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                env=os.environ | _ONE_THREAD,
                start_new_session=_POSIX,  # a group of its own, which is ended as one
            )
        return self._process


_ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
_of_this_thread = threading.local()


def work_apart(task: Task, limit_s: float = TIME_LIMIT_S) -> Result:
    """Work on one take in a process that belongs to this thread; for workers of a cluster."""
    hand: Hand | None = getattr(_of_this_thread, "hand", None)
    if hand is None:
        hand = _of_this_thread.hand = Hand()
    hand.limit_s = limit_s
    return hand.work(task)


def _ask(process: "subprocess.Popen[bytes]", task: Task) -> tuple[bool, Result | None]:
    """Send a task and wait; give whether it was begun, and the answer if there was one."""
    assert process.stdin is not None
    assert process.stdout is not None
    begun = False
    try:
        _send(process.stdin, task)
        begun = _receive(process.stdout) == _BEGUN
        answer = _receive(process.stdout)
    except (OSError, EOFError, ValueError, pickle.UnpicklingError):
        return begun, None
    return begun, answer if isinstance(answer, Result) else None


def _end_overdue(process: "subprocess.Popen[bytes]", overdue: threading.Event) -> None:
    overdue.set()
    _kill(process)


def _send(pipe: IO[bytes], what: object) -> None:
    data = pickle.dumps(what)
    pipe.write(_LENGTH.pack(len(data)) + data)
    pipe.flush()


def _receive(pipe: IO[bytes]) -> object:
    (length,) = _LENGTH.unpack(_exactly(pipe, _LENGTH.size))
    return pickle.loads(_exactly(pipe, length))


def _exactly(pipe: IO[bytes], n: int) -> bytes:
    data = pipe.read(n)
    if len(data) < n:
        raise EOFError
    return data


def _kill(process: "subprocess.Popen[bytes]") -> None:
    """End a process and what it started, also where it has died already."""
    if _POSIX:
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)
        return
    import psutil

    with suppress(psutil.NoSuchProcess):
        for child in psutil.Process(process.pid).children(recursive=True):
            with suppress(psutil.NoSuchProcess):
                child.kill()
    with suppress(OSError):
        process.kill()


def _ended(process: "subprocess.Popen[bytes]") -> int:
    """End a process and what it started, and give its exit status."""
    if process.returncode is None:
        _kill(process)
        process.wait()
    for pipe in (process.stdin, process.stdout):
        if pipe is not None:
            with suppress(OSError):  # what was not sent is not sent any more
                pipe.close()
    return process.returncode


def _end_with_group() -> None:
    """End this process and what it started, at once."""
    if _POSIX and os.getpgid(0) == os.getpid():
        os.killpg(0, signal.SIGKILL)
    os._exit(1)


def _listen(tasks: "queue.SimpleQueue[Task]") -> None:
    """Take tasks in; when nobody can send any more, end, whatever is being done."""
    try:
        while True:
            task = _receive(sys.stdin.buffer)
            assert isinstance(task, Task)
            tasks.put(task)
    finally:
        _end_with_group()


def main() -> None:
    """Work until nobody asks any more; the process's part."""
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a library prints is no answer
    faulthandler.enable()
    second_reader.keep_one()
    tasks: queue.SimpleQueue[Task] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(tasks,), daemon=True).start()
    while True:
        try:
            task = tasks.get(timeout=IDLE_S)
        except queue.Empty:
            os._exit(0)
        _send(answers, _BEGUN)
        _send(answers, work(task))


if __name__ == "__main__":
    main()
