"""What is done to one take of an archive: a function of the file and the settings alone."""

import hashlib
import shutil
import signal
from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from traceback import extract_tb
from typing import Any, Literal

from markermend import __version__, detection, io
from markermend.batch.policy import Policy, mend_by
from markermend.batch.settings import Settings
from markermend.detection.record import detection_record
from markermend.errors import CannotWrite, MarkerMendError
from markermend.io.disk import load
from markermend.io.jsontext import encodable
from markermend.model import KINDS, Finding, Take, short
from markermend.review.mending import decisions_path, save
from markermend.review.queue import damage

Ended = Literal["done", "refused", "failed"]


@dataclass(frozen=True)
class Task:
    """One take to be worked on.

    Attributes
    ----------
    path, name
        The file, and its path relative to the archive.
    settings
        What is asked of it.
    target
        Where the repaired take goes; None where nothing is repaired.
    version
        Of the program that asks.
    """

    path: Path
    name: str
    settings: Settings
    target: Path | None = None
    version: str = __version__


@dataclass(frozen=True)
class Result:
    """How one take ended.

    Attributes
    ----------
    name
        As in the task.
    ended, reason
        Done; refused, for a reason that the file gives; or failed, by a fault that is not its own.
    sha256
        Hash of the content that was worked on, or None where it was not done.
    findings
        The record of the detection, as ``markermend detect --json`` prints it.
    summary
        What an overview of the archive needs of it; see `summarise`.
    repaired
        What was written to the target, or None where nothing is repaired.
    """

    name: str
    ended: Ended
    reason: str = ""
    sha256: str | None = None
    findings: Mapping[str, Any] = field(default_factory=dict)
    summary: Mapping[str, Any] = field(default_factory=dict)
    repaired: Mapping[str, Any] | None = None


def work(task: Task) -> Result:
    """Detect, repair where a policy says so, and say how it ended; raises nothing."""
    try:
        if task.version != __version__:
            reason = (
                f"this worker has markermend {__version__}, and {task.version} asks; install the "
                "same version everywhere"
            )
            return Result(task.name, "failed", reason)
        return _work(task)
    except CannotWrite as error:
        # A full disk is no property of the take: the next run tries again.
        broken_disk = isinstance(error.__context__, OSError)
        return Result(task.name, "failed" if broken_disk else "refused", str(error))
    except MarkerMendError as error:
        return Result(task.name, "refused", str(error))
    except Exception as error:  # noqa: BLE001  one bad take never stops the others
        return Result(task.name, "failed", _fault(error))


def _work(task: Task) -> Result:
    asked = task.settings
    take = io.read(
        task.path,
        units=asked.units,
        rate=asked.rate,
        ignore_residuals=asked.ignore_residuals,
    )
    wanted = {*asked.kinds, *(asked.policy.kinds if asked.policy else ())}
    found = detection.detect(
        take,
        asked.detector,
        kinds=[k for k in KINDS if k in wanted],
        sensitivity=asked.sensitivity,
        **asked.parameters,
    )
    listed = [f for f in found if f.kind in asked.kinds]
    repaired = None
    if asked.policy is not None and task.target is not None:
        repaired = _repair(take, found, asked.policy, task.target)
    record = encodable(detection_record(take, task.path.name, listed))
    summary = summarise(take, listed)
    if repaired is not None:
        summary |= {"n_repaired": repaired["n_repaired"], "n_stays": len(repaired["stays"])}
    return Result(
        task.name,
        "done",
        sha256=take.content_hash,
        findings=record,
        summary=encodable(summary),
        repaired=repaired,
    )


def _repair(take: Take, found: Iterable[Finding], policy: Policy, target: Path) -> dict[str, Any]:
    review, mended, stays = mend_by(policy, take, tuple(found))
    target.parent.mkdir(parents=True, exist_ok=True)
    if target.is_dir():  # an earlier run's, as everything is below the folder of results
        shutil.rmtree(target)
    written, beside = save(mended, review, target, overwrite=True)
    return {
        "sha256": written.sha256,
        "decisions_sha256": hashlib.sha256(beside.read_bytes()).hexdigest(),
        "mode": written.mode,
        "n_repaired": len(mended.repairs),
        "n_changed": written.n_changed,
        "stays": encodable([stay.to_json() for stay in stays]),
    }


def summarise(take: Take, findings: Iterable[Finding]) -> dict[str, Any]:
    """Give what an overview of an archive needs of a take.

    Returns
    -------
    ``rate`` (Hz), ``n_frames``, ``duration_s``, ``markers`` (the measured ones, without their
    subjects), ``n_findings``, ``damage`` (the sum of `markermend.review.queue.damage`, mm s) and
    ``by``: marker -> kind -> [number, damage].  Gaps at the ends of the take, where a marker was
    outside the volume, are counted and do no damage.
    """
    by: dict[str, dict[str, list[float]]] = defaultdict(dict)
    n = 0
    for finding in findings:
        n += 1
        outside = finding.span.start == 0 or finding.span.stop == take.n_frames
        size = 0.0 if finding.kind == "gap" and outside else damage(finding, take.rate)
        cell = by[short(finding.marker)].setdefault(finding.kind, [0, 0.0])
        cell[0] += 1
        cell[1] = round(cell[1] + size, 6)
    return {
        "rate": take.rate,
        "n_frames": take.n_frames,
        "duration_s": round(take.duration_s, 6),
        "markers": list(dict.fromkeys(short(take.labels[int(m)]) for m in take.measured)),
        "n_findings": n,
        "damage": round(sum(size for row in by.values() for _, size in row.values()), 6),
        "by": dict(by),
    }


def is_written(result: Mapping[str, Any], target: Path) -> bool:
    """Whether a repaired take and its decisions are on the disk as they were written."""
    try:
        found = hashlib.sha256(load(target)).hexdigest()
        beside = hashlib.sha256(decisions_path(target).read_bytes()).hexdigest()
    except (OSError, MarkerMendError):
        return False
    return (found, beside) == (result["sha256"], result["decisions_sha256"])


def died(task: Task, code: int | None, limit_s: float | None) -> Result:
    """Say how a take ended whose process came to an end without an answer.

    Parameters
    ----------
    code
        Exit status of the process, negative for a signal.
    limit_s
        The time limit, where it was ended for that.
    """
    if limit_s is not None:
        return Result(task.name, "failed", f"it took longer than {limit_s:g} s and was ended")
    how = f"exit status {code}"
    if code is not None and code < 0:
        names = {one.value: one.name for one in signal.Signals}
        how = names.get(-code, f"signal {-code}")
    return Result(task.name, "failed", f"the process that worked on it died ({how})")


def _fault(error: Exception) -> str:
    frames = extract_tb(error.__traceback__)
    where = f" in {Path(frames[-1].filename).name}, line {frames[-1].lineno}" if frames else ""
    said = " ".join(str(error).split())[:300]
    return f"{type(error).__name__}: {said}{where}; this is a fault of markermend, please report it"
