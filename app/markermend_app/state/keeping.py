"""What was found in a take, kept beside the store: it is there at once when the take is reopened.

One file per take and detector: JSON, and all numbers of the evidence in one array. It is made anew
when the code that finds is another.
"""

import hashlib
import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from markermend import __version__, detection
from markermend.model import Evidence, Finding, FloatArray

PLAIN = ("name", "start", "threshold", "usual", "unit")
ARRAYS = ("signal", "prediction", "template")
MOST_FILES = 400


def place(folder: Path, content_hash: str, **settings: Any) -> Path:
    """Give the file of a take's findings under these settings."""
    told = json.dumps([content_hash, settings, __version__, _code()], sort_keys=True)
    return folder / f"{hashlib.sha256(told.encode()).hexdigest()[:32]}.npz"


@cache
def _code() -> str:
    """Hash of everything that finds."""
    digest = hashlib.sha256()
    for path in sorted(Path(detection.__file__).parent.rglob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def keep(path: Path, findings: Sequence[Finding]) -> None:
    """Write findings with their evidence; the oldest files make room.

    Raises
    ------
    OSError
        If the disk refuses.
    """
    numbers: list[float] = []
    records = json.dumps([_record(finding, numbers) for finding in findings]).encode()
    path.parent.mkdir(parents=True, exist_ok=True)
    others = sorted(path.parent.glob("*.npz"), key=lambda p: p.stat().st_mtime)
    for old in others[: max(0, len(others) - MOST_FILES + 1)]:
        old.unlink(missing_ok=True)
    part = path.with_suffix(f".{os.getpid()}.tmp")
    with part.open("wb") as file:
        np.savez_compressed(
            file, numbers=np.array(numbers), records=np.frombuffer(records, np.uint8)
        )
    part.replace(path)


def kept(path: Path) -> tuple[Finding, ...] | None:
    """Read findings back, or None where there are none, or none that can be read."""
    try:
        with np.load(path, allow_pickle=False) as file:
            numbers, records = file["numbers"], json.loads(file["records"].tobytes())
        return tuple(_finding(record, numbers) for record in records)
    except (OSError, ValueError, KeyError, TypeError, EOFError, BadZipFile):
        return None


def _record(finding: Finding, numbers: list[float]) -> dict[str, Any]:
    # Not rounded as for other programs: the order of the queue depends on every digit.
    record = finding.to_json() | {
        name: getattr(finding, name) for name in ("score", "strength", "amplitude")
    }
    told = finding.evidence
    if told is not None:
        record["evidence"] = {name: getattr(told, name) for name in PLAIN}
        for name in ARRAYS:
            array = getattr(told, name)
            if array is not None:
                record["evidence"][name] = [len(numbers), *array.shape]
                numbers += array.ravel().tolist()
    return record


def _finding(record: Mapping[str, Any], numbers: FloatArray) -> Finding:
    finding = Finding.from_json(dict(record))
    told = record.get("evidence")
    if told is None:
        return finding
    arrays: dict[str, Any] = {}
    for name in ARRAYS:
        if name in told:
            begins, *shape = told[name]
            arrays[name] = numbers[begins : begins + int(np.prod(shape))].reshape(shape)
    return replace(finding, evidence=Evidence(**{name: told[name] for name in PLAIN}, **arrays))
