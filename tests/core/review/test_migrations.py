"""Every schema that was ever released opens, and keeps what was decided under it."""

import sqlite3
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from pathlib import Path

import pytest
from alembic import command
from alembic.autogenerate import compare_metadata
from alembic.config import Config
from alembic.migration import MigrationContext
from alembic.script import ScriptDirectory

from markermend.errors import StoreError
from markermend.model import Span
from markermend.review import database
from markermend.review.schema import REVISIONS, VERSION_TABLE, metadata
from markermend.review.session import ReviewSession
from markermend.review.store import Store

ASSETS = Path(__file__).with_name("assets")


def test_the_list_of_schemas_is_that_of_the_migrations() -> None:
    config = Config()
    folder = Path(database.__file__).with_name("migrations")
    config.set_main_option("script_location", str(folder))
    config.set_main_option("path_separator", "os")
    steps = ScriptDirectory.from_config(config).walk_revisions()
    assert tuple(step.revision for step in steps) == tuple(reversed(REVISIONS))


def test_migrations_make_the_tables_that_the_code_uses(store: Store) -> None:
    with store._engine.connect() as connection:
        context = MigrationContext.configure(
            connection, opts={"version_table": VERSION_TABLE, "compare_type": True}
        )
        assert compare_metadata(context, metadata) == []


def test_a_failing_migration_leaves_nothing_behind(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    where = tmp_path / "reviews.sqlite"
    with monkeypatch.context() as patch:
        # An index of that name makes the second table of the migration impossible.
        patch.setattr("alembic.op.create_table", _fail_at("journal"))
        with pytest.raises(RuntimeError, match="power cut"):
            Store(where)
    with closing(sqlite3.connect(where)) as raw:
        assert raw.execute("SELECT name FROM sqlite_master").fetchall() == []
    Store(where).close()


def test_only_one_of_two_migrates(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    where = tmp_path / "reviews.sqlite"
    begun, calls = threading.Event(), []
    upgrade = command.upgrade

    def slow(*arguments: str) -> None:
        calls.append(arguments)
        begun.set()
        time.sleep(0.3)
        upgrade(*arguments)

    def second() -> None:
        begun.wait()
        Store(where).close()

    monkeypatch.setattr(command, "upgrade", slow)
    with ThreadPoolExecutor() as pool:
        done = [pool.submit(lambda: Store(where).close()), pool.submit(second)]
        for future in done:
            future.result()
    assert len(calls) == 1


def stored(where: Path, schema: str) -> list[str]:
    """Make a store as a program of that schema left it, and give all that is in it."""
    with closing(sqlite3.connect(where)) as raw:
        raw.executescript((ASSETS / f"store-{schema}.sql").read_text(encoding="utf-8"))
        assert raw.execute(f"SELECT version_num FROM {VERSION_TABLE}").fetchall() == [(schema,)]
        return list(raw.iterdump())


@pytest.mark.parametrize("schema", REVISIONS[:-1])
def test_what_was_there_is_kept_before_a_schema_changes(tmp_path: Path, schema: str) -> None:
    where = tmp_path / "reviews.sqlite"
    before = stored(where, schema)
    Store(where).close()
    kept = tmp_path / f"reviews.schema-{schema}.sqlite"
    assert sorted(tmp_path.glob("*.sqlite")) == sorted([where, kept])
    with closing(sqlite3.connect(kept)) as raw:
        assert list(raw.iterdump()) == before
    Store(where).close()  # nothing changes any more, and nothing is copied
    assert len(list(tmp_path.glob("*.sqlite"))) == 2


def test_without_a_copy_no_schema_changes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    where = tmp_path / "reviews.sqlite"
    before = stored(where, REVISIONS[0])
    monkeypatch.setattr(database, "keep_before", _refuse)
    with pytest.raises(StoreError, match="cannot be written"):
        Store(where)
    with closing(sqlite3.connect(where)) as raw:
        assert list(raw.iterdump()) == before


def test_an_earlier_copy_is_never_replaced(tmp_path: Path) -> None:
    where = tmp_path / "reviews.sqlite"
    earlier = tmp_path / f"reviews.schema-{REVISIONS[0]}.sqlite"
    earlier.write_text("an earlier one")
    stored(where, REVISIONS[0])
    Store(where).close()
    assert earlier.read_text() == "an earlier one"
    assert (tmp_path / f"reviews.schema-{REVISIONS[0]}-2.sqlite").exists()


@pytest.mark.parametrize("schema", REVISIONS)
def test_a_store_of_every_schema_opens(tmp_path: Path, schema: str) -> None:
    where = tmp_path / "reviews.sqlite"
    stored(where, schema)
    with Store(where) as store:
        (take,) = store.takes()
        assert (take.name, take.n_frames, take.rate) == ("walk.c3d", 200, 100.0)
        assert (take.given_units, take.given_rate) == ("m", None)
        (record,) = store.reviews(take.sha256)
        assert (record.operator, record.purpose, record.status) == ("anna", "review", "open")
        session = ReviewSession(store, record)
        assert [step.command.describe() for step in session.history.steps] == [
            "Accept A gap 40-60 with savgol",
            "Reject 2 peak findings",
            "Set aside B step 100-110",
            "Choose rigid for B step 100-110",
            "Reclassify B step 100-110 as slow",
            "Move B step 100-110 to 98-112",
            "Note on B step 100-110",
            "Add A noise 150-160",
            "Split A noise 150-160 at 155",
            "Merge 2 noise findings",
            "Reopen A gap 40-60",
            "Remove A noise 150-160",
        ]
        assert session.history.position == 10
        counts = session.review.counts()
        assert (counts.accepted, counts.rejected, counts.deferred, counts.open) == (1, 2, 1, 1)
        (wish,) = session.review.accepted()
        assert (wish.marker, wish.span, wish.method) == ("A", Span(40, 60), "savgol")
        assert wish.parameters == {"order": 3, "window": 0.25, "mode": "ends", "robust": True}
        moved = next(j for j in session.review if j.finding.marker == "B")
        assert (moved.kind, moved.span, moved.decision.note) == ("slow", Span(98, 112), "elbow ä")
        assert [finding.span for finding in session.review.live() if finding.kind == "noise"] == [
            Span(150, 160)
        ]


def _refuse(*_: object) -> Path:
    raise StoreError("The backup cannot be written.")


def _fail_at(table: str):  # type: ignore[no-untyped-def]
    from alembic import op

    real = op.create_table

    def create_table(name: str, *columns: object) -> None:
        if name == table:
            raise RuntimeError("power cut")
        real(name, *columns)

    return create_table
