"""Backups that can be gone back to, and a look at whether a store is whole."""

import re
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from markermend.errors import StoreError
from markermend.model import Finding, Span, Take
from markermend.review import Accept, Reject
from markermend.review.session import ReviewSession
from markermend.review.store import Store
from markermend.review.upkeep import check, restore

ASSETS = Path(__file__).with_name("assets")


def peak(n: int) -> Finding:
    return Finding("A", Span(n, n + 3), "peak")


@pytest.fixture
def where(tmp_path: Path) -> Path:
    return tmp_path / "lab" / "reviews.sqlite"


def decide(where: Path, take: Take, *numbers: int) -> None:
    with Store(where) as store:
        session = ReviewSession.open(store, take, "anna")
        for n in numbers:
            session.do(Accept((peak(n),)))


def decided(where: Path, take: Take) -> list[int]:
    with Store(where) as store:
        review = ReviewSession.open(store, take, "anna").review
    return [judgement.finding.span.start for judgement in review]


def test_a_whole_store_is_counted(store: Store, take: Take) -> None:
    for who in ("anna", "bo"):
        session = ReviewSession.open(store, take, who)
        session.do(Accept((peak(1),)))
        session.do(Reject((peak(9),)))
        session.undo()
    seen: list[tuple[int, int]] = []
    health = check(store, lambda done, total: seen.append((done, total)))
    assert (health.n_takes, health.n_reviews, health.n_lines) == (1, 2, 6)
    assert health.faults == ()
    assert seen == [(1, 2), (2, 2)]


@pytest.mark.parametrize(
    ("harm", "said"),
    [
        ("DELETE FROM journal WHERE seq = 1", "has 1 lines and ends with number 2"),
        ("UPDATE journal SET command = '{}' WHERE seq = 2", "Line 2 .* cannot be replayed"),
        ("DELETE FROM takes", "Row 1 of reviews .* belongs to nothing in takes"),
    ],
)
def test_what_is_broken_is_said(where: Path, take: Take, harm: str, said: str) -> None:
    decide(where, take, 1, 9)
    with closing(sqlite3.connect(where)) as raw:
        raw.execute(harm)
        raw.commit()
    with Store(where) as store:
        (fault,) = check(store).faults
        store.backup(where.with_name("broken.sqlite"))
    assert re.search(said, fault)
    other = where.with_name("other.sqlite")
    with pytest.raises(StoreError, match="is damaged and is not put back"):
        restore(where.with_name("broken.sqlite"), other)
    assert not other.exists()


def test_a_torn_page_is_seen(where: Path, take: Take) -> None:
    decide(where, take, *range(60))
    with closing(sqlite3.connect(where)) as raw:
        raw.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        size = raw.execute("PRAGMA page_size").fetchone()[0]
        page = raw.execute("SELECT rootpage FROM sqlite_master WHERE name='journal'").fetchone()[0]
    content = bytearray(where.read_bytes())
    content[(page - 1) * size : (page - 1) * size + 64] = b"\xff" * 64
    where.write_bytes(content)
    with pytest.raises(StoreError, match="is damaged"), Store(where) as store:
        raise StoreError("; ".join(check(store).faults))


def test_back_to_a_backup_and_back_again(where: Path, take: Take, tmp_path: Path) -> None:
    decide(where, take, 1, 9)
    with Store(where) as store:
        store.backup(tmp_path / "monday.sqlite")
    decide(where, take, 20)
    kept = restore(tmp_path / "monday.sqlite", where)
    assert decided(where, take) == [1, 9]
    assert kept == where.with_name("reviews.replaced.sqlite")
    assert decided(kept, take) == [1, 9, 20]
    assert restore(kept, where) == where.with_name("reviews.replaced-2.sqlite")
    assert decided(where, take) == [1, 9, 20]


def test_a_store_in_use_is_restored_under_its_users(
    where: Path, take: Take, tmp_path: Path
) -> None:
    with Store(where) as store:
        session = ReviewSession.open(store, take, "anna")
        session.do(Accept((peak(1),)))
        store.backup(tmp_path / "monday.sqlite")
        session.do(Accept((peak(9),)))
        restore(tmp_path / "monday.sqlite", where)
        with pytest.raises(StoreError, match="went back to a backup"):
            session.do(Accept((peak(20),)))
        again = ReviewSession(store, session.record)
        again.do(Accept((peak(30),)))
        assert check(store).faults == ()
    assert decided(where, take) == [1, 30]


def test_a_backup_of_an_older_schema_is_brought_up_to_date(where: Path, tmp_path: Path) -> None:
    old = tmp_path / "old.sqlite"
    with closing(sqlite3.connect(old)) as raw:
        raw.executescript((ASSETS / "store-0001.sql").read_text(encoding="utf-8"))
    before = old.read_bytes()
    assert restore(old, where) is None
    assert old.read_bytes() == before
    with Store(where) as store:
        assert check(store).n_reviews == 1


def test_what_is_no_backup_is_refused(where: Path, take: Take, tmp_path: Path) -> None:
    decide(where, take, 1)
    (tmp_path / "notes.txt").write_text("no database at all " * 100)
    with pytest.raises(StoreError, match=r"notes.txt is damaged or no store"):
        restore(tmp_path / "notes.txt", where)
    with pytest.raises(StoreError, match="There is no backup"):
        restore(tmp_path / "absent.sqlite", where)
    with pytest.raises(StoreError, match="is the store itself"):
        restore(where, where)
    with pytest.raises(StoreError, match=r"on a server.*pg_restore"):
        restore(where, "postgresql://lab/reviews")
    assert decided(where, take) == [1]
