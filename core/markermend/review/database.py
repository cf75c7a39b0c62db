"""Open the database of a store: where it is, how it keeps its word, which schema it has."""

import json
import os
import sqlite3
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from sqlalchemy import URL, Connection, Engine, create_engine, event, inspect, make_url, text
from sqlalchemy.exc import ArgumentError, DBAPIError, NoSuchModuleError

from markermend.errors import StoreError
from markermend.review.schema import REVISIONS, VERSION_TABLE

VARIABLE = "MARKERMEND_STORE"
BUSY_S = 15.0
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
        return url.set(drivername="postgresql+psycopg") if url.drivername == "postgresql" else url
    if where:
        path = Path(where).expanduser()
    else:
        from platformdirs import user_data_path  # costs time that no other start should pay

        path = user_data_path("markermend", appauthor=False) / _FILE
    path = (path / _FILE if path.is_dir() else path).absolute()
    return URL.create("sqlite", database=str(path))


def shown(url: URL) -> str:
    """Name the store in a message: its file, or its URL without the password."""
    if url.get_backend_name() == "sqlite" and url.database:
        return url.database
    return url.render_as_string(hide_password=True)


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
        engine = create_engine(url, json_serializer=_strict_json, pool_pre_ping=not is_sqlite)
    except (NoSuchModuleError, ModuleNotFoundError) as error:
        raise StoreError(
            f"The store {where} needs a database driver that is not installed ({error}); "
            "install it, or give a file with --store."
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


@contextmanager
def spoken(where: str) -> Iterator[None]:
    """Say what a database says in a sentence with a way out."""
    try:
        yield
    except DBAPIError as error:
        said = str(error.orig).strip().split("\n")[0]
        raise StoreError(f"The store {where} {_meaning(said)}") from error


def _meaning(said: str) -> str:
    lower = said.lower()
    for words, meaning in (
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
    ):
        if any(word in lower for word in words):
            return meaning
    return f"cannot be used ({said}); choose another with --store."


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
        if _version(connection, where) != REVISIONS[-1]:  # else another process was faster
            config.attributes["connection"] = connection
            command.upgrade(config, "head")
