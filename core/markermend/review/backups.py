"""Copies of an SQLite store, taken and put back while it is in use."""

import os
import sqlite3
from contextlib import closing
from pathlib import Path

from markermend.errors import StoreError


def copy_store(source: sqlite3.Connection, target: Path) -> None:
    """Copy a database into a file; the file is whole or as before.

    Raises
    ------
    StoreError
        If the file cannot be written.
    """
    draft = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        with closing(sqlite3.connect(draft)) as copy:
            source.backup(copy)
        draft.replace(target)
    except (OSError, sqlite3.Error) as error:
        raise StoreError(
            f"The backup {target} cannot be written ({error}); choose another place."
        ) from None
    finally:
        draft.unlink(missing_ok=True)


def keep_before(path: Path, schema: str) -> Path:
    """Copy a store beside itself before its schema changes, and give the copy's file.

    The copy is named after the schema that it has; an earlier copy is never replaced.

    Raises
    ------
    StoreError
        If the copy cannot be written.
    """
    target = unused(path, f"schema-{schema}")
    # A connection of its own: the one that migrates has its transaction open already.
    with closing(sqlite3.connect(path)) as source:
        copy_store(source, target)
    return target


def put_back(backup: Path, path: Path) -> Path | None:
    """Make a store what a backup is, whole or not at all, and keep what it was beside it.

    Programs that have the store open see the backup from their next call on.

    Returns
    -------
    The copy of what was there, or None where nothing was.

    Raises
    ------
    StoreError
        If either file cannot be read or written.
    """
    kept = None
    try:
        if path.exists():
            kept = unused(path, "replaced")
            with closing(sqlite3.connect(path)) as before:
                copy_store(before, kept)
        path.parent.mkdir(parents=True, exist_ok=True)
        with (
            closing(sqlite3.connect(backup)) as source,
            closing(sqlite3.connect(path, timeout=30)) as target,
        ):
            source.backup(target)
    except (OSError, sqlite3.Error) as error:
        raise StoreError(
            f"{backup} cannot be put back into {path} ({error}); stop the programs that use it."
        ) from None
    return kept


def unused(path: Path, what: str) -> Path:
    """Give the name of a file beside another that is not there yet."""
    number = 1
    while True:
        again = "" if number == 1 else f"-{number}"
        target = path.with_name(f"{path.stem}.{what}{again}{path.suffix}")
        if not target.exists():
            return target
        number += 1
