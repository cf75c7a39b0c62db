"""Expected errors come true, and a comparison recommends what is best and clean."""

import numpy as np
import pytest

from markermend.errors import UnknownName
from markermend.model import Span, Take
from markermend.repairing.compare import compare, compare_iter
from markermend.repairing.run import Wish, pose, repair
from markermend.repairing.trials import cut_out, places, spread_out, trials, triangle
from markermend.repairing.trust import expected_error

SPAN = Span(620, 650)
METHODS = ("auto", "rlk", "rigid", "pchip", "linear")


def truth(take, label, span=SPAN):
    return take.positions[span.frames, take.index(label)]


def test_expected_errors_are_about_the_true_ones_and_in_their_order(walk):
    ratios, agreeing = [], 0
    for marker in ("THIGH0", "THIGH5", "TRUNK2"):
        expected = expected_error(pose(walk, Wish(marker, SPAN)), METHODS)
        assert set(expected) == set(METHODS)
        true = {
            name: np.linalg.norm(
                repair(walk, marker, SPAN, name).values - truth(walk, marker), axis=1
            ).mean()
            for name in METHODS
        }
        ratios += [expected[name].expected_mm / true[name] for name in METHODS]
        by_truth = sorted(METHODS, key=true.__getitem__)
        agreeing += by_truth[:2] == sorted(by_truth[:2], key=lambda n: expected[n].expected_mm)
        assert expected["pchip"].expected_mm > 3 * expected["rlk"].expected_mm
    assert 0.5 < np.median(ratios) < 2


def test_the_span_and_the_trial_are_hidden_and_nothing_else(walk):
    problem, around = cut_out(pose(walk, Wish("THIGH1", SPAN)))
    starts = spread_out(places(around), 4)
    for trial in trials(problem, starts, None):
        hidden = np.isnan(trial.problem.own[:, 0])
        assert hidden.sum() == 2 * len(SPAN)
        assert np.isnan(trial.problem.recorded[trial.problem.span.frames]).all()
        np.testing.assert_array_equal(trial.truth, problem.own[trial.problem.span.frames])
        others = np.delete(np.arange(12), problem.marker)
        np.testing.assert_array_equal(
            trial.problem.positions[:, others], problem.positions[:, others]
        )


@pytest.mark.parametrize("kind", ["step", "slow", "noise"])
def test_an_artefact_of_the_same_kind_and_size_is_put_into_the_trials(walk, kind):
    size = np.array([12.0, 0.0, -5.0])
    rng = np.random.default_rng(4)
    shape = {
        "step": np.ones((30, 1)),
        "slow": triangle(30)[:, None],
        "noise": rng.normal(size=(30, 3)),
    }[kind]
    recorded = walk.positions.copy()
    recorded[SPAN.frames, walk.index("THIGH1")] += shape * size
    problem, around = cut_out(pose(walk.with_positions(recorded), Wish("THIGH1", SPAN, kind)))
    for trial in trials(problem, spread_out(places(around), 5), truth(walk, "THIGH1")):
        added = trial.problem.recorded[trial.problem.span.frames] - trial.truth
        if kind == "noise":
            np.testing.assert_allclose(added.std(axis=0), np.abs(size), atol=5)
        else:
            np.testing.assert_allclose(added, shape * size, atol=1e-6)
        assert trial.problem.kind == kind


def test_the_comparison_recommends_the_lowest_expected_error_that_is_clean(walk):
    found = compare(walk, "THIGH2", SPAN, METHODS)
    assert found.recommended in ("auto", "rlk")
    best = found.row(found.recommended)
    assert best.brings_nothing_new
    assert best.repair.span == SPAN
    assert all(
        row.expected_mm >= best.expected_mm or not row.brings_nothing_new
        for row in found.rows if row.repair
    )  # fmt: skip
    assert found.why.startswith(best.title)
    assert found.why.endswith(".")
    for row in found.rows:
        np.testing.assert_allclose(
            row.repair.values, repair(walk, "THIGH2", SPAN, row.method).values, atol=1e-9
        )


def test_checks_see_a_jump_and_stretched_distances(walk):
    found = compare(walk, "THIGH2", SPAN, ("rlk", "linear"))
    good, bad = found.row("rlk").checks, found.row("linear").checks
    assert good.slope_mm < bad.slope_mm
    assert good.distance_mm < 1.5 * good.usual_distance_mm
    assert bad.distance_mm > 3 * bad.usual_distance_mm


def test_rows_come_one_by_one_and_refusals_say_why(walk):
    gone = walk.positions.copy()
    gone[SPAN.frames] = np.nan
    rows = compare_iter(walk.with_positions(gone), "THIGH2", SPAN, ("rlk", "pchip", "leave"))
    first = next(rows)
    assert first.method == "rlk", "in the order asked for"
    by_name = {row.method: row for row in (first, *rows)}
    assert by_name["rlk"].repair is None
    assert by_name["rlk"].refusal.endswith(".")
    assert np.isfinite(by_name["pchip"].expected_mm)


def test_unknown_names_are_said(walk):
    with pytest.raises(UnknownName, match="no_such"):
        compare(walk, "THIGH2", SPAN, ("no_such",))


def test_a_span_of_a_long_take_is_compared_in_frames_of_the_take(walk):
    long = walk.with_positions(np.tile(walk.positions, (9, 1, 1)))
    span, hidden = Span(6620, 6650), ("THIGH3", Span(6600, 6660))
    found = compare(long, "THIGH2", span, ("rlk", "linear"), masked=[hidden])
    assert all(row.repair.span == span for row in found.rows)
    assert all(f.span.overlaps(span.padded(5, long.n_frames)) for row in found.rows
               for f in row.checks.artefacts)  # fmt: skip
    alone = repair(long, "THIGH2", span, "rlk", masked=[hidden])
    assert alone.span == span
    np.testing.assert_allclose(alone.values, found.row("rlk").repair.values, atol=1e-9)
    bare = repair(long, "THIGH2", span, "rlk")
    assert np.abs(alone.values - bare.values).max() > 1e-6


def test_a_swap_is_changed_back_where_it_was_found(walk):
    spoilt = walk.positions.copy()
    first, second = walk.index("THIGH1"), walk.index("TRUNK1")
    spoilt[SPAN.frames, first], spoilt[SPAN.frames, second] = (
        walk.positions[SPAN.frames, second],
        walk.positions[SPAN.frames, first],
    )
    take = walk.with_positions(spoilt)
    names = ("auto", "swap", "pchip")
    found = compare(take, "THIGH1", SPAN, names, kind="step", partner="TRUNK1")
    assert found.recommended == "swap"
    assert "exact" in found.why


def test_where_the_detector_cannot_look_it_is_said(walk):
    flat = Take(walk.positions[:, :, :2], walk.rate, walk.labels, units="px")
    found = compare(flat, "THIGH2", SPAN, ("pchip", "rigid"))
    for row in found.rows:
        assert not row.checks.detected
        assert "2D" in row.checks.unlooked
    assert "not asked" in found.why
