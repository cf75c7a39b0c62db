"""A store on a server: what it says when nobody answers, and that nothing is lost meanwhile."""

import json
import logging
import shutil
import socket
import sqlite3
import subprocess
import threading
import traceback
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing, suppress
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import JSON, DateTime, MetaData, create_engine, make_url, text

from markermend.errors import Conflict, StoreError, Taken, Unreachable
from markermend.model import Finding, Span, Take
from markermend.review import Accept, Reject, Split
from markermend.review import database as database_module
from markermend.review.claims import claim
from markermend.review.database import POOL, locate
from markermend.review.schema import REVISIONS, VERSION_TABLE
from markermend.review.session import ReviewSession
from markermend.review.store import Store
from markermend.review.upkeep import check

ASSETS = Path(__file__).with_name("assets")


def peak(n: int) -> Finding:
    return Finding("A", Span(n, n + 3), "peak")


class Line:
    """A line to a server that can be cut and mended."""

    def __init__(self, port: int) -> None:
        self._to = port
        self._open: list[socket.socket] = []
        self._door = socket.create_server(("127.0.0.1", 0))
        self.port = int(self._door.getsockname()[1])
        self.mend()

    def mend(self) -> None:
        if self._door.fileno() < 0:
            self._door = socket.create_server(("127.0.0.1", self.port))
        threading.Thread(target=self._listen, args=(self._door,), daemon=True).start()

    def cut(self) -> None:
        with suppress(OSError):
            self._door.shutdown(socket.SHUT_RDWR)
        self._door.close()
        self.drop()

    def drop(self) -> None:
        """Break what is connected now; who comes again is let through."""
        for one in self._open:
            with suppress(OSError):
                one.shutdown(socket.SHUT_RDWR)
            one.close()
        self._open.clear()

    def _listen(self, door: socket.socket) -> None:
        while True:
            try:
                near, _ = door.accept()
            except OSError:
                return
            far = socket.create_connection(("127.0.0.1", self._to))
            self._open += [near, far]
            for a, b in ((near, far), (far, near)):
                threading.Thread(target=self._carry, args=(a, b), daemon=True).start()

    @staticmethod
    def _carry(a: socket.socket, b: socket.socket) -> None:
        with suppress(OSError):
            while data := a.recv(65536):
                b.sendall(data)
        for one in (a, b):
            with suppress(OSError):
                one.shutdown(socket.SHUT_RDWR)


@pytest.fixture
def line(lab: str) -> Iterator[Line]:
    port = make_url(lab).port
    assert port is not None
    made = Line(port)
    yield made
    made.cut()


@pytest.fixture
def session(server_store: Store, line: Line, lab: str, take: Take) -> Iterator[ReviewSession]:
    """A session whose store is at the other end of the line."""
    address = make_url(lab).set(port=line.port).render_as_string(hide_password=False)
    with Store(address) as distant:
        yield ReviewSession.open(distant, take, "anna")


def fresh_database(lab: str, name: str) -> str:
    engine = create_engine(locate(lab), isolation_level="AUTOCOMMIT")
    with engine.connect() as connection:
        connection.execute(text(f'DROP DATABASE IF EXISTS "{name}"'))
        connection.execute(text(f'CREATE DATABASE "{name}"'))
    engine.dispose()
    return make_url(lab).set(database=name).render_as_string(hide_password=False)


def test_a_line_that_was_cut_is_mended_unseen(session: ReviewSession, line: Line) -> None:
    session.do(Accept((peak(1),)))
    line.drop()
    session.do(Accept((peak(9),)))
    line.drop()
    session.refresh()
    assert len(session.review) == 2
    assert [e.seq for e in session.store.entries(session.record.id)] == [1, 2]


@pytest.mark.parametrize("when", ["before", "after"])
def test_a_commit_whose_answer_was_lost_is_made_once(
    session: ReviewSession, line: Line, when: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The connection breaks just before the server commits, or just after."""
    dialect = session.store._engine.dialect
    real, broken = dialect.do_commit, []

    def commit(connection: Any) -> None:
        if broken:
            real(connection)
            return
        broken.append(when)
        if when == "after":
            real(connection)
        line.drop()
        connection.execute("SELECT 1")  # finds the line broken

    monkeypatch.setattr(dialect, "do_commit", commit)
    session.do(Accept((peak(1),)))
    assert broken
    assert len(session.store.entries(session.record.id)) == 1
    session.do(Accept((peak(9),)))
    assert len(session.store.entries(session.record.id)) == 2


def test_what_is_decided_while_the_server_is_away_is_kept(
    session: ReviewSession, line: Line, server_store: Store
) -> None:
    session.do(Accept((peak(1),)))
    line.cut()
    with pytest.raises(
        Unreachable, match=r"does not answer; see .*try again\. 1 decision is kept here"
    ):
        session.do(Accept((peak(9),)))
    with pytest.raises(Unreachable, match="2 decisions are kept here, not saved yet"):
        session.do(Split((peak(9),), 10))
    for act in (session.undo, session.save, session.refresh):
        with pytest.raises(Unreachable):
            act()
    assert [command.describe() for command in session.unsaved] == [
        "Accept A peak 9-12",
        "Split A peak 9-12 at 10",
    ]
    assert len(session.review) == 1  # what is shown as decided is on disk
    line.mend()
    change = session.save()
    assert len(change.commands) == 2
    assert session.unsaved == ()
    assert ReviewSession(server_store, session.record).review == session.review
    session.undo()
    assert len(server_store.entries(session.record.id)) == 4


def test_a_lost_answer_is_found_when_the_server_is_back(
    session: ReviewSession, line: Line, server_store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    dialect = session.store._engine.dialect
    real = dialect.do_commit

    def commit(connection: Any) -> None:
        real(connection)
        line.cut()
        connection.execute("SELECT 1")  # finds the line broken

    with monkeypatch.context() as patch:
        patch.setattr(dialect, "do_commit", commit)
        with pytest.raises(Unreachable):
            session.do(Accept((peak(1),)))
    assert len(server_store.entries(session.record.id)) == 1
    line.mend()
    session.refresh()
    assert session.unsaved == ()
    session.save()
    assert len(server_store.entries(session.record.id)) == 1


def test_somebody_who_wrote_meanwhile_is_a_conflict_with_all_that_was_kept(
    session: ReviewSession, line: Line, server_store: Store
) -> None:
    line.cut()
    for n in (1, 9):
        with pytest.raises(Unreachable):
            session.do(Accept((peak(n),)))
    ReviewSession(server_store, session.record, "bo").do(Reject((peak(1),)))
    line.mend()
    with pytest.raises(Conflict) as conflict:
        session.do(Accept((peak(20),)))
    assert len(conflict.value.mine) == 3
    assert [entry.operator for entry in conflict.value.theirs] == ["bo"]  # type: ignore[attr-defined]


def test_a_claim_made_meanwhile_stands(
    session: ReviewSession, line: Line, server_store: Store
) -> None:
    line.cut()
    with pytest.raises(Unreachable):
        session.do(Accept((peak(1),)))
    claim(server_store, session.record, "bo", "b1")
    line.mend()
    with pytest.raises(Taken, match="bo has taken"):
        session.save()
    assert len(session.unsaved) == 1


def test_nobody_there_is_said_and_the_password_is_not(
    lab: str, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(database_module, "CONNECT_S", 2)
    engine = create_engine(locate(lab))
    with engine.begin() as connection:
        connection.execute(text("DROP ROLE IF EXISTS guarded"))
        connection.execute(text("CREATE ROLE guarded LOGIN PASSWORD 'right'"))
    engine.dispose()
    caplog.set_level(logging.DEBUG)
    with socket.create_server(("127.0.0.1", 0)) as door:
        nobody = door.getsockname()[1]
    port = make_url(lab).port
    wrong = f"postgresql://guarded:hunter2@127.0.0.1:{port}/postgres"
    for address, kind, said in (
        (wrong, StoreError, "lets nobody in with this name and password"),
        (wrong.replace(":hunter2@", "@") + "?password=hunter2", StoreError, "lets nobody in"),
        (f"postgresql://anna:hunter2@127.0.0.1:{nobody}/lab", Unreachable, "does not answer"),
        ("postgresql://anna:hunter2@nowhere.invalid/lab", Unreachable, "does not answer"),
        (
            f"postgresql://guarded:right@127.0.0.1:{port}/absent",
            StoreError,
            "make it with createdb",
        ),
    ):
        with pytest.raises(kind, match=said) as caught:
            Store(address)
        told = "".join(traceback.format_exception(caught.value)) + caplog.text
        assert "hunter2" not in told
        assert "hunter2" not in str(caught.value)
        assert str(caught.value).endswith(".")
        assert "\n" not in str(caught.value)


def test_many_at_once_wait_for_a_connection(server_store: Store, take: Take) -> None:
    server_store.remember(take)
    with ThreadPoolExecutor(4 * POOL) as pool:
        found = list(pool.map(lambda _: len(server_store.takes()), range(8 * POOL)))
    assert found == [1] * (8 * POOL)
    assert server_store._engine.pool.checkedin() <= POOL  # type: ignore[attr-defined]


def test_a_backup_of_a_server_is_for_its_own_tools(server_store: Store, tmp_path: Path) -> None:
    with pytest.raises(StoreError, match="on a server; back it up with pg_dump"):
        server_store.backup(tmp_path / "backup.sqlite")


def test_the_servers_own_tools_bring_everything_back(
    server_store: Store, lab: str, take: Take, tmp_path: Path
) -> None:
    found = sorted(Path("/usr/lib/postgresql").glob("*/bin/pg_dump"))
    dump = str(found[-1]) if found else shutil.which("pg_dump")
    if dump is None:
        pytest.skip("pg_dump is not installed")
    session = ReviewSession.open(server_store, take, "anna")
    session.do(Accept((peak(1),)))
    file, other = tmp_path / "reviews.dump", fresh_database(lab, "restored")
    restore = str(Path(dump).with_name("pg_restore"))
    run = partial(subprocess.run, check=True, capture_output=True)
    run([dump, "--format=custom", f"--file={file}", lab])
    run([restore, "--clean", "--if-exists", f"--dbname={other}", file])
    with Store(other) as store:
        assert check(store).faults == ()
        assert ReviewSession.open(store, take, "anna").review == session.review


def test_several_may_make_the_store_at_once(lab: str) -> None:
    address = fresh_database(lab, "at_once")
    with ThreadPoolExecutor(3) as pool:
        list(pool.map(lambda _: Store(address).close(), range(3)))
    with Store(address) as store:
        assert check(store).faults == ()


@pytest.mark.parametrize("schema", REVISIONS)
def test_a_store_of_every_schema_is_upgraded_on_a_server(lab: str, schema: str) -> None:
    address = fresh_database(lab, f"of_schema_{schema}")
    _as_of(schema, address)
    with closing(sqlite3.connect(":memory:")) as raw:
        raw.executescript((ASSETS / f"store-{schema}.sql").read_text(encoding="utf-8"))
        _carry_over(raw, address)
    with Store(address) as store:
        health = check(store)
        assert (health.n_takes, health.n_reviews, health.n_lines) == (1, 1, 16)
        assert health.faults == ()
        (record,) = store.reviews()
        session = ReviewSession(store, record)
        counts = session.review.counts()
        assert (counts.accepted, counts.rejected, counts.deferred, counts.open) == (1, 2, 1, 1)
        session.do(Accept((peak(1),)))
        assert store.entries(record.id)[-1].seq == 17


def _as_of(schema: str, address: str) -> None:
    from alembic import command
    from alembic.config import Config

    config = Config()
    folder = Path(database_module.__file__).with_name("migrations")
    config.set_main_option("script_location", str(folder))
    config.set_main_option("path_separator", "os")
    engine = create_engine(locate(address))
    with engine.begin() as connection:
        config.attributes["connection"] = connection
        command.upgrade(config, schema)
    engine.dispose()


def _carry_over(raw: sqlite3.Connection, address: str) -> None:
    engine = create_engine(locate(address))
    there = MetaData()
    there.reflect(engine)
    raw.row_factory = sqlite3.Row
    with engine.begin() as connection:
        for table in there.sorted_tables:
            if table.name == VERSION_TABLE:
                continue
            rows = []
            for row in raw.execute(f'SELECT * FROM "{table.name}"'):
                values = dict(row)
                for column in table.columns:
                    value = values[column.name]
                    if isinstance(column.type, JSON) and value is not None:
                        values[column.name] = json.loads(value)
                    elif isinstance(column.type, DateTime) and value is not None:
                        values[column.name] = datetime.fromisoformat(value)
                    elif str(column.type) == "BOOLEAN" and value is not None:
                        values[column.name] = bool(value)
                rows.append(values)
            if rows:
                connection.execute(table.insert(), rows)
    engine.dispose()
