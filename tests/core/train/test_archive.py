import sqlite3
from collections.abc import Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from markermend.errors import CannotWrite, StoreError
from markermend.model import Span, Take
from markermend.review.store import Store
from markermend.train import archive, grade, make_exercise
from markermend.train.learning import Tally

from .conftest import accepting, review_of, swinging

SCHEMAS = Path(__file__).parents[1] / "review" / "assets"
CLEAN = swinging()


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    with Store(tmp_path / "kept" / "reviews.sqlite") as opened:
        yield opened


def test_an_exercise_comes_back_with_its_truth(store: Store, tmp_path: Path) -> None:
    made = make_exercise(CLEAN, 7, 3, hidden=True)
    folder = tmp_path / "for the trainee"
    folder.mkdir()
    number, handed = archive.hand_out(store, made, folder / "exercise.c3d")
    assert archive.find(store, handed.take.content_hash) == number
    back = archive.unseal(store, number, handed.take)
    assert back.truths == made.truths
    assert (back.level, back.seed, back.kinds, back.hidden) == (7, 3, made.kinds, True)
    np.testing.assert_allclose(back.clean.positions, CLEAN.positions, atol=1e-3)
    assert [path.name for path in folder.iterdir()] == ["exercise.c3d"]


def test_what_nobody_knows_of_the_truth_comes_back_unknown(store: Store) -> None:
    made = make_exercise(CLEAN, 2, 3)
    unknown = replace(made.answers[0], values=np.full_like(made.answers[0].values, np.nan))
    number = archive.keep(store, replace(made, answers=(unknown,)))
    back = archive.unseal(store, number, made.take)
    assert np.isnan(back.answers[0].values).all()
    np.testing.assert_array_equal(back.clean.positions, made.take.positions)
    result = grade(back, accepting(back.truths), methods=())
    assert result.marks[0].repaired is not None
    assert result.marks[0].outcome == "right"


def test_only_the_first_grade_of_an_exercise_counts(store: Store) -> None:
    made = make_exercise(CLEAN, 2, 3)
    number = archive.keep(store, made)
    first = grade(made, review_of([]), methods=())
    second = grade(made, accepting(made.truths), methods=())
    archive.record(store, number, first, "ben")
    archive.record(store, number, second, "ben")
    archive.record(store, number, second, "anna")
    ben, anna = archive.results(store)
    assert (ben.trainee, ben.tallies["peak"]) == ("ben", Tally(4, 0, 0, 0))
    assert (anna.trainee, anna.tallies["peak"]) == ("anna", Tally(4, 4, 4, 0))
    assert archive.results(store, "anna") == (anna,)
    assert archive.results(store, "nobody") == ()


def test_an_exercise_done_with_help_counts_in_no_curve(store: Store) -> None:
    made = make_exercise(CLEAN, 2, 3)
    number = archive.keep(store, made)
    result = grade(made, accepting(made.truths), methods=())
    archive.record(store, number, result, "ben", helped=True)
    archive.record(store, number, result, "ben")  # once more, knowing the answers
    archive.record(store, number, result, "anna")
    assert [one.trainee for one in archive.results(store)] == ["anna"]


def test_the_latest_exercise_on_a_take_is_meant(store: Store) -> None:
    made = make_exercise(CLEAN, 2, 3)
    archive.keep(store, made)
    second = archive.keep(store, replace(made, hidden=True))
    assert archive.find(store, made.take.content_hash) == second
    assert archive.unseal(store, second, made.take).hidden


def test_other_takes_and_other_stores_are_refused(store: Store, tmp_path: Path) -> None:
    made = make_exercise(CLEAN, 2, 3)
    number = archive.keep(store, made)
    with pytest.raises(StoreError, match="knows no exercise on the take"):
        archive.find(store, CLEAN.content_hash)
    with pytest.raises(StoreError, match="give the file that was handed out"):
        archive.unseal(store, number, CLEAN)
    with pytest.raises(StoreError, match="has no exercise 77"):
        archive.unseal(store, 77, made.take)
    path = tmp_path / "there.c3d"
    path.write_bytes(b"mine")
    with pytest.raises(CannotWrite, match="exists"):
        archive.hand_out(store, made, path)
    assert path.read_bytes() == b"mine"


def opened(tmp_path: Path, schema: str) -> Store:
    where = tmp_path / f"{schema}.sqlite"
    with closing(sqlite3.connect(where)) as raw:
        raw.executescript((SCHEMAS / f"store-{schema}.sql").read_text(encoding="utf-8"))
    return Store(where)


def test_a_store_from_before_there_were_exercises_takes_them(tmp_path: Path) -> None:
    with opened(tmp_path, "0001") as store:
        assert archive.results(store) == ()
        made = make_exercise(CLEAN, 2, 3)
        number = archive.keep(store, made)
        archive.record(store, number, grade(made, review_of([]), methods=()), "anna")
        assert [r.trainee for r in archive.results(store)] == ["anna"]
        assert len(store.reviews()) == 1


def test_exercises_and_grades_of_the_second_schema_are_read(tmp_path: Path) -> None:
    with opened(tmp_path, "0002") as store:
        (result,) = archive.results(store, "anna")
        assert (result.level, result.tallies["peak"]) == (2, Tally(1, 1, 2, 1))
        assert (result.before_mm, result.after_mm, result.worse) == (20.0, 1.5, False)
        number = archive.find(store, "a1" * 32)
        known = store.take("a1" * 32)
        assert known is not None
        take = Take(np.zeros((200, 2, 3)), 100, ["A", "B"])
        object.__setattr__(take, "content_hash", known.sha256)
        exercise = archive.unseal(store, number, take)
        (answer,) = exercise.answers
        assert (answer.marker, answer.span, answer.kind) == ("A", Span(50, 52), "peak")
        assert np.isnan(answer.values[1, 1])
        assert exercise.neutral[0].span == Span(10, 20)
