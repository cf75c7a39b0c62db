"""Exports that are interrupted: the old file or the new one, whole, and the source as it was.

Each case is a child that is forked, so that it can be killed or refused by the operating system
itself: SIGKILL at every step of the writing, SIGXFSZ in the middle of a write, a disk that takes
no further byte (RLIMIT_FSIZE), a disk that refuses a later step, and a folder that may not be
written by an unprivileged user.
"""

import errno
import os
import resource
import signal
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from tests.trust._frame import Budget, Outcome, Tally
from tests.trust._law import fault_of_sentence
from tests.trust._seeds import openpose, small_take

from markermend.errors import CannotWrite
from markermend.io import Reading, export, write
from markermend.io.format import format_of
from markermend.model import Span, Take
from markermend.review import Review
from markermend.review.decisions import decisions_on

MINUTES = 6.0
STEPS = {"open", "write", "flush", "fsync", "close", "replace", "chmod", "mkdir", "unlink"}
"""What of the writing the operating system sees; a case is killed before and after each."""
NOBODY = 65534
_THEN = datetime(2026, 1, 1, tzinfo=UTC)
Job = Callable[[Path], None]
"""Writes into a folder that holds the sources."""
Jobs = dict[str, tuple[Job, str, bool]]
"""What is written: by whom, to which name, and whether an old file may be there."""


def run(budget: Budget) -> Iterator[Outcome]:
    """Yield a row for each way of being interrupted."""
    jobs = _jobs()
    if budget.short:
        jobs = {"C3D patched": jobs["C3D patched"]}
    yield _killed(jobs, budget.share(0.7))
    yield _cut(jobs, budget)
    yield _refused(jobs, budget)
    yield _read_only(jobs)


def _jobs() -> Jobs:
    """Name what is written: by whom, to which name, and whether an old file may be there."""

    def patched(name: str) -> Job:
        def job(folder: Path) -> None:
            take = _read(folder / name)
            marker = take.labels[0]
            positions = take.positions.copy()
            positions[1:3, 0] += 1.0
            target = folder / f"out{Path(name).suffix}"
            export(take, take.with_positions(positions), target, [(marker, Span(1, 3))],
                   overwrite=True)  # fmt: skip

        return job

    def anew(folder: Path) -> None:
        write(small_take(40), folder / "out.npz", overwrite=True)

    def decided(folder: Path) -> None:
        decisions_on(small_take(), Review(), written=_THEN).write(folder / "out.json")

    return {
        "C3D patched": (patched("source.c3d"), "out.c3d", True),
        "TRC patched": (patched("source.trc"), "out.trc", True),
        "folder of JSON patched": (patched("source"), "out", False),
        "npz anew": (anew, "out.npz", True),
        "decisions": (decided, "out.json", True),
    }


def _read(path: Path) -> Take:
    contents = format_of(path).open(path, Reading(second_opinion=False))
    return contents.take(units=contents.units, rate=contents.rate or 100.0)


@contextmanager
def _desk() -> Iterator[Path]:
    """Give a folder with a source of every format."""
    with tempfile.TemporaryDirectory(prefix="markermend-disk-") as name:
        folder = Path(name)
        take = Take(np.random.default_rng(0).normal(0, 99, (400, 9, 3)), 100.0, "ABCDEFGHI")
        write(take, folder / "source.c3d")
        write(take, folder / "source.trc")
        (folder / "source").mkdir()
        for i in range(4):
            (folder / "source" / f"a_{i:04d}_keypoints.json").write_bytes(openpose(1, 25))
        yield folder


def _state(path: Path) -> dict[str, bytes] | bytes | None:
    """Give all that is at a place: a file, a folder, or nothing."""
    if path.is_dir():
        return {p.name: p.read_bytes() for p in sorted(path.iterdir())}
    return path.read_bytes() if path.exists() else None


def _in_a_child(act: Callable[[], None]) -> int:
    """Do it in a fork of this process; give the exit status, negative for a signal.

    0 is done, 1 a refusal in a sentence, 2 anything else.
    """
    pid = os.fork()
    if pid == 0:
        status = 2
        try:
            act()
            status = 0
        except CannotWrite as refusal:
            status = 1 if not fault_of_sentence(str(refusal)) else 3
        finally:
            os._exit(status)
    _, how = os.waitpid(pid, 0)
    return os.waitstatus_to_exitcode(how)


def _judge(
    tally: Tally, what: str, folder: Path, target: str, job: Job, child: Callable[[], None],
    whole: object, old: object, statuses: tuple[int, ...],
) -> int:  # fmt: skip
    """Run one interrupted writing, and check what is on the disk after it."""
    for path in folder.iterdir():
        if path.name == target or path.name.endswith(".part"):
            _remove(path)
    if isinstance(old, bytes):
        (folder / target).write_bytes(old)
    sources = {p: _state(p) for p in folder.iterdir() if p.name.startswith("source")}
    status = _in_a_child(child)
    found = _state(folder / target)
    if any(_state(path) != content for path, content in sources.items()):
        tally.case(f"{what}: the source changed", lost=True)
    elif found != old and found != whole:
        tally.case(f"{what}: neither the old file nor the new one", lost=True)
    elif status not in statuses:
        tally.case(f"{what}: ended with {status}")
    elif status == 0 and found != whole:
        tally.case(f"{what}: said done and was not", lost=True)
    elif status >= 0 and any(p.name.endswith(".part") for p in folder.iterdir()):
        tally.case(f"{what}: something is left behind")
    else:
        tally.case()
    return status


def _remove(path: Path) -> None:
    if path.is_dir():
        for inner in path.iterdir():
            inner.unlink()
        path.rmdir()
    else:
        path.unlink()


def _each(jobs: Jobs) -> Iterator[tuple[str, Path, str, Job, object, object]]:
    """Yield every job with an old file at its target and without, and what it should write."""
    for name, (job, target, replaces) in jobs.items():
        with _desk() as folder:
            job(folder)
            whole = _state(folder / target)
            _remove(folder / target)
            for old in (None, b"the old file") if replaces else (None,):
                yield name, folder, target, job, whole, old


def _killed(jobs: Jobs, budget: Budget) -> Outcome:
    tally = Tally("exports killed (SIGKILL) at every step: old or new, whole")
    for name, folder, target, job, whole, old in _each(jobs):
        step = 0
        while True:
            step += 1

            def child(step: int = step, job: Job = job, folder: Path = folder) -> None:
                seen = 0

                def look(_frame: object, event: str, what: object) -> None:
                    nonlocal seen
                    if event in ("c_call", "c_return") and _name(what) in STEPS:
                        seen += 1
                        if seen == step:
                            os.kill(os.getpid(), signal.SIGKILL)

                sys.setprofile(look)
                job(folder)
                sys.setprofile(None)

            said = f"{name}, step {step}"
            statuses = (0, -signal.SIGKILL)
            if _judge(tally, said, folder, target, job, child, whole, old, statuses) == 0:
                break
            if budget.spent or step > 2000:
                break
    return tally.outcome("before and after each call that the disk sees")


def _name(what: object) -> str:
    name = getattr(what, "__name__", "")
    return "replace" if name == "rename" else name


def _cut(jobs: Jobs, budget: Budget) -> Outcome:
    tally = Tally("exports on a full disk, refused or killed in mid-write")
    rng = np.random.default_rng(budget.seed)
    for name, folder, target, job, whole, old in _each(jobs):
        sizes = [len(x) for x in whole.values()] if isinstance(whole, dict) else [len(whole)]  # type: ignore[arg-type]
        most = max(sizes)
        places = {0, 1, most - 1, *rng.integers(0, most, budget.of(25, 2)).tolist()}
        for place in sorted(places):
            if budget.spent:
                break
            for action, statuses in ((signal.SIG_IGN, (1,)), (signal.SIG_DFL, (-signal.SIGXFSZ,))):

                def child(place=place, action=action, job=job, folder=folder) -> None:
                    signal.signal(signal.SIGXFSZ, action)
                    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
                    resource.setrlimit(resource.RLIMIT_FSIZE, (place, resource.RLIM_INFINITY))
                    job(folder)

                said = f"{name}, byte {place} of {most}"
                _judge(tally, said, folder, target, job, child, whole, old, statuses)
    return tally.outcome()


def _refused(jobs: Jobs, budget: Budget) -> Outcome:
    """Let the disk refuse one later step: fsync, rename, chmod, mkdir, with every likely error."""
    tally = Tally("exports of which the disk refuses a step (ENOSPC, EIO, EACCES)")
    codes = (errno.ENOSPC, errno.EIO, errno.EACCES, errno.EDQUOT, errno.EROFS)
    for name, folder, target, job, whole, old in _each(jobs):
        for step in ("fsync", "replace", "chmod", "mkdir", "open"):
            for code in codes[: budget.of(len(codes), 1)]:

                def child(step=step, code=code, job=job, folder=folder) -> None:
                    real = getattr(os, step)

                    def refuse(*given: object, **more: object) -> object:
                        if step == "open" and not str(given[0]).startswith(str(folder)):
                            return real(*given, **more)
                        raise OSError(code, os.strerror(code))

                    setattr(os, step, refuse)
                    job(folder)

                # A step that this job never takes is no refusal; after the rename it is too late
                # to take anything back, and the new file is whole.
                said = f"{name}, {step} says {errno.errorcode[code]}"
                _judge(tally, said, folder, target, job, child, whole, old, (0, 1))
    return tally.outcome()


def _read_only(jobs: Jobs) -> Outcome:
    tally = Tally("exports into a folder that may not be written")
    for name, folder, target, job, whole, old in _each(jobs):
        folder.chmod(0o555)

        def child(job: Job = job, folder: Path = folder) -> None:
            if os.getuid() == 0:
                os.setgroups([])
                os.setgid(NOBODY)
                os.setuid(NOBODY)
            job(folder)

        try:
            if isinstance(old, bytes):
                continue  # an old file in such a folder is the same case
            _judge(tally, name, folder, target, job, child, whole, old, (1,))
        finally:
            folder.chmod(0o755)
    return tally.outcome()
