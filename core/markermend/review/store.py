"""Where reviews are kept: SQLite by default, any database of SQLAlchemy by its URL.

A take is known by the hash of its content: renamed or moved it keeps its reviews. A review is an
append-only journal of what was done, undone and redone; nothing in it is ever changed. To restore
a backup, give its file as the store.
"""

import getpass
import os
import secrets
import sqlite3
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path
from types import TracebackType
from typing import Any, Literal, Self, TypeVar

from sqlalchemy import Connection, Row, Select, Table, func, insert, select, update
from sqlalchemy.exc import DBAPIError, IntegrityError

from markermend.errors import Conflict, StoreError, Taken
from markermend.model import Take
from markermend.review.backups import copy_store
from markermend.review.database import (
    default_file,
    locate,
    moment,
    open_engine,
    shown,
    spoken,
    store_file,
    writing,
)
from markermend.review.entries import Action, Entry, ReviewRecord, TakeRecord
from markermend.review.schema import claims, journal, reviews, takes

__all__ = [
    "Action",
    "Entry",
    "ReviewRecord",
    "Store",
    "TakeRecord",
    "default_operator",
    "new_token",
    "storable",
]

T = TypeVar("T")


def new_token() -> str:
    """Make a name that nothing else has."""
    return secrets.token_hex(16)


def default_operator() -> str:
    """Give the name under which decisions are kept: ``MARKERMEND_OPERATOR``, else the login."""
    try:
        return os.environ.get("MARKERMEND_OPERATOR") or getpass.getuser()
    except (OSError, KeyError, ImportError):  # an account without a name, as in some containers
        return "operator"


class Store:
    """The store of reviews; every call is one transaction, on disk when it returns.

    Parameters
    ----------
    where
        A file, a folder, or the URL of a database; by default the environment variable
        ``MARKERMEND_STORE``, else a file in the user's data folder.

    Raises
    ------
    StoreError
        If the store cannot be opened; likewise from every method.
    """

    def __init__(self, where: str | Path | None = None) -> None:
        url = locate(where)
        self.where = shown(url)
        self._engine = open_engine(url)

    @property
    def folder(self) -> Path:
        """Where files may be kept that belong to the store: beside it, or in your data folder."""
        with spoken(self.where), self._engine.connect() as connection:
            return (store_file(connection) or default_file()).parent

    def close(self) -> None:
        """Close all connections."""
        self._engine.dispose()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    def remember(
        self, take: Take, *, given_units: str | None = None, given_rate: float | None = None
    ) -> None:
        """Note that this take was opened, and where it lies now.

        Parameters
        ----------
        take
            The take as read.
        given_units, given_rate
            What the operator supplied because the file lacks it; kept for the next time.
        """
        path = None if take.source is None else take.source.path
        now = datetime.now(UTC)
        values: dict[str, Any] = {
            "name": "untitled" if path is None else storable(path.name),
            "path": None if path is None else storable(path.absolute()),
            "n_frames": take.n_frames,
            "rate": take.rate,
            "last_seen": now,
        }
        values |= {"given_units": given_units} if given_units is not None else {}
        values |= {"given_rate": given_rate} if given_rate is not None else {}
        known = update(takes).where(takes.c.sha256 == take.content_hash).values(**values)
        fresh = insert(takes).values(sha256=take.content_hash, first_seen=now, **values)

        def write() -> None:
            try:
                with writing(self._engine) as connection:
                    if not connection.execute(known).rowcount:
                        connection.execute(fresh)
            except IntegrityError:  # somebody else inserted it in between
                with writing(self._engine) as connection:
                    connection.execute(known)

        self._again(write)

    def take(self, sha256: str) -> TakeRecord | None:
        """Give what is known of a take, or None."""
        found = self._rows(select(takes).where(takes.c.sha256 == sha256))
        return _take_record(found[0]) if found else None

    def takes(self, limit: int | None = None) -> tuple[TakeRecord, ...]:
        """Give the takes, the last opened first."""
        query = select(takes).order_by(takes.c.last_seen.desc(), takes.c.sha256).limit(limit)
        return tuple(_take_record(row) for row in self._rows(query))

    def changed_since(self, path: str | Path, sha256: str) -> TakeRecord | None:
        """Give the other content that this path had when it was last opened, or None.

        Ask before `remember`; the reviews of the earlier content stay with that content.
        """
        query = (
            select(takes)
            .where(takes.c.path == storable(Path(path).absolute()))
            .order_by(takes.c.last_seen.desc())
            .limit(1)
        )
        found = [_take_record(row) for row in self._rows(query)]
        return found[0] if found and found[0].sha256 != sha256 else None

    def review(
        self, take: str, operator: str | None = None, purpose: str = "review"
    ) -> ReviewRecord:
        """Give the review of a remembered take by an operator, and begin it if there is none.

        Parameters
        ----------
        take
            Content hash of the take.
        operator
            Whose review; by default `default_operator`.
        purpose
            Tells reviews of one take by one operator apart.
        """
        who = operator or default_operator()
        wanted = select(reviews).where(
            reviews.c.take == take, reviews.c.operator == who, reviews.c.purpose == purpose
        )
        if found := self._rows(wanted):
            return _review_record(found[0])
        if self.take(take) is None:
            raise StoreError(f"The store {self.where} does not know the take {take[:12]}; open it.")
        fresh = insert(reviews).values(
            take=take, operator=who, purpose=purpose, status="open", created=datetime.now(UTC)
        )

        def write() -> None:
            try:
                with writing(self._engine) as connection:
                    connection.execute(fresh)
            except IntegrityError:  # two windows began it at once: it is there now
                pass

        self._again(write)
        return _review_record(self._rows(wanted)[0])

    def reviews(self, take: str | None = None) -> tuple[ReviewRecord, ...]:
        """Give all reviews, or those of one take, oldest first."""
        query = select(reviews).order_by(reviews.c.created, reviews.c.id)
        if take is not None:
            query = query.where(reviews.c.take == take)
        return tuple(_review_record(row) for row in self._rows(query))

    def set_status(self, review: int, status: Literal["open", "finished"]) -> None:
        """Say that a review is finished, or open again."""
        change = update(reviews).where(reviews.c.id == review).values(status=status)

        def write() -> None:
            with writing(self._engine) as connection:
                connection.execute(change)

        self._again(write)

    def entries(self, review: int, after: int = 0) -> tuple[Entry, ...]:
        """Give the journal of a review, from the entry that follows number `after`."""
        query = (
            select(journal)
            .where(journal.c.review == review, journal.c.seq > after)
            .order_by(journal.c.seq)
        )
        return tuple(
            Entry(row.seq, row.action, row.command, row.operator, row.at, row.token)
            for row in self._rows(query)
        )

    def append(
        self,
        review: int,
        after: int,
        lines: Sequence[tuple[Action, Mapping[str, Any] | None]],
        operator: str,
        token: str = "",
    ) -> tuple[Entry, ...]:
        """Append to a journal, all lines or none, and never twice.

        Parameters
        ----------
        review
            Id of the review.
        after
            Number of the last entry that the caller knows.
        lines
            Actions with their commands.
        operator
            Who does it.
        token
            Names this call: said again with the same token, after a connection was lost, it finds
            the lines that it wrote the first time. By default a new one.

        Raises
        ------
        Conflict
            If somebody else has appended since.
        Taken
            If somebody else has claimed the take of this review.
        Unreachable
            If the database does not answer; call again with the same token.
        """
        now, token = datetime.now(UTC), token or new_token()
        fresh = tuple(
            Entry(after + i, action, command, operator, now, token)
            for i, (action, command) in enumerate(lines, 1)
        )

        def write() -> tuple[Entry, ...]:
            try:
                with writing(self._engine) as connection:
                    last, holder = connection.execute(self._state_of(review, operator)).one()
                    if last == after and holder is None:
                        rows = [{"review": review, **asdict(entry)} for entry in fresh]
                        connection.execute(insert(journal), rows)
                        return fresh
            except IntegrityError:  # an entry of that number came in between
                holder = None
            return self._written_before(review, after, fresh, holder)

        return self._again(write)

    def _state_of(self, review: int, operator: str) -> Select[Any]:
        """Ask for the last number of a journal, and for who else has claimed the review."""
        last = select(func.coalesce(func.max(journal.c.seq), 0)).where(journal.c.review == review)
        others = (
            select(claims.c.operator)
            .where(claims.c.review == review, claims.c.operator != operator)
            .where(claims.c.until > moment(self._engine))
            .limit(1)
        )
        return select(last.scalar_subquery(), others.scalar_subquery())

    def _written_before(
        self, review: int, after: int, fresh: tuple[Entry, ...], holder: str | None
    ) -> tuple[Entry, ...]:
        """Give our own lines, where an earlier try wrote them; else say what stands in the way."""
        there = self.entries(review, after)
        if fresh and [entry.token for entry in there[: len(fresh)]] == [fresh[0].token] * len(
            fresh
        ):
            return there[: len(fresh)]
        if holder is not None:
            raise Taken(
                f"{holder} has taken this review over; look on, or take it over again.", holder
            )
        if there:
            raise Conflict(
                "This review was changed in another window; reload it to go on from there.",
                theirs=there,
            )
        raise StoreError(
            f"The store {self.where} went back to a backup; open the take again to go on from it."
        )

    def backup(self, path: str | Path) -> None:
        """Copy an SQLite store while it is in use; the copy is whole or absent.

        Raises
        ------
        StoreError
            If the file cannot be written, or the store is no SQLite file.
        """
        if self._engine.dialect.name != "sqlite":
            raise StoreError(
                f"The store {self.where} is on a server; back it up with pg_dump --format=custom."
            )
        target = Path(path).absolute()
        if str(target) == self.where:
            raise StoreError(f"{target} is the store itself; give another file for the backup.")
        with spoken(self.where), self._engine.connect() as connection:
            source = connection.connection.driver_connection
            assert isinstance(source, sqlite3.Connection)
            copy_store(source, target)

    def damage(self) -> tuple[str, ...]:
        """Say what the database itself finds wrong with what it keeps; nothing where all is well.

        A server watches over its own pages and says nothing here.
        """
        if self._engine.dialect.name != "sqlite":
            return ()
        with spoken(self.where), self._engine.connect() as connection:
            said = connection.exec_driver_sql("PRAGMA integrity_check(20)").scalars().all()
            strays = connection.exec_driver_sql("PRAGMA foreign_key_check").fetchall()
        found = [f"The file {self.where} is damaged ({line})." for line in said if line != "ok"]
        found += [
            f"Row {row} of {table} in {self.where} belongs to nothing in {other}."
            for table, row, other, _ in strays[:20]
        ]
        return tuple(found)

    def rows(self, query: Select[Any]) -> list[Row[Any]]:
        """Answer a query; for rooms that keep tables of their own here (`schema`)."""
        return self._rows(query)

    def now(self) -> datetime:
        """Give the time by the clock that all users of the store share."""
        clock = moment(self._engine)
        if isinstance(clock, datetime):
            return clock
        told: datetime = self._rows(select(clock))[0][0]
        return told.replace(tzinfo=UTC)

    @contextmanager
    def transaction(self) -> Iterator[Connection]:
        """Write several rows as one; for rooms that keep tables of their own here (`schema`)."""
        with spoken(self.where), writing(self._engine) as connection:
            yield connection

    def add_row(self, table: Table, **values: Any) -> int:
        """Insert one row into a table with an ``id``, and give that id."""
        with spoken(self.where), writing(self._engine) as connection:
            done = connection.execute(insert(table).values(**values))
            assert done.inserted_primary_key is not None
            return int(done.inserted_primary_key[0])

    def add_line(self, table: Table, **values: Any) -> None:
        """Insert one row into a table whose key is among the values."""
        with self.transaction() as connection:
            connection.execute(insert(table).values(**values))

    def _rows(self, query: Any) -> list[Row[Any]]:
        def read() -> list[Row[Any]]:
            with self._engine.connect() as connection:
                return list(connection.execute(query))

        return self._again(read)

    def _again(self, call: Callable[[], T]) -> T:
        """Make a call that may be made twice, and make it again if its connection is lost."""
        with spoken(self.where):
            try:
                return call()
            except DBAPIError as error:
                if not error.connection_invalidated:
                    raise
            return call()


def storable(path: str | Path) -> str:
    """Give a path as text that any database takes, also where its bytes are no UTF-8."""
    return str(path).encode("utf-8", "backslashreplace").decode()


def _take_record(row: Row[Any]) -> TakeRecord:
    return TakeRecord(**{**row._asdict(), "path": row.path and Path(row.path)})


def _review_record(row: Row[Any]) -> ReviewRecord:
    return ReviewRecord(**row._asdict())
