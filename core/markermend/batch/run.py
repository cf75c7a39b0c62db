"""Run a batch: every take of a folder once, whatever happens to the run or to single takes.

A take is done when its result stands in the store, under the hash of its content and that of the
settings; files are written before that, each whole.  So a run that was ended anywhere is gone on
with by starting it again.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from markermend.batch import pool, records
from markermend.batch.hand import TIME_LIMIT_S
from markermend.batch.locks import MARK, alone
from markermend.batch.records import Line
from markermend.batch.settings import Settings
from markermend.batch.takes import content_hash, findings_names, takes_below
from markermend.batch.work import Result, Task, is_written
from markermend.errors import BadInput, CannotWrite
from markermend.io.disk import write_whole
from markermend.io.jsontext import json_text
from markermend.review.mending import decisions_path
from markermend.review.store import Store

SUMMARY = "summary.json"


@dataclass(frozen=True)
class Outcome:
    """How a batch ended.

    Attributes
    ----------
    lines
        All takes by name, with how each ended.
    resumed
        How many of them earlier runs had done.
    """

    lines: tuple[Line, ...]
    resumed: int

    def to_json(self) -> dict[str, Any]:
        """Give the content of ``summary.json``."""
        done = [line for line in self.lines if line.ended == "done"]
        return {
            "version": 1,
            "done": [line.name for line in done],
            "refused": self._reasons("refused"),
            "failed": self._reasons("failed"),
            "resumed": self.resumed,
            "takes": [
                {
                    "take": line.name,
                    **{key: line.summary[key] for key in _IN_SHORT if key in line.summary},
                }
                for line in done
            ],
        }

    def _reasons(self, ended: str) -> list[dict[str, str]]:
        return [
            {"take": line.name, "reason": line.reason} for line in self.lines if line.ended == ended
        ]


_IN_SHORT = ("rate", "n_frames", "n_findings", "damage", "n_repaired", "n_stays")


@dataclass(frozen=True)
class _Places:
    """Where everything of a run lies."""

    folder: Path
    out: Path | None
    repairs: bool
    findings: Mapping[str, str]

    def task(self, name: str, settings: Settings) -> Task:
        return Task(self.folder / name, name, settings, self.target(name))

    def target(self, name: str) -> Path | None:
        return self.out / name if self.out is not None and self.repairs else None

    def of_findings(self, name: str) -> Path | None:
        return None if self.out is None else self.out / self.findings[name]

    def written(self) -> Iterator[Path]:
        """Give everything that a run may write, but for the summary."""
        for name in self.findings:
            target, beside = self.target(name), self.of_findings(name)
            yield from (path for path in (target, beside) if path is not None)


def run(
    folder: Path,
    settings: Settings,
    store: Store,
    *,
    out: Path | None = None,
    jobs: int = 1,
    dask: str | None = None,
    limit_s: float = TIME_LIMIT_S,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Outcome:
    """Look at every take in a folder and the folders in it, and repair what the policy says.

    Parameters
    ----------
    folder
        The archive; nothing is written to it.
    settings
        What is asked of every take.
    store
        Where results are kept; what stands there already is not computed again.
    out
        Where ``NAME.findings.json`` of each take, repaired takes and ``summary.json`` go.
    jobs, dask, limit_s
        As in `markermend.batch.pool.results`; the results do not depend on them.
    progress
        Called with the number of takes that are through, and with that of all.

    Raises
    ------
    BadInput
        If there is nothing in the folder, another batch is at work there, repairs have nowhere to
        go, or the folder of results holds files of those names that no batch wrote.
    CannotWrite
        If the disk refuses; what was done until then is kept.
    """
    folder, out = folder.resolve(), None if out is None else out.resolve()
    if settings.policy is not None and out is None:
        raise BadInput("Repaired takes need a place to go; name a folder with --out.")
    if settings.policy is not None and out == folder:
        raise BadInput(
            f"{folder} holds the recordings, which are never replaced; choose another --out."
        )
    names = takes_below(folder, out)
    places = _Places(folder, out, settings.policy is not None, findings_names(names))
    if out is not None:
        _prepare(out, places)
    with alone(folder, out):
        archive = records.begin(store, folder, settings)
        known = _resume(places, settings, store)
        records.keep_known(store, archive, known)
        progress(len(known), len(names))
        tasks = [places.task(name, settings) for name in names if name not in known]
        through = pool.results(tasks, jobs=jobs, dask=dask, limit_s=limit_s)
        for n, result in enumerate(through, len(known) + 1):
            _publish(places, result)
            records.keep(store, archive, settings.key, result)
            progress(n, len(names))
        records.forget_others(store, archive, names)
        outcome = Outcome(records.lines(store, archive), len(known))
        if out is not None:
            text = json_text(outcome.to_json())
            write_whole(out / SUMMARY, text.encode("ascii"), overwrite=True)
    return outcome


def _prepare(out: Path, places: _Places) -> None:
    """Make the folder of results, or see that nothing of somebody else's would be replaced."""
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise CannotWrite(
            f"The folder {out} cannot be made: {error.strerror or error}; choose another --out."
        ) from None
    if (out / MARK).exists():
        return
    strange = next((path for path in (*places.written(), out / SUMMARY) if path.exists()), None)
    if strange is not None:
        raise BadInput(
            f"{strange} is there and no batch wrote it; choose an empty folder for --out."
        )


def _resume(places: _Places, settings: Settings, store: Store) -> dict[str, str]:
    """Find the takes that are done, and see that their files are there; name -> hash."""
    known = {}
    for name in places.findings:
        sha256 = content_hash(places.folder / name)
        scan = None if sha256 is None else records.scan_of(store, sha256, settings.key)
        if sha256 is None or scan is None:
            continue
        target = places.target(name)
        if target is not None and not (scan.repaired and is_written(scan.repaired, target)):
            continue
        _publish(places, Result(name, "done", sha256=sha256, findings=scan.findings))
        known[name] = sha256
    return known


def _publish(places: _Places, result: Result) -> None:
    """Bring the files of one take in line with how it ended."""
    path, target = places.of_findings(result.name), places.target(result.name)
    if path is None:
        return
    if result.ended == "done":
        record = {**result.findings, "take": Path(result.name).name}
        _write(path, json_text(record).encode("ascii"))
        return
    # What an earlier run made of another content would pass for this one's.
    stale = [path] if target is None else [path, target, decisions_path(target)]
    for one in stale:
        if one.is_file():
            one.unlink()


def _write(path: Path, data: bytes) -> None:
    if path.is_file() and path.read_bytes() == data:
        return
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise CannotWrite(
            f"{path.parent} cannot be made: {error.strerror or error}; choose another --out."
        ) from None
    write_whole(path, data, overwrite=True)
