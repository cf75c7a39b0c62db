"""Exercises and grades in the store of reviews: the truth lies there and nowhere else."""

from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from sqlalchemy import select

from markermend import io
from markermend.errors import StoreError
from markermend.model import Span, Take
from markermend.review.schema import exercises, grades
from markermend.review.store import Store, default_operator
from markermend.train.exercise import Answer, Exercise, Place
from markermend.train.learning import Result
from markermend.train.marks import Grade


def keep(store: Store, exercise: Exercise) -> int:
    """Keep an exercise with its truth, under the hash of its take, and give its number.

    Raises
    ------
    StoreError
        If it cannot be written.
    """
    store.remember(exercise.take)
    return store.add_row(
        exercises,
        take=exercise.take.content_hash,
        made=datetime.now(UTC),
        content=_content(exercise),
    )


def hand_out(
    store: Store, exercise: Exercise, path: Path, *, overwrite: bool = False
) -> tuple[int, Exercise]:
    """Write the take of an exercise to a file for the trainee, and keep the truth in the store.

    Returns
    -------
    Number of the exercise, and the exercise on the take as it reads from the file.

    Raises
    ------
    CannotWrite
        If the file exists or the disk refuses.
    StoreError
        If the store cannot be used.
    """
    io.write(exercise.take, path, overwrite=overwrite)
    handed = exercise.on(io.read(path))
    return keep(store, handed), handed


def find(store: Store, sha256: str) -> int:
    """Give the number of the latest exercise on a take.

    Raises
    ------
    StoreError
        If there is none.
    """
    found = known(store, sha256)
    if found is None:
        raise StoreError(
            f"The store {store.where} knows no exercise on the take {sha256[:12]}; make one with "
            "markermend train, or give the store that it was made with."
        )
    return found


def known(store: Store, sha256: str) -> int | None:
    """Give the number of the latest exercise on a take, or None."""
    query = select(exercises.c.id).where(exercises.c.take == sha256).order_by(exercises.c.id.desc())
    found = store.rows(query.limit(1))
    return int(found[0].id) if found else None


def unseal(store: Store, number: int, take: Take) -> Exercise:
    """Give an exercise back with its truth, on the take that was handed out.

    Raises
    ------
    StoreError
        If there is no such exercise, or the take is another one.
    """
    rows = store.rows(select(exercises).where(exercises.c.id == number))
    if not rows:
        raise StoreError(f"The store {store.where} has no exercise {number}; make one first.")
    if rows[0].take != take.content_hash:
        raise StoreError(
            f"Exercise {number} was handed out as content {rows[0].take[:12]}, and this take has "
            f"content {take.content_hash[:12]}; give the file that was handed out."
        )
    return _exercise(take, rows[0].content)


def record(
    store: Store, number: int, result: Grade, trainee: str | None = None, *, helped: bool = False
) -> None:
    """Keep a grade; the learning curve takes the first one of each exercise.

    An exercise in which the trainee was `helped`, by feedback after each decision, is kept as all
    others and counts in no curve.
    """
    store.add_row(
        grades,
        exercise=number,
        trainee=trainee or default_operator(),
        at=datetime.now(UTC),
        result={**result.to_json(), "helped": helped},
    )


def results(store: Store, trainee: str | None = None) -> tuple[Result, ...]:
    """Give the first grade of each exercise and trainee, oldest first; of one trainee or all.

    Exercises whose first grade was reached with help are left out.
    """
    query = select(grades).order_by(grades.c.at, grades.c.id)
    if trainee is not None:
        query = query.where(grades.c.trainee == trainee)
    first: dict[tuple[int, str], Any] = {}
    for row in store.rows(query):
        first.setdefault((row.exercise, row.trainee), row)
    return tuple(
        Result.from_grade(row.trainee, row.exercise, row.at, row.result)
        for row in first.values()
        if not row.result.get("helped", False)
    )


def _content(exercise: Exercise) -> dict[str, Any]:
    return {
        **exercise.to_json(),
        "answers": [answer.to_json() for answer in exercise.answers],
        "neutral": [[p.marker, p.span.start, p.span.stop] for p in exercise.neutral],
    }


def _exercise(take: Take, content: dict[str, Any]) -> Exercise:
    return Exercise(
        take=take,
        level=content["level"],
        seed=content["seed"],
        kinds=tuple(content["kinds"]),
        amplitude_mm=content["amplitude_mm"],
        hidden=content["hidden"],
        answers=tuple(Answer.from_json(one) for one in content["answers"]),
        neutral=tuple(Place(m, Span(start, stop)) for m, start, stop in content["neutral"]),
    )
