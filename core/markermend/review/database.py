"""Open the database of a store: where it is, how it keeps its word, which schema it has."""

import json
import os
import re
import sqlite3
import time
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from sqlalchemy import URL, Connection, Engine, create_engine, event, func, inspect, make_url, text
from sqlalchemy.exc import ArgumentError, DBAPIError, NoSuchModuleError
from sqlalchemy.exc import TimeoutError as PoolTimeout

from markermend.errors import StoreError, Unreachable
from markermend.review.backups import keep_before
from markermend.review.schema import REVISIONS, VERSION_TABLE

VARIABLE = "MARKERMEND_STORE"
BUSY_S = 15.0
CONNECT_S = 5
SILENT_S = 10
POOL = 5
"""Connections that one process keeps to a server; under load it opens as many more."""
_FILE = "reviews.sqlite"
_WRITES = "markermend_writes"
_LOCK = 0x6D61726B  # any number; the same for everybody who migrates


def locate(given: str | Path | None = None) -> URL:
    """Say where the store is.

    Parameters
    ----------
    given
        A file, a folder, or the URL of a database; by default the environment variable
        ``MARKERMEND_STORE``, else a file in the user's data folder.

    Raises
    ------
    StoreError
        If the URL cannot be understood.
    """
    where = str(given or os.environ.get(VARIABLE) or "")
    if "://" in where:
        try:
            url = make_url(where)
        except ArgumentError:
            raise StoreError(
                "The store's address is no database URL; write it as "
                "postgresql://user:password@host/name, or give a file."
            ) from None
        known = url.drivername in ("postgresql", "postgres")
        return url.set(drivername="postgresql+psycopg") if known else url
    path = Path(where).expanduser() if where else default_file()
    path = (path / _FILE if path.is_dir() else path).absolute()
    return URL.create("sqlite", database=str(path))


def default_file() -> Path:
    """Give the file of the store where none is named: in the user's data folder."""
    from platformdirs import user_data_path  # costs time that no other start should pay

    return user_data_path("markermend", appauthor=False) / _FILE


def shown(url: URL) -> str:
    """Name the store in a message: its file, or its URL without the password."""
    if url.get_backend_name() == "sqlite" and url.database:
        return url.database
    # libpq takes passwords among the options too, where SQLAlchemy does not look for them.
    hidden = {name: "hidden" for name in url.query if "password" in name.lower()}
    return url.update_query_dict(hidden).render_as_string(hide_password=True)


def open_engine(url: URL) -> Engine:
    """Open the database, and bring its schema up to date.

    Raises
    ------
    StoreError
        If it cannot be opened, is no store, or was written by a newer version.
    """
    where = shown(url)
    is_sqlite = url.get_backend_name() == "sqlite"
    if is_sqlite and url.database and "://" not in url.database:
        try:
            Path(url.database.removeprefix("file:")).parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise StoreError(
                f"The folder of the store {where} cannot be made ({error.strerror}); "
                "choose another place with --store."
            ) from None
    try:
        engine = create_engine(
            url, json_serializer=_strict_json, **({} if is_sqlite else _for_a_server(url))
        )
    except (NoSuchModuleError, ImportError) as error:
        wanted = "pip install 'markermend[postgres]'" if "psycopg" in str(error) else "install it"
        raise StoreError(
            f"The store {where} needs a database driver that is not installed ({error}); "
            f"{wanted}, or give a file with --store."
        ) from None
    if is_sqlite:
        event.listen(engine, "connect", _keep_every_commit)
        event.listen(engine, "begin", _begin)
    try:
        with spoken(where):
            _bring_up_to_date(engine, where)
    except BaseException:
        engine.dispose()
        raise
    return engine


@contextmanager
def writing(engine: Engine) -> Iterator[Connection]:
    """Give a connection in a transaction that writes, and commit it."""
    with engine.connect() as plain:
        connection = plain.execution_options(**{_WRITES: True})
        with connection.begin():
            yield connection


def moment(engine: Engine) -> Any:
    """Give now: by the server's clock, since those of its users differ, as a part of a query."""
    if engine.dialect.name == "postgresql":
        return func.timezone("UTC", func.clock_timestamp())
    return datetime.now(UTC)


def _for_a_server(url: URL) -> dict[str, Any]:
    """Give what a pool of connections to a server needs; the address may say otherwise."""
    if url.get_backend_name() != "postgresql":
        return {"pool_pre_ping": True}
    wanted = {
        "application_name": "markermend",
        "connect_timeout": CONNECT_S,
        "tcp_user_timeout": SILENT_S * 1000,  # a cable that was pulled is noticed
    }
    return {
        "pool_size": POOL,
        "max_overflow": POOL,
        "pool_timeout": BUSY_S,
        "pool_recycle": 1800,  # routers forget connections that are silent for long
        "pool_pre_ping": True,
        "connect_args": {name: wanted[name] for name in wanted if name not in url.query},
    }


@contextmanager
def spoken(where: str) -> Iterator[None]:
    """Say what a database says in a sentence with a way out.

    Raises
    ------
    Unreachable
        If the server of a database does not answer.
    StoreError
        For all else.
    """
    try:
        yield
    except DBAPIError as error:
        raise refusal(where, error) from error
    except PoolTimeout as error:
        raise Unreachable(
            f"The store {where} is busy: all connections are in use; wait a moment and try again."
        ) from error


def refusal(where: str, error: DBAPIError) -> StoreError:
    """Give the error to raise for what a database said."""
    said = str(error.orig).strip()
    lower = said.lower()
    for pattern, meaning in _SERVER:
        if re.search(pattern, lower):
            return StoreError(f"The store {where} {meaning}")
    if error.connection_invalidated or any(word in lower for word in _GONE):
        return Unreachable(
            f"The store {where} does not answer; see that its server runs and can be reached, "
            "then try again."
        )
    first = said.split("\n")[0]
    meanings = (m for words, m in _FILE_SAYS if any(word in first.lower() for word in words))
    other = f"cannot be used ({first}); choose another with --store."
    return StoreError(f"The store {where} {next(meanings, other)}")


_SERVER = (
    (
        r"password|authentication failed|no pg_hba.conf entry|role \".*\" does not exist",
        "lets nobody in with this name and password; see the address given with --store.",
    ),
    (
        r"too many clients|too many connections|connection slots",
        "has no connection left; close some pages, or let its server have more.",
    ),
    (
        r"database \".*\" does not exist",
        "is not there yet; make it with createdb, or see the address given with --store.",
    ),
)
_GONE = (
    "connection refused",
    "connection failed",
    "connection timeout",
    "timeout expired",
    "could not connect",
    "could not translate host",
    "failed to resolve host",
    "server closed the connection",
    "connection is lost",
    "connection is closed",
    "terminating connection",
    "starting up",
    "shutting down",
    "recovery mode",
)
_FILE_SAYS = (
    (("locked", "busy"), "is in use by another program; wait a moment and try again."),
    (("full",), "has no room left on its disk; free some space, nothing stored is lost."),
    (
        ("readonly", "read-only", "unable to open", "permission"),
        "cannot be written; choose another place with --store.",
    ),
    (
        ("not a database", "malformed", "corrupt", "encrypted"),
        "is damaged or no store of reviews; choose another with --store, or a backup.",
    ),
)


def _strict_json(value: Any) -> str:
    return json.dumps(value, allow_nan=False, separators=(",", ":"))


def _keep_every_commit(connection: sqlite3.Connection, _: object) -> None:
    """Make an SQLite commit outlive a killed process and a power cut."""
    connection.isolation_level = None  # BEGIN is said by `_begin`, never by the driver
    connection.execute(f"PRAGMA busy_timeout = {int(BUSY_S * 1000)}")
    connection.execute("PRAGMA foreign_keys = ON")
    connection.execute("PRAGMA synchronous = FULL")
    until = time.monotonic() + BUSY_S
    while connection.execute("PRAGMA journal_mode").fetchone()[0] != "wal":
        try:
            # A file system without shared memory keeps its old journal, which is as safe.
            connection.execute("PRAGMA journal_mode = WAL")
            return
        except sqlite3.OperationalError as error:
            # SQLite does not wait for this lock by itself: two processes may start at once.
            if "locked" not in str(error) or time.monotonic() > until:
                raise
            time.sleep(0.01)


def _begin(connection: Connection) -> None:
    # A writer takes its lock before it looks: what it reads is still so when it writes.
    writes = connection.get_execution_options().get(_WRITES)
    connection.exec_driver_sql("BEGIN IMMEDIATE" if writes else "BEGIN")


def _version(connection: Connection, where: str) -> str | None:
    tables = inspect(connection)
    if not tables.has_table(VERSION_TABLE):
        if tables.get_table_names():
            raise StoreError(
                f"The store {where} is a database of another program; give one of its own "
                "with --store."
            )
        return None
    found: str | None = connection.scalar(text(f"SELECT version_num FROM {VERSION_TABLE}"))
    if found is not None and found not in REVISIONS:
        raise StoreError(
            f"The store {where} was written by a newer version (schema {found}, this one knows "
            f"{REVISIONS[-1]}); update markermend, or choose another with --store."
        )
    return found


def _bring_up_to_date(engine: Engine, where: str) -> None:
    with engine.connect() as connection:
        if _version(connection, where) == REVISIONS[-1]:
            return
    from alembic import command  # half a second, paid only when a schema changes
    from alembic.config import Config

    config = Config()
    folder = Path(__file__).with_name("migrations")
    config.set_main_option("script_location", str(folder).replace("%", "%%"))
    config.set_main_option("path_separator", "os")
    with writing(engine) as connection:
        if engine.dialect.name == "postgresql":
            connection.execute(text("SELECT pg_advisory_xact_lock(:n)"), {"n": _LOCK})
        found = _version(connection, where)
        if found != REVISIONS[-1]:  # else another process was faster
            file = store_file(connection)
            if found is not None and file is not None:
                keep_before(file, found)
            config.attributes["connection"] = connection
            command.upgrade(config, "head")


def store_file(connection: Connection) -> Path | None:
    """Give the file of an SQLite store; None where it is a server or nowhere."""
    if connection.dialect.name != "sqlite":
        return None
    named = connection.exec_driver_sql("PRAGMA database_list").fetchall()
    return next((Path(file) for _, name, file in named if name == "main" and file), None)
