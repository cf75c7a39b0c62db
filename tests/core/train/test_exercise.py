import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from markermend.errors import BadInput, BadParameter, UnknownName
from markermend.model import KINDS, Source, Span, Take
from markermend.train import LEVELS, exercise_from_review, grade, make_exercise
from markermend.train.placing import GUARD_S, LEAST

from .conftest import judged, review_of, swinging

CLEAN = swinging()


@settings(max_examples=25, deadline=None)
@given(
    level=st.integers(1, len(LEVELS)),
    seed=st.integers(0, 2**32 - 1),
    kinds=st.one_of(st.none(), st.sets(st.sampled_from(KINDS), min_size=1)),
)
def test_only_the_truth_is_wrong_with_an_exercise(
    level: int, seed: int, kinds: set[str] | None
) -> None:
    exercise = make_exercise(CLEAN, level, seed, kinds=kinds)
    wrong = np.zeros((CLEAN.n_frames, CLEAN.n_markers), bool)
    for answer in exercise.answers:
        m = CLEAN.index(answer.marker)
        guard = answer.span.padded(round(GUARD_S * CLEAN.rate), CLEAN.n_frames)
        assert not wrong[guard.frames, m].any()
        wrong[answer.span.frames, m] = True
    same = (exercise.take.positions == CLEAN.positions).all(axis=2)
    assert same[~wrong].all()
    np.testing.assert_array_equal(exercise.clean.positions, CLEAN.positions)
    row = LEVELS[level - 1]
    wanted = row.kinds if kinds is None else tuple(kind for kind in KINDS if kind in kinds)
    counts = [sum(t.kind == kind for t in exercise.truths) for kind in wanted]
    assert sum(counts) == row.artefacts
    assert max(counts) - min(counts) <= 1
    sizes = [t.amplitude for t in exercise.truths if t.kind != "gap"]
    assert all(size is not None and size >= LEAST * row.amplitude_mm - 1e-3 for size in sizes)


def test_the_same_seed_is_the_same_exercise() -> None:
    one, same, other = (make_exercise(CLEAN, 7, seed) for seed in (3, 3, 4))
    assert one.take.content_hash == same.take.content_hash != other.take.content_hash
    assert one.truths == same.truths != other.truths


def test_without_a_take_a_simulated_person_moves() -> None:
    exercise = make_exercise(level=1, seed=2)
    assert (exercise.take.n_markers, exercise.take.duration_s) == (53, 8.0)
    (truth,) = exercise.truths
    m, frames = exercise.take.index(truth.marker), truth.span.frames
    off = exercise.take.positions[frames, m] - exercise.clean.positions[frames, m]
    assert np.linalg.norm(off, axis=1).max() == pytest.approx(truth.amplitude, rel=1e-3)


def test_what_a_trainee_may_see_says_nothing_of_the_truth() -> None:
    exercise = make_exercise(CLEAN, 9, 1)
    told = json.dumps(exercise.to_json()) + repr(exercise)
    assert not any(f'"{t.marker}"' in told or repr(t.span) in told for t in exercise.truths)
    assert set(exercise.to_json()) == {"take", "level", "seed", "kinds", "amplitude_mm", "hidden"}


def test_the_take_of_an_exercise_is_not_taken_for_the_recording() -> None:
    source = Source(Path("walk.c3d"), "c3d", "f" * 64, "mm", 100.0)
    exercise = make_exercise(replace(CLEAN, source=source), 2, 1)
    assert exercise.take.source is None
    assert exercise.take.content_hash != "f" * 64


def test_a_trainee_is_shown_what_the_detector_finds_or_nothing() -> None:
    exercise = make_exercise(CLEAN, 3, 5, amplitude_mm=40.0)
    shown = exercise.shown("published")
    gaps = {(t.marker, t.span) for t in exercise.truths if t.kind == "gap"}
    assert gaps <= {(f.marker, f.span) for f in shown}
    assert any(f.kind == "peak" for f in shown)
    assert replace(exercise, hidden=True).shown("published") == ()


def test_density_is_artefacts_a_minute() -> None:
    exercise = make_exercise(CLEAN, 7, 1, density=80)  # the take lasts a quarter of a minute
    assert len(exercise.answers) == 20


@pytest.mark.parametrize(
    ("arguments", "error", "says"),
    [
        ({"level": 0}, BadParameter, "level must be a whole number in 1 to 9; got 0"),
        ({"level": 10}, BadParameter, "got 10"),
        ({"kinds": ["hole"]}, UnknownName, "no kind 'hole'"),
        ({"kinds": []}, BadInput, "kinds is empty"),
        ({"amplitude_mm": 0.0}, BadParameter, "amplitude_mm must be above 0"),
        ({"amplitude_mm": float("nan")}, BadParameter, "amplitude_mm"),
        ({"density": -1.0}, BadParameter, "density must be above 0"),
        ({"level": 7, "density": 600.0}, BadInput, "room for .* artefacts of the 150.*--density"),
    ],
)
def test_impossible_exercises_are_refused(
    arguments: dict[str, object], error: type[Exception], says: str
) -> None:
    with pytest.raises(error, match=says):
        make_exercise(CLEAN, **arguments)  # type: ignore[arg-type]


def test_a_take_without_markers_or_too_short_is_refused() -> None:
    with pytest.raises(BadInput, match="no measured marker"):
        make_exercise(Take(np.zeros((500, 1, 3)), 100, ["*1"]), 1)
    with pytest.raises(BadInput, match="room for 0"):
        make_exercise(Take(np.zeros((40, 1, 3)), 100, ["A"]), 1)


def test_gaps_that_a_lab_take_has_already_are_not_graded() -> None:
    positions = CLEAN.positions.copy()
    positions[100:140, 3] = np.nan
    exercise = make_exercise(CLEAN.with_positions(positions), 2, 1)
    filled = review_of([judged("M3", Span(100, 140), "gap")])
    result = grade(exercise, filled, methods=())
    assert result.count("invented") == 0
    assert result.count("missed") == len(exercise.answers)


def test_an_experts_review_is_an_exercise_that_the_expert_solves() -> None:
    dirty = make_exercise(CLEAN, 5, 8)
    truths = dirty.truths
    expert = review_of(
        [
            *(judged(t.marker, t.span, t.kind, method="rigid") for t in truths[:3]),
            judged("M11", Span(700, 720), "step", "rejected"),
            judged("M10", Span(300, 310), "noise", None),
        ]
    )
    exercise = exercise_from_review(dirty.take, expert, hidden=True)
    assert (exercise.level, exercise.hidden) == (0, True)
    assert {(t.marker, t.span, t.kind) for t in exercise.truths} == {
        (t.marker, t.span, t.kind) for t in truths[:3]
    }
    own = grade(exercise, expert, methods=())
    assert [m.outcome for m in own.marks].count("right") == 3
    assert own.count("dismissed") == 1
    assert own.rmse_after_mm == pytest.approx(0.0, abs=1e-9)
    hasty = review_of(
        [
            judged("M11", Span(700, 720), "step"),  # which the expert rejected
            judged("M10", Span(300, 310), "noise"),  # which the expert left open
        ]
    )
    result = grade(exercise, hasty, methods=())
    assert (result.count("invented"), result.count("missed")) == (1, 3)


def test_a_review_that_accepts_nothing_is_no_exercise() -> None:
    with pytest.raises(BadInput, match="accepts nothing"):
        exercise_from_review(CLEAN, review_of([]))
