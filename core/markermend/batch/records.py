"""Archives in the store: what was found in which content, and how each take of a folder ended."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from sqlalchemy import Connection, delete, insert, select, update

from markermend.batch.settings import Settings
from markermend.batch.work import Ended, Result
from markermend.review.schema import archive_takes, archives, scans
from markermend.review.store import Store, storable

_AT_ONCE = 500


@dataclass(frozen=True)
class Scan:
    """What was found in one content under one set of settings."""

    findings: Mapping[str, Any]
    summary: Mapping[str, Any]
    repaired: Mapping[str, Any] | None


@dataclass(frozen=True)
class Line:
    """One take of an archive: how it ended, and in short what was found.

    ``name`` is its path relative to the archive, ``summary`` that of `work.summarise`, empty where
    the take is not done.
    """

    name: str
    ended: Ended
    reason: str
    summary: Mapping[str, Any]


@dataclass(frozen=True)
class Archive:
    """A folder that was looked at: with which settings, and when that was begun."""

    id: int
    settings: Mapping[str, Any]
    begun: datetime


def begin(store: Store, folder: Path, settings: Settings) -> int:
    """Note that an archive is looked at, and give its number."""
    where = storable(folder)
    same = (archives.c.folder == where) & (archives.c.settings == settings.key)
    now = datetime.now(UTC)
    with store.transaction() as connection:
        found = connection.scalar(select(archives.c.id).where(same))
        if found is not None:
            connection.execute(update(archives).where(same).values(begun=now))
            return int(found)
        done = connection.execute(
            insert(archives).values(
                folder=where, settings=settings.key, content=settings.to_json(), begun=now
            )
        )
        assert done.inserted_primary_key is not None
        return int(done.inserted_primary_key[0])


def scan_of(store: Store, sha256: str, key: str) -> Scan | None:
    """Give what was found in a content before, or None."""
    query = select(scans.c.findings, scans.c.summary, scans.c.repaired).where(
        scans.c.take == sha256, scans.c.settings == key
    )
    rows = store.rows(query)
    return Scan(rows[0].findings, rows[0].summary, rows[0].repaired) if rows else None


def keep(store: Store, archive: int, key: str, result: Result) -> None:
    """Put down how a take ended, whole, on disk when this returns."""
    with store.transaction() as connection:
        if result.ended == "done":
            assert result.sha256 is not None
            this = (scans.c.take == result.sha256) & (scans.c.settings == key)
            connection.execute(delete(scans).where(this))
            connection.execute(
                insert(scans).values(
                    take=result.sha256,
                    settings=key,
                    at=datetime.now(UTC),
                    summary=result.summary,
                    findings=result.findings,
                    repaired=result.repaired,
                )
            )
        _put_line(connection, archive, result.name, result.sha256, result.ended, result.reason)


def keep_known(store: Store, archive: int, known: Mapping[str, str]) -> None:
    """Put down takes of which everything is known already: name -> hash of the content."""
    with store.transaction() as connection:
        for name, sha256 in known.items():
            _put_line(connection, archive, name, sha256, "done", "")


def _put_line(
    connection: Connection, archive: int, name: str, sha256: str | None, ended: Ended, reason: str
) -> None:
    name = storable(name)
    place = (archive_takes.c.archive == archive) & (archive_takes.c.name == name)
    connection.execute(delete(archive_takes).where(place))
    connection.execute(
        insert(archive_takes).values(
            archive=archive, name=name, take=sha256, status=ended, reason=storable(reason)
        )
    )


def forget_others(store: Store, archive: int, names: Iterable[str]) -> None:
    """Take those out of an archive that no longer lie in its folder."""
    kept = {storable(name) for name in names}
    query = select(archive_takes.c.name).where(archive_takes.c.archive == archive)
    gone = [row.name for row in store.rows(query) if row.name not in kept]
    with store.transaction() as connection:
        for i in range(0, len(gone), _AT_ONCE):
            some = archive_takes.c.name.in_(gone[i : i + _AT_ONCE])
            connection.execute(
                delete(archive_takes).where(archive_takes.c.archive == archive, some)
            )


def latest(store: Store, folder: Path) -> Archive | None:
    """Give the archive that was last looked at in a folder, or None."""
    query = (
        select(archives.c.id, archives.c.content, archives.c.begun)
        .where(archives.c.folder == storable(folder))
        .order_by(archives.c.begun.desc(), archives.c.id.desc())
        .limit(1)
    )
    rows = store.rows(query)
    return Archive(rows[0].id, rows[0].content, rows[0].begun) if rows else None


def lines(store: Store, archive: int) -> tuple[Line, ...]:
    """Give the takes of an archive by name, with what was found in short."""
    query = (
        select(
            archive_takes.c.name,
            archive_takes.c.status,
            archive_takes.c.reason,
            scans.c.summary,
        )
        .select_from(archive_takes)
        .join(archives, archives.c.id == archive_takes.c.archive)
        .outerjoin(
            scans,
            (scans.c.take == archive_takes.c.take) & (scans.c.settings == archives.c.settings),
        )
        .where(archive_takes.c.archive == archive)
    )
    found = [
        Line(row.name, row.status, row.reason, (row.summary or {}) if row.status == "done" else {})
        for row in store.rows(query)
    ]
    return tuple(sorted(found, key=lambda line: (line.name.casefold(), line.name)))
