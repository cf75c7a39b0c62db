"""Pseudo-gaps are honest, and the mix fills gaps better than what it was made from."""

from dataclasses import replace

import numpy as np
import pytest

from markermend.errors import CannotRepair
from markermend.model import Span, Take
from markermend.repairing.blend.band import band_by_position
from markermend.repairing.blend.predictors import families
from markermend.repairing.blend.pseudo import possible_starts, pseudo_gaps
from markermend.repairing.blend.scene import survey
from markermend.repairing.run import Wish, apply, pose, repair
from markermend.repairing.window import window

SPAN = Span(500, 550)


def scene_of(take, marker="THIGH2", span=SPAN):
    return survey(window(pose(take, Wish(marker, span))))


def test_a_prediction_knows_nothing_of_the_frames_that_are_hidden_from_it(walk):
    hidden = Span(700, 860)
    around = scene_of(walk)
    bent = around.window.positions.copy()
    bent[hidden.frames, around.window.marker] += 35.0
    changed = replace(around, window=replace(around.window, positions=bent))
    kinds = zip(families(around), families(changed), strict=True)
    for one, other in kinds:
        if one.name.endswith("fast"):
            continue  # its signals are filtered, and the filter's reach is the embargo's business
        np.testing.assert_allclose(
            one.predictions(hidden, hidden), other.predictions(hidden, hidden), atol=1e-6
        )


def test_taking_rows_off_the_sums_is_fitting_without_them(walk):
    family = families(scene_of(walk))[0]
    hidden = Span(100, 300)
    rows = family.rows.copy()
    rows[hidden.frames] = False
    z, y = family.z[rows], family.y[rows]
    for recipe, given in zip(family.recipes(0), family.predictions(hidden, hidden), strict=True):
        p = recipe.neighbours * 3
        centred = z[:, :p] - z[:, :p].mean(axis=0)
        gram = centred.T @ centred / len(z) + recipe.penalty * np.eye(p)
        slopes = np.linalg.solve(gram, centred.T @ y / len(z))
        wanted = (family.z[hidden.frames, :p] - z[:, :p].mean(axis=0)) @ slopes + y.mean(axis=0)
        np.testing.assert_allclose(given, wanted, atol=1e-6)


def test_pseudo_gaps_have_the_gap_s_length_and_boundary_and_avoid_it(walk):
    around = scene_of(walk)
    hidden = pseudo_gaps(around.rows, around.window.span, around.boundary)
    assert hidden.length == len(SPAN)
    for start in hidden.starts:
        assert around.rows[start : start + hidden.length].all()
        assert around.rows[start + hidden.boundary].all()
        assert not Span(int(start), int(start) + hidden.length).overlaps(around.window.span)
    assert sorted(i for members, _ in hidden.groups for i in members) == list(range(len(hidden)))


def test_no_stretch_is_offered_that_is_not_whole():
    rows = np.ones(40, bool)
    rows[20] = False
    offsets = np.array([-2, -1, 5, 6])
    for start in possible_starts(rows, 5, offsets):
        assert rows[start - 2 : start + 7].all()
    assert len(possible_starts(rows[:8], 5, offsets)) == 0
    assert len(possible_starts(rows[:9], 5, offsets)) == 1


def test_the_mix_is_better_than_a_spline_and_a_rigid_body(walk):
    errors = {}
    for name in ("auto", "rlk", "rigid", "spline"):
        filled = repair(walk, "THIGH2", SPAN, name).values
        truth = walk.positions[SPAN.frames, walk.index("THIGH2")]
        errors[name] = np.linalg.norm(filled - truth, axis=1).mean()
    assert errors["auto"] < 0.5
    assert errors["auto"] < 0.3 * min(errors["rigid"], errors["spline"])
    assert errors["rlk"] < 0.3 * min(errors["rigid"], errors["spline"])


def test_both_edges_are_met_in_position_and_slope(walk):
    done = repair(walk, "THIGH4", SPAN, "auto")
    path = apply(walk, [done]).positions[:, walk.index("THIGH4")]
    bend = np.linalg.norm(np.diff(path, n=2, axis=0), axis=1)
    usual = np.quantile(bend, 0.95)
    assert bend[SPAN.start - 3 : SPAN.start + 1].max() < 3 * usual
    assert bend[SPAN.stop - 2 : SPAN.stop + 1].max() < 3 * usual


@pytest.mark.parametrize("span", [Span(0, 40), Span(1160, 1200)])
@pytest.mark.parametrize("name", ["auto", "rlk"])
def test_gaps_at_the_ends_of_a_take_are_filled_from_the_neighbours(walk, span, name):
    filled = repair(walk, "TRUNK1", span, name).values
    truth = walk.positions[span.frames, walk.index("TRUNK1")]
    assert np.linalg.norm(filled - truth, axis=1).mean() < 1.0


def test_a_blackout_is_carried_by_the_marker_s_own_motion(walk):
    gone = walk.positions.copy()
    gone[500:515] = np.nan
    done = repair(walk.with_positions(gone), "THIGH1", (500, 515), "auto")
    off = np.linalg.norm(done.values - walk.positions[500:515, walk.index("THIGH1")], axis=1)
    assert off.mean() < 3.0
    assert "No neighbour" in done.note
    with pytest.raises(CannotRepair, match="0 neighbours"):
        repair(walk.with_positions(gone), "THIGH1", (500, 515), "rlk")


def test_a_blackout_at_the_end_is_refused(walk):
    gone = walk.positions.copy()
    gone[1150:] = np.nan
    with pytest.raises(CannotRepair, match="one side"):
        repair(walk.with_positions(gone), "THIGH1", (1150, 1200), "auto")


def test_a_short_take_is_judged_by_gaps_of_other_markers(walk):
    short = Take(walk.positions[440:560], walk.rate, walk.labels)
    done = repair(short, "THIGH2", (40, 80), "auto")
    off = np.linalg.norm(done.values - walk.positions[480:520, walk.index("THIGH2")], axis=1)
    assert (off <= done.band).mean() > 0.8
    assert done.expected_mm < done.band.max() < 20 * off.max()
    assert "11 gaps of this length on other markers" in done.note


def test_no_band_where_no_gap_of_the_length_can_be_hidden(walk):
    short = Take(walk.positions[440:500], walk.rate, walk.labels)
    done = repair(short, "THIGH2", (2, 58), "auto")
    assert done.band is not None
    few = Take(walk.positions[440:500, :5], walk.rate, walk.labels[:5])
    done = repair(few, "TRUNK2", (2, 58), "auto")
    assert done.band is None
    assert done.expected_mm is None
    assert "filled at once" in done.note


def test_only_the_window_around_the_span_counts(walk):
    long = np.tile(walk.positions, (6, 1, 1))
    bent = long.copy()
    bent[:1500] += 500.0
    span = Span(5000, 5040)
    for name in ("auto", "rlk"):
        one, other = (
            repair(Take(x, 100.0, walk.labels), "THIGH2", span, name) for x in (long, bent)
        )
        np.testing.assert_array_equal(one.values, other.values)


def test_a_neighbour_that_is_gone_in_the_span_is_not_used(walk):
    holed = walk.positions.copy()
    holed[510:530, walk.index("THIGH3")] = np.nan
    around = scene_of(walk.with_positions(holed))
    assert walk.index("THIGH3") not in around.order
    assert len(around.order) == 10


def test_the_band_covers_nine_in_ten_and_grows_away_from_the_edges():
    rng = np.random.default_rng(2)
    inside = np.arange(40)
    shape = np.sin(np.pi * (inside + 0.5) / 40)
    errors = np.abs(rng.normal(size=(60, 40))) * shape
    band = band_by_position(errors, inside, 40, 10**6)
    fresh = np.abs(rng.normal(size=(400, 40))) * shape
    assert 0.87 < (fresh <= band).mean() < 0.95
    assert band[20] > 3 * band[0]
    assert (band_by_position(errors, inside, 40, 300) > 1.2 * band).all()
    assert band_by_position(errors, inside, 40, 90) is None
