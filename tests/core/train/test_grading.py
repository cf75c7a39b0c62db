"""Simulated trainees of known skill get the scores that theory gives them."""

import json
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import binomtest

from markermend.evaluate.scores import overall_mcc
from markermend.model import Kind, Span, Take
from markermend.review import Review
from markermend.train import COLUMNS, ROWS, Exercise, grade, make_exercise
from markermend.train.exercise import Answer
from markermend.truth import Truth

from .conftest import accepting, judged, review_of, swinging

KINDS: tuple[Kind, ...] = ("peak", "noise", "step", "slow")
CLEAN = swinging(6, 3000)
MANY = make_exercise(CLEAN, 7, 5, kinds=KINDS, density=300)


def cell(matrix: tuple[tuple[int, ...], ...], row: str, column: str) -> int:
    return matrix[ROWS.index(row)][COLUMNS.index(column)]


def test_a_perfect_trainee_gets_everything() -> None:
    result = grade(MANY, accepting(MANY.truths, "rigid"), methods=())
    assert {mark.outcome for mark in result.marks} == {"right"}
    for kind in KINDS:
        score = result.kinds[kind]
        assert (score.sensitivity, score.false_discovery, score.iou) == (1.0, 0.0, 1.0)
        assert score.mcc == pytest.approx(1.0)
        assert cell(result.matrix, kind, kind) == score.true
    assert sum(map(sum, result.matrix)) == len(MANY.answers)
    assert result.rmse_before_mm is not None
    assert result.rmse_after_mm is not None
    assert result.rmse_after_mm < result.rmse_before_mm
    assert not result.worse


def test_nobody_gets_nothing_and_leaves_the_take_as_it_was() -> None:
    result = grade(MANY, review_of([]), methods=())
    assert {mark.outcome for mark in result.marks} == {"missed"}
    assert all(score.sensitivity == 0.0 for score in result.kinds.values())
    assert all(score.false_discovery is None for score in result.kinds.values())
    assert result.rmse_after_mm == result.rmse_before_mm
    assert not result.worse
    assert "as wrong as it was" in result.verdict


def test_a_random_trainee_does_as_chance_does() -> None:
    rng = np.random.default_rng(2)
    noticed = 0.6
    said = [
        judged(t.marker, t.span, KINDS[int(rng.integers(4))])
        for t in MANY.truths
        if rng.random() < noticed
    ]
    result = grade(MANY, review_of(said), methods=())
    n = len(MANY.answers)
    found = sum(score.found for score in result.kinds.values())
    assert found == len(said)
    assert binomtest(found, n, noticed).pvalue > 1e-3
    assert binomtest(result.count("right"), n, noticed / 4).pvalue > 1e-3
    wrong = sum(score.wrong for score in result.kinds.values())
    assert wrong == len(said) - result.count("right")
    # Names drawn without looking carry no information: the correlation is 0 but for chance.
    named = np.array(result.matrix)[1:5, 1:5]
    assert abs(overall_mcc(named) or 0.0) < 4 / np.sqrt(found)


def test_a_trainee_who_marks_anything_anywhere_is_at_zero() -> None:
    rng = np.random.default_rng(8)
    busy = {label: [] for label in CLEAN.labels}  # type: ignore[var-annotated]
    said = []
    while len(said) < 60:
        marker = CLEAN.labels[int(rng.integers(CLEAN.n_markers))]
        start = int(rng.integers(0, 2900))
        span = Span(start, start + int(rng.integers(20, 80)))
        if not any(span.overlaps(other) for other in busy[marker]):
            busy[marker].append(span)
            said.append(judged(marker, span, KINDS[int(rng.integers(4))]))
    result = grade(MANY, review_of(said), methods=())
    touching = [
        s
        for s in said
        if any(s.finding.marker == t.marker and s.span.overlaps(t.span) for t in MANY.truths)
    ]
    assert result.count("invented") == len(said) - len(touching)
    for kind in KINDS:
        mcc = result.kinds[kind].mcc
        assert mcc is not None
        assert abs(mcc) < 0.1


def test_a_trainee_who_misses_small_peaks_misses_just_those() -> None:
    peaks = [t for t in MANY.truths if t.kind == "peak"]
    limit = float(np.median([t.amplitude or 0.0 for t in peaks]))
    review = accepting(
        MANY.truths, which=lambda t: t.kind != "peak" or (t.amplitude or 0.0) >= limit
    )
    result = grade(MANY, review, methods=())
    small = sum((t.amplitude or 0.0) < limit for t in peaks)
    assert 0 < small < len(peaks)
    assert result.kinds["peak"].sensitivity == 1.0 - small / len(peaks)
    assert all(result.kinds[k].sensitivity == 1.0 for k in KINDS if k != "peak")
    assert cell(result.matrix, "peak", "missed") == small == result.count("missed")


def test_a_trainee_who_always_draws_a_line_has_the_error_of_the_line() -> None:
    result = grade(MANY, accepting(MANY.truths, "linear"), methods=())
    before, after = [], []
    for mark in result.marks:
        truth = CLEAN.positions[mark.span.frames, CLEAN.index(mark.marker)]
        edges = [mark.span.start - 1, mark.span.stop]
        frames = np.arange(mark.span.start, mark.span.stop)
        ends = CLEAN.positions[edges, CLEAN.index(mark.marker)]
        line = np.stack([np.interp(frames, edges, ends[:, a]) for a in range(3)], axis=1)
        off = np.linalg.norm(line - truth, axis=1)
        assert mark.repaired is not None
        assert mark.repaired.error_mm == pytest.approx(off.mean())
        given = MANY.take.positions[mark.span.frames, CLEAN.index(mark.marker)]
        before.append(np.square(given - truth).sum(axis=1))
        after.append(np.square(off))
    assert result.rmse_before_mm == pytest.approx(np.sqrt(np.concatenate(before).mean()))
    assert result.rmse_after_mm == pytest.approx(np.sqrt(np.concatenate(after).mean()))
    assert result.worse == (result.rmse_after_mm > result.rmse_before_mm)


def test_the_best_and_the_recommended_repair_stand_beside_the_trainees() -> None:
    exercise = make_exercise(swinging(), 5, 8, kinds=["slow"], density=8)
    result = grade(exercise, accepting(exercise.truths, "linear"), methods=("linear", "rigid"))
    assert len(result.marks) == 2
    for mark in result.marks:
        done = mark.repaired
        assert done is not None
        assert done.error_mm is not None
        assert done.best_mm is not None
        assert done.best == done.recommended == "rigid"
        assert done.best_mm < 0.5 < done.error_mm
        assert "Linear left" in mark.why
        assert "rigid would have left" in mark.why
    score = result.kinds["slow"]
    assert score.best_mm == pytest.approx(np.mean([m.repaired.best_mm for m in result.marks]))  # type: ignore[union-attr]


def test_a_repair_that_brings_in_something_new_is_told() -> None:
    whole = make_exercise(level=6, seed=4)
    answer = next(a for a in whole.answers if a.kind == "step" and a.marker == "RUPA")
    exercise = replace(whole, answers=(answer,)).on(
        whole.clean.with_positions(
            np.where(
                only(whole.take, answer)[:, :, None], whole.take.positions, whole.clean.positions
            )
        )
    )
    truths = exercise.truths
    spoiled = grade(exercise, accepting(truths, "linear"), methods=("linear",)).marks[0]
    mended = grade(exercise, accepting(truths, "unstep"), methods=("linear",)).marks[0]
    assert spoiled.repaired is not None
    assert mended.repaired is not None
    assert spoiled.repaired.new_artefacts
    assert "something new" in spoiled.why
    assert mended.repaired.new_artefacts == ()


def only(take: Take, answer: Answer) -> np.ndarray:
    """Where one artefact is."""
    there = np.zeros((take.n_frames, take.n_markers), bool)
    there[answer.span.frames, take.index(answer.marker)] = True
    return there


@dataclass(frozen=True)
class At:
    at: datetime | None
    operator: str = "ben"


def flat(n_frames: int = 400) -> Take:
    """Markers at rest, so that every error is what was put in."""
    return Take(np.ones((n_frames, 3, 3)) * 100.0, 100, ["A", "B", "C"])


def small_exercise() -> Exercise:
    """A peak of one frame, a step of 40 frames and a gap."""
    take = flat()
    positions = take.positions.copy()
    truths = [
        Truth("A", Span(50, 51), "peak", 20.0, ("x",)),
        Truth("A", Span(200, 240), "step", 30.0, ("y",)),
        Truth("B", Span(100, 120), "gap"),
    ]
    positions[50, 0, 0] += 20
    positions[200:240, 0, 1] += 30
    positions[100:120, 1] = np.nan
    answers = tuple(Answer(t, np.full((len(t.span), 3), 100.0)) for t in truths)
    return Exercise(
        take.with_positions(positions), 3, 0, ("gap", "peak", "step"), 20.0, False, answers
    )


def outcomes(review: object) -> dict[tuple[str, int], str]:
    result = grade(small_exercise(), review, methods=())  # type: ignore[arg-type]
    return {(m.marker, m.span.start): m.outcome for m in result.marks}


def test_every_outcome() -> None:
    review = review_of(
        [
            judged("A", Span(49, 52), "peak"),  # three frames around a peak of one are that peak
            judged("A", Span(198, 232), "slow"),  # found, another kind
            judged("A", Span(234, 238), "peak"),  # a second finding on the same step
            judged("C", Span(10, 20), "noise"),  # nothing there
            judged("C", Span(40, 50), "noise", "rejected"),  # nothing there, and said so
            judged("B", Span(102, 104), "step", "rejected"),  # on the gap that nobody fills
        ]
    )
    assert outcomes(review) == {
        ("A", 50): "right",
        ("A", 200): "misclassified",
        ("A", 234): "partial",
        ("C", 10): "invented",
        ("C", 40): "dismissed",
        ("B", 100): "missed",
    }
    result = grade(small_exercise(), review, methods=())
    assert cell(result.matrix, "step", "slow") == 1
    assert cell(result.matrix, "gap", "missed") == 1
    assert cell(result.matrix, "nothing", "noise") == 1
    assert cell(result.matrix, "nothing", "missed") == 1
    assert sum(map(sum, result.matrix)) == 5
    assert result.kinds["slow"].false_discovery == 1.0
    assert result.kinds["peak"].iou == pytest.approx(1 / 3)
    words = {m.outcome: m.why for m in result.marks}
    assert "you called a slow change" in words["misclassified"]
    assert "false alarm" in words["missed"]
    assert words["invented"].startswith("Nothing is wrong here")


@st.composite
def any_review(draw: st.DrawFn) -> Review:
    """Anything that somebody might decide on the small exercise; accepted spans do not overlap."""
    found = []
    for marker in "ABC":
        edges = sorted(draw(st.sets(st.integers(1, 399), max_size=8)))
        for start, stop in zip(edges[::2], edges[1::2], strict=False):
            verdict = draw(st.sampled_from(["accepted", "accepted", "rejected", "deferred", None]))
            kind = draw(st.sampled_from(("gap", *KINDS)))
            method = draw(st.sampled_from(["linear", "pchip", "leave"]))
            found.append(judged(marker, Span(start, stop), kind, verdict, method))
    return review_of(found)


@settings(max_examples=100, deadline=None)
@given(any_review())
def test_every_artefact_and_every_decision_is_counted_once(review: Review) -> None:
    exercise = small_exercise()
    result = grade(exercise, review, methods=())
    about = [m for m in result.marks if m.outcome in ("right", "misclassified", "missed")]
    assert sorted((m.marker, m.span) for m in about) == sorted(
        (t.marker, t.span) for t in exercise.truths
    )
    accepted = [j.finding.id for j in review if j.decision.verdict == "accepted"]
    said = [m.finding for m in result.marks if m.called is not None]
    assert sorted(said) == sorted(accepted)
    assert sum(map(sum, result.matrix)) == len(result.marks) - result.count("partial")
    for kind, score in result.kinds.items():
        assert 0 <= score.right <= score.found <= score.true
        assert 0 <= score.wrong <= score.called
        assert score.true == sum(t.kind == kind for t in exercise.truths)
        assert score.called == sum(row[COLUMNS.index(kind)] for row in result.matrix)
    assert result.worse == ((result.rmse_after_mm or 0) > (result.rmse_before_mm or 0) + 1e-6)
    assert json.loads(json.dumps(result.to_json(), allow_nan=False))["verdict"] == result.verdict


def test_too_little_of_an_artefact_is_a_miss_that_says_where_it_lies() -> None:
    review = review_of([judged("A", Span(200, 212), "step")])
    assert outcomes(review)["A", 200] == "missed"
    result = grade(small_exercise(), review, methods=())
    assert "frames 200 to 239, of which your frames 200 to 211" in next(
        m.why for m in result.marks if m.outcome == "missed" and m.kind == "step"
    )


def test_deleting_everything_is_no_way_to_a_small_error() -> None:
    truths = [t for t in small_exercise().truths if t.kind != "gap"]
    result = grade(small_exercise(), accepting(truths, "leave"), methods=())
    assert result.rmse_after_mm == result.rmse_before_mm
    assert result.rmse_before_mm == pytest.approx(np.sqrt((20**2 + 40 * 30**2) / 41))
    assert "data is given up" in result.marks[0].why


def test_a_beginner_who_leaves_it_worse_is_told() -> None:
    take = swinging()
    exercise = make_exercise(take, 2, 3, amplitude_mm=1.0)
    harm = judged("M11", Span(100, 400), "noise", method="linear")
    result = grade(exercise, review_of([harm]), methods=())
    assert result.worse
    assert "worse than you got it" in result.verdict
    (mark,) = (m for m in result.marks if m.outcome == "invented")
    assert mark.repaired is not None
    assert f"{mark.repaired.error_mm:.1f} mm away from where it was" in mark.why


def test_a_swap_is_one_decision_for_both_markers() -> None:
    take = swinging()
    positions = take.positions.copy()
    positions[300:360, [0, 1]] = positions[300:360, [1, 0]]
    span = Span(300, 360)
    answers = tuple(
        Answer(Truth(a, span, "step", partner=b), take.positions[300:360, take.index(a)])
        for a, b in (("M0", "M1"), ("M1", "M0"))
    )
    exercise = Exercise(take.with_positions(positions), 5, 0, ("step",), 20.0, False, answers)
    one = judged("M0", span, "step", method="swap")
    swap = type(one)(type(one.finding)("M0", span, "step", partner="M1"), one.decision, True)
    result = grade(exercise, review_of([swap]), methods=())
    assert [m.outcome for m in result.marks] == ["right", "right"]
    assert result.rmse_after_mm == pytest.approx(0.0, abs=1e-9)


def test_the_time_for_a_finding_leaves_out_pauses() -> None:
    begin = datetime(2026, 1, 1, 9, tzinfo=UTC)
    after = [0, 4, 10, 18, 4000, 4006]
    decided = {str(i): At(begin + timedelta(seconds=s)) for i, s in enumerate(after)}
    decided["unknown"] = At(None)
    result = grade(small_exercise(), review_of([]), decided=decided, methods=())
    assert result.seconds_per_finding == 6.0
    assert grade(small_exercise(), review_of([]), methods=()).seconds_per_finding is None
