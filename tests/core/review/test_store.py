"""Takes by content, reviews by operator, and every way in which a store can refuse."""

import sqlite3
import subprocess
import sys
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from sqlalchemy import event, text

from markermend.errors import Conflict, StoreError
from markermend.model import Finding, Source, Span, Take
from markermend.review import Accept
from markermend.review import database as database_module
from markermend.review.database import locate, shown
from markermend.review.schema import REVISIONS
from markermend.review.session import ReviewSession
from markermend.review.store import Store, default_operator


def at(take: Take, path: Path, content: str = "a") -> Take:
    return replace(take, source=Source(path, "c3d", content * 64, "mm", take.rate))


def test_a_take_is_known_by_its_content(store: Store, take: Take, tmp_path: Path) -> None:
    session = ReviewSession.open(store, at(take, tmp_path / "walk.c3d"), "anna")
    session.do(Accept((Finding("A", Span(1, 2), "peak"),)))
    moved = at(take, tmp_path / "sub" / "walk-renamed.c3d")
    assert store.changed_since(tmp_path / "sub" / "walk-renamed.c3d", "a" * 64) is None
    assert ReviewSession.open(store, moved, "anna").review == session.review
    (record,) = store.takes()
    assert (record.name, record.path) == ("walk-renamed.c3d", moved.source.path)  # type: ignore[union-attr]
    assert record.first_seen < record.last_seen


def test_a_changed_take_is_told_and_starts_another(
    store: Store, take: Take, tmp_path: Path
) -> None:
    path = tmp_path / "walk.c3d"
    first = ReviewSession.open(store, at(take, path), "anna")
    first.do(Accept((Finding("A", Span(1, 2), "peak"),)))
    assert store.changed_since(path, "a" * 64) is None
    changed = store.changed_since(path, "b" * 64)
    assert changed is not None
    assert changed.sha256 == "a" * 64
    assert len(ReviewSession.open(store, at(take, path, "b"), "anna").review) == 0
    assert store.changed_since(path, "b" * 64) is None
    assert [record.sha256[0] for record in store.takes()] == ["b", "a"]
    assert [record.sha256[0] for record in store.takes(limit=1)] == ["b"]


def test_what_a_take_lacked_is_remembered(store: Store, take: Take) -> None:
    store.remember(take, given_units="m", given_rate=120.0)
    store.remember(take)
    record = store.take(take.content_hash)
    assert record is not None
    assert (record.given_units, record.given_rate, record.path) == ("m", 120.0, None)
    assert store.take("f" * 64) is None


def test_a_path_that_is_no_text_is_kept(store: Store, take: Take) -> None:
    path = Path("/takes/walk\udce9.c3d")
    store.remember(at(take, path))
    assert store.changed_since(path, "b" * 64) is not None


def test_operators_and_purposes_have_reviews_of_their_own(store: Store, take: Take) -> None:
    anna = ReviewSession.open(store, take, "anna")
    anna.do(Accept((Finding("A", Span(1, 2), "peak"),)))
    bo = ReviewSession.open(store, take, "bo")
    second = ReviewSession.open(store, take, "anna", purpose="second")
    assert len(bo.review) == len(second.review) == 0
    found = store.reviews(take.content_hash)
    assert [(r.operator, r.purpose, r.status) for r in found] == [
        ("anna", "review", "open"),
        ("bo", "review", "open"),
        ("anna", "second", "open"),
    ]
    bo.set_status("finished")
    assert [r.status for r in store.reviews()] == ["open", "finished", "open"]
    assert store.review(take.content_hash, "bo").id == bo.record.id


def test_a_review_of_a_take_never_opened_is_refused(store: Store) -> None:
    with pytest.raises(StoreError, match="does not know the take ffffffffffff; open it"):
        store.review("f" * 64)


def test_two_stores_on_one_file_see_each_other_and_conflict(store: Store, take: Take) -> None:
    mine = ReviewSession.open(store, take, "anna")
    with Store(store.where) as other:
        theirs = ReviewSession.open(other, take, "anna")
        theirs.do(Accept((Finding("A", Span(1, 2), "peak"),)))
        with pytest.raises(Conflict, match="changed in another window"):
            mine.do(Accept((Finding("A", Span(5, 6), "peak"),)))
        assert len(mine.review) == 0
        mine.refresh()
        mine.do(Accept((Finding("A", Span(5, 6), "peak"),)))
        assert theirs.refresh().after == mine.review


def test_lines_are_appended_all_or_none(store: Store, take: Take) -> None:
    review = ReviewSession.open(store, take, "anna").record.id
    store.append(review, 0, [("do", {"a": 1})], "anna")
    with pytest.raises(Conflict):
        store.append(review, 0, [("do", {"a": 2}), ("undo", None)], "bo")
    (entry,) = store.entries(review)
    assert (entry.seq, entry.action, entry.command, entry.operator) == (1, "do", {"a": 1}, "anna")
    assert store.entries(review, after=1) == ()


def test_a_backup_is_a_store(file_store: Store, take: Take, tmp_path: Path) -> None:
    session = ReviewSession.open(file_store, take, "anna")
    session.do(Accept((Finding("A", Span(1, 2), "peak"),)))
    target = tmp_path / "backup.sqlite"
    target.write_text("an older backup")
    file_store.backup(target)
    session.undo()
    with Store(target) as restored:
        assert ReviewSession.open(restored, take, "anna").history.position == 1
    assert sorted(p.name for p in tmp_path.glob("*.part")) == []


def test_a_backup_that_cannot_be_written_is_refused(file_store: Store, tmp_path: Path) -> None:
    with pytest.raises(StoreError, match="is the store itself"):
        file_store.backup(file_store.where)
    with pytest.raises(StoreError, match="cannot be written"):
        file_store.backup(tmp_path / "absent" / "backup.sqlite")


def test_where_it_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MARKERMEND_STORE", str(tmp_path / "by-variable.sqlite"))
    assert shown(locate()) == str(tmp_path / "by-variable.sqlite")
    assert shown(locate(tmp_path / "given.sqlite")) == str(tmp_path / "given.sqlite")
    assert shown(locate(tmp_path)) == str(tmp_path / "reviews.sqlite")
    monkeypatch.delenv("MARKERMEND_STORE")
    assert shown(locate()).endswith("reviews.sqlite")
    assert "markermend" in shown(locate())


@pytest.mark.parametrize("scheme", ["postgresql", "postgres", "postgresql+psycopg"])
def test_a_password_is_never_shown(scheme: str) -> None:
    url = locate(f"{scheme}://anna:secret@lab/reviews")
    assert shown(url) == "postgresql+psycopg://anna:***@lab/reviews"
    assert shown(
        locate(f"{scheme}://lab/reviews?user=anna&password=secret&sslpassword=secret")
    ) == ("postgresql+psycopg://lab/reviews?password=hidden&sslpassword=hidden&user=anna")


def test_a_store_makes_its_folder(tmp_path: Path) -> None:
    with Store(tmp_path / "new" / "folder" / "my%20#store?.sqlite") as store:
        assert Path(store.where).is_file()


def test_the_operator_has_a_name(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MARKERMEND_OPERATOR", "anna")
    assert default_operator() == "anna"
    monkeypatch.delenv("MARKERMEND_OPERATOR")
    monkeypatch.setenv("LOGNAME", "bo")
    assert default_operator() == "bo"


def refuse(where: str | Path, match: str) -> None:
    with pytest.raises(StoreError, match=match) as caught:
        Store(where)
    assert "\n" not in str(caught.value)
    assert str(caught.value).endswith(".")


def test_a_file_that_is_no_database_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "notes.txt"
    path.write_text("not a database at all " * 100)
    refuse(path, "is damaged or no store of reviews")
    assert path.read_text().startswith("not a database")


def test_a_database_of_another_program_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "places.sqlite"
    with closing(sqlite3.connect(path)) as database:
        database.execute("CREATE TABLE bookmarks (url TEXT)")
    refuse(path, "is a database of another program")


def test_a_newer_store_is_refused(store: Store) -> None:
    change = text("UPDATE markermend_schema SET version_num = :version")
    with store.transaction() as connection:
        connection.execute(change, {"version": "9999"})
    refuse(store.where, "written by a newer version.*schema 9999.*update markermend")
    with store.transaction() as connection:
        connection.execute(change, {"version": REVISIONS[-1]})


def test_a_folder_that_cannot_be_made_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    refuse(tmp_path / "file" / "reviews.sqlite", "cannot be made.*choose another place")


def test_a_store_that_cannot_be_written_is_refused(file_store: Store, take: Take) -> None:
    with (
        Store(f"sqlite:///file:{file_store.where}?mode=ro&uri=true") as frozen,
        pytest.raises(StoreError, match="cannot be written; choose another place"),
    ):
        frozen.remember(take)


def test_an_address_that_is_none_is_refused() -> None:
    refuse("://", "is no database URL")
    refuse("nosuch://lab/reviews", "driver that is not installed")
    refuse("postgresql+asyncpg://lab/reviews", "driver that is not installed")


def test_a_busy_store_is_waited_for_and_then_refused(
    file_store: Store, take: Take, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(database_module, "BUSY_S", 0.05)
    file_store._engine.dispose()  # the wait is set when a connection is made
    with closing(sqlite3.connect(file_store.where, isolation_level=None)) as other:
        other.execute("BEGIN IMMEDIATE")
        with pytest.raises(StoreError, match="in use by another program"):
            file_store.remember(take)
        other.execute("ROLLBACK")
    file_store.remember(take)


def test_commits_are_made_to_last(file_store: Store) -> None:
    settings: list[tuple[str, int]] = []

    def look(connection: sqlite3.Connection, _: object) -> None:
        mode = connection.execute("PRAGMA journal_mode").fetchone()[0]
        settings.append((mode, connection.execute("PRAGMA synchronous").fetchone()[0]))

    event.listen(file_store._engine, "connect", look)
    file_store._engine.dispose()
    file_store.takes()
    assert settings == [("wal", 2)]  # 2 is FULL


def run_python(code: str, *arguments: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-W", "error", "-c", code, *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def test_several_processes_may_make_the_store_at_once(tmp_path: Path) -> None:
    code = "import sys; from markermend.review.store import Store; Store(sys.argv[1]).takes()"
    children = [run_python(code, str(tmp_path / "reviews.sqlite")) for _ in range(3)]
    said = [child.communicate(timeout=60)[1] for child in children]
    assert [(child.returncode, error) for child, error in zip(children, said, strict=True)] == [
        (0, "")
    ] * 3


def test_what_is_slow_is_imported_only_when_needed(store: Store) -> None:
    child = run_python(
        "import sys, markermend.review; print('sqlalchemy' in sys.modules);"
        "from markermend.review.store import Store; Store(sys.argv[1]).close();"
        "print('sqlalchemy' in sys.modules, 'alembic' in sys.modules)",
        store.where,
    )
    assert child.communicate(timeout=60) == ("False\nTrue False\n", "")


@pytest.mark.parametrize("seed", range(4))
def test_a_killed_process_loses_nothing_acknowledged(
    store: Store, take: Take, tmp_path: Path, seed: int
) -> None:
    """The child says a number after each command and each undo; then it is killed at any time."""
    np.savez(tmp_path / "take.npz", positions=take.positions)
    child = run_python(
        "import sys, numpy as np\n"
        "from markermend.model import Finding, Span, Take\n"
        "from markermend.review import Accept\n"
        "from markermend.review.session import ReviewSession\n"
        "from markermend.review.store import Store\n"
        "take = Take(np.load(sys.argv[2])['positions'], 100., ('A', 'B'))\n"
        "session = ReviewSession.open(Store(sys.argv[1]), take, 'anna')\n"
        "for n in range(1_000_000):\n"
        "    session.do(Accept((Finding('A', Span(n, n + 1), 'peak'),), 'pchip', {'n': n}))\n"
        "    print(len(session.history.steps), session.history.position, flush=True)\n"
        "    if n % 3 == 2:\n"
        "        session.undo()\n"
        "        print(len(session.history.steps), session.history.position, flush=True)\n",
        store.where,
        str(tmp_path / "take.npz"),
    )
    assert child.stdout is not None
    wanted = int(np.random.default_rng(seed).integers(1, 60))
    acknowledged = [child.stdout.readline() for _ in range(wanted)]
    child.kill()
    rest, error = child.communicate(timeout=60)
    assert error == ""
    acknowledged += rest.splitlines()

    with Store(store.where) as reopened:
        session = ReviewSession.open(reopened, take, "anna")
        entries = reopened.entries(session.record.id)
    assert len(acknowledged) <= len(entries) <= len(acknowledged) + 1
    expected: list[int] = []
    n = 0
    for entry in entries:  # what the child did, told again without our code
        if entry.action == "undo":
            expected.pop()
        else:
            expected.append(n)
            n += 1
    assert [j.finding.span.start for j in session.review] == expected
