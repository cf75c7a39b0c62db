"""ezc3d in a process of its own, with a limit on time and memory.

ezc3d reads most C3D files, and on some it crashes, loops or reads beside the data. So it runs in a
child that is spawned, never forked, and what comes back is an opinion on the file, not the take.

Run as ``python -m markermend.io.second_reader FILE OUT.npz MEMORY_BYTES`` it is the child.
"""

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
    path, answer, memory = arguments
    if sys.platform != "win32":
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (int(memory), int(memory)))
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
