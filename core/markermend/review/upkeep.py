"""Look after a store: is everything in it whole, and how to go back to a backup."""

import sqlite3
import tempfile
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from sqlalchemy import func, select

from markermend.errors import StoreError
from markermend.review.backups import copy_store, put_back
from markermend.review.database import locate
from markermend.review.schema import REVISIONS, journal
from markermend.review.session import ReviewSession
from markermend.review.store import ReviewRecord, Store


@dataclass(frozen=True)
class Health:
    """What a store holds, and what is wrong with it.

    Attributes
    ----------
    n_takes, n_reviews, n_lines
        Takes, reviews, and lines of all their journals.
    schema
        The schema of the store.
    faults
        One sentence each; empty where all is well.
    """

    n_takes: int
    n_reviews: int
    n_lines: int
    schema: str
    faults: tuple[str, ...]


def check(store: Store, progress: Callable[[int, int], None] = lambda done, total: None) -> Health:
    """Read everything: the file itself, and every review from its first line to its last.

    Parameters
    ----------
    store
        An open store, on SQLite or a server.
    progress
        Called with the number of reviews that were read, and of all.

    Raises
    ------
    StoreError
        If the store cannot be read at all.
    """
    faults = list(store.damage())
    reviews = store.reviews()
    counted = {
        row.review: (row.lines, row.last)
        for row in store.rows(
            select(
                journal.c.review,
                func.count().label("lines"),
                func.max(journal.c.seq).label("last"),
            ).group_by(journal.c.review)
        )
    }
    for done, record in enumerate(reviews, 1):
        lines, last = counted.get(record.id, (0, 0))
        faults += _faults(store, record, lines, last)
        progress(done, len(reviews))
    return Health(
        n_takes=len(store.takes()),
        n_reviews=len(reviews),
        n_lines=sum(lines for lines, _ in counted.values()),
        schema=REVISIONS[-1],
        faults=tuple(faults),
    )


def _faults(store: Store, record: ReviewRecord, lines: int, last: int) -> list[str]:
    if lines != last:
        which = f"The journal of review {record.id} ({record.operator})"
        return [f"{which} has {lines} lines and ends with number {last}; go back to a backup."]
    try:
        ReviewSession(store, record)
    except StoreError as error:
        return [str(error)]
    return []


def restore(backup: str | Path, where: str | Path | None = None) -> Path | None:
    """Make a store what a backup of it was; what it was until now is kept beside it.

    The backup is read whole first and is never written to; its schema may be an older one.

    Parameters
    ----------
    backup
        A file that `Store.backup` wrote, or one that was kept before a change of schema.
    where
        The store, as for `Store`; an SQLite file.

    Returns
    -------
    The file that keeps what was there, or None where nothing was.

    Raises
    ------
    StoreError
        If the backup is no whole store, or the store is on a server.
    """
    source, url = Path(backup).expanduser(), locate(where)
    if url.get_backend_name() != "sqlite" or not url.database:
        raise StoreError("The store is on a server; go back to a backup of it with pg_restore.")
    if not source.is_file():
        raise StoreError(f"There is no backup {source}; give the file that was written.")
    target = Path(url.database)
    if target.exists() and source.samefile(target):
        raise StoreError(f"{source} is the store itself; give the file of a backup.")
    with tempfile.TemporaryDirectory() as folder:
        tried = Path(folder) / "tried.sqlite"
        try:
            with closing(sqlite3.connect(source)) as original:
                copy_store(original, tried)
        except StoreError:
            raise StoreError(f"{source} is damaged or no store; choose another backup.") from None
        with Store(tried) as copy:
            faults = check(copy).faults  # opening it has brought its schema up to date
        if faults:
            raise StoreError(f"The backup {source} is damaged and is not put back: {faults[0]}")
        return put_back(tried, target)
