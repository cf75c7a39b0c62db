"""ezc3d in a process of its own, with a limit on time and memory.

ezc3d reads most C3D files, and on some it crashes, loops or reads beside the data. So it runs in a
child that is spawned, never forked, and what comes back is an opinion on the file, not the take.

Run as ``python -m markermend.io.second_reader FILE OUT.npz MEMORY_BYTES`` it is the child; without
arguments it is one that stays, and takes these three from each line of its input.
"""

import atexit
import contextlib
import json
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from markermend.model import FloatArray

TIME_LIMIT_S = 12.0
_S_PER_BYTE = 1 / 1.5e6
_MEMORY_BYTES = 1_500_000_000
_MEMORY_PER_BYTE = 30


@dataclass(frozen=True, eq=False)
class Opinion:
    """What ezc3d makes of a file.

    Attributes
    ----------
    positions
        (n_frames, n_points, 3) in the file's unit, NaN = not seen; None where it gave up.
    trouble
        Why it gave up, the end of a sentence that begins "ezc3d"; empty where it did not.
    """

    positions: FloatArray | None
    trouble: str = ""


def ask(path: Path, time_limit_s: float | None = None) -> Opinion:
    """Let ezc3d read a C3D file in a child process.

    Parameters
    ----------
    path
        The file.
    time_limit_s
        Seconds until the child is ended; by default `TIME_LIMIT_S`, and more for large files.
    """
    size = path.stat().st_size
    limit = TIME_LIMIT_S + size * _S_PER_BYTE if time_limit_s is None else time_limit_s
    memory = _MEMORY_BYTES + _MEMORY_PER_BYTE * size
    if _kept is not None:
        positions = _kept.ask(path, limit, memory)
        if positions is not None:
            return Opinion(positions)
    return _ask_alone(path, limit, memory)


def _ask_alone(path: Path, limit: float, memory: int) -> Opinion:
    """Let a child of its own read the file."""
    with tempfile.TemporaryDirectory(prefix="markermend-", ignore_cleanup_errors=True) as folder:
        answer = Path(folder) / "answer.npz"
        child = subprocess.Popen(
            [sys.executable, "-P", "-m", __name__, str(path.resolve()), str(answer), str(memory)],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            env=os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
        )
        try:
            trouble = _wait(child, limit, memory)
        finally:
            child.kill()
            child.wait()
        if trouble:
            return Opinion(None, trouble)
        if not answer.is_file():
            return Opinion(None, f"crashed on it (exit status {child.returncode})")
        with np.load(answer, allow_pickle=False) as stored:
            if "error" in stored:
                return Opinion(None, f"refused it ({stored['error']})")
            return Opinion(stored["positions"])


def keep_one() -> None:
    """From now on keep a child for many files, in a process that reads one after another.

    It is believed only where it has read a file: whatever trouble there is, a fresh child is asked
    and the kept one is replaced, so that opinions do not depend on what was read before.
    """
    global _kept
    if _kept is None:
        _kept = _Kept()
        atexit.register(_kept.close)


class _Kept:
    """A child that stays."""

    def __init__(self) -> None:
        self._child: subprocess.Popen[bytes] | None = None

    def ask(self, path: Path, limit_s: float, memory: int) -> FloatArray | None:
        """Give the positions, or None where there was any trouble."""
        with tempfile.TemporaryDirectory(
            prefix="markermend-", ignore_cleanup_errors=True
        ) as folder:
            answer = Path(folder) / "answer.npz"
            try:
                child = self._ready()
                assert child.stdin is not None
                asked = json.dumps([os.fspath(path.resolve()), str(answer), str(memory)])
                child.stdin.write(f"{asked}\n".encode())
                child.stdin.flush()
                if _appears(answer, child, limit_s, memory):
                    with np.load(answer, allow_pickle=False) as stored:
                        if "error" not in stored:
                            return np.asarray(stored["positions"])
            except OSError:
                pass  # it has ended
            self.close()
            return None

    def _ready(self) -> "subprocess.Popen[bytes]":
        if self._child is None:
            self._child = subprocess.Popen(
                [sys.executable, "-P", "-m", __name__],
                stdin=subprocess.PIPE,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                env=os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
            )
        return self._child

    def close(self) -> None:
        """End the child; the next file has a fresh one."""
        child, self._child = self._child, None
        if child is None:
            return
        child.kill()
        child.wait()
        if child.stdin is not None:
            with contextlib.suppress(OSError):  # what was not sent is not sent any more
                child.stdin.close()


_kept: _Kept | None = None


def _appears(answer: Path, child: "subprocess.Popen[bytes]", limit_s: float, memory: int) -> bool:
    """Wait until a child that stays has answered; false where it has to be ended, or has ended."""
    import psutil

    try:
        watched = psutil.Process(child.pid)
        end, pause = time.monotonic() + limit_s, 0.002
        while not answer.exists():
            if child.poll() is not None or time.monotonic() > end:
                return False
            if watched.memory_info().rss > memory:
                return False
            time.sleep(pause)
            pause = min(0.05, 1.3 * pause)
    except psutil.NoSuchProcess:
        return False
    return True


def _wait(child: subprocess.Popen[bytes], limit_s: float, memory: int) -> str:
    """Wait for the child; give the trouble if it has to be ended."""
    import psutil

    try:
        watched = psutil.Process(child.pid)
    except psutil.NoSuchProcess:
        return ""
    end = time.monotonic() + limit_s
    while True:
        try:
            child.wait(0.1)
        except subprocess.TimeoutExpired:
            pass
        else:
            return ""
        if time.monotonic() > end:
            return f"did not come to an end within {limit_s:.0f} s"
        try:
            if watched.memory_info().rss > memory:
                return f"asked for more than {memory / 1e9:.1f} GB of memory"
        except psutil.NoSuchProcess:
            return ""


def main(arguments: list[str]) -> None:
    """Read one file and write what was found; the child's part."""
    if not arguments:
        for line in sys.stdin:
            path, answer, memory = json.loads(line)
            draft = f"{answer}.part.npz"
            main([path, draft, memory])
            Path(draft).replace(answer)  # it is there whole or not at all
        return
    path, answer, memory = arguments
    if sys.platform != "win32":
        import resource

        _, most = resource.getrlimit(resource.RLIMIT_AS)
        resource.setrlimit(resource.RLIMIT_AS, (int(memory), most))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    import ezc3d

    try:
        positions = np.transpose(ezc3d.c3d(path)["data"]["points"][:3], (2, 1, 0))
    except MemoryError:
        np.savez(answer, error="not enough memory")
    except Exception as error:  # noqa: BLE001 - whatever it raises is its opinion
        np.savez(answer, error=" ".join(str(error).split())[:200])
    else:
        np.savez(answer, positions=positions)


if __name__ == "__main__":
    main(sys.argv[1:])
