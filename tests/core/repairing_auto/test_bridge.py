"""Blackouts are crossed by what like postures did, and artefacts by what was recorded in them."""

import numpy as np
import pytest

from markermend.model import Span, Take
from markermend.repairing.blend.blend import hardness
from markermend.repairing.run import repair

SPAN = Span(600, 640)


def error(done, take, label, first=0):
    frames = slice(done.span.start + first, done.span.stop + first)
    truth = take.positions[frames, take.index(label)]
    return float(np.linalg.norm(done.values - truth, axis=1).mean())


def blackout(take, span=SPAN):
    gone = take.positions.copy()
    gone[span.frames] = np.nan
    return take.with_positions(gone)


def test_motion_that_repeats_itself_is_known_from_elsewhere(walk):
    dark = blackout(walk)
    found = repair(dark, "THIGH1", SPAN, "auto")
    assert error(found, walk, "THIGH1") < 0.5 * error(
        repair(dark, "THIGH1", SPAN, "spline"), walk, "THIGH1"
    )
    assert "like postures" in found.note
    assert found.band is not None


def test_it_turns_and_moves_with_the_room(walk):
    turn = np.array([[0.6, -0.8, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, 1.0]])
    dark = blackout(walk)
    there = dark.with_positions(dark.positions @ turn.T + np.array([500.0, -2000.0, 30.0]))
    here = repair(dark, "THIGH1", SPAN, "auto").values
    np.testing.assert_allclose(
        repair(there, "THIGH1", SPAN, "auto").values,
        here @ turn.T + np.array([500.0, -2000.0, 30.0]),
        atol=1e-4,
    )


def test_takes_to_learn_from_help_a_short_piece(walk):
    piece = Take(walk.positions[560:680], walk.rate, walk.labels)
    other = Take(walk.positions[:520], walk.rate, walk.labels)
    span = Span(40, 80)
    dark = blackout(piece, span)
    alone = repair(dark, "THIGH1", span, "auto")
    taught = repair(dark, "THIGH1", span, "auto", training=(other,))
    assert error(taught, piece, "THIGH1") < 0.7 * error(alone, piece, "THIGH1")
    assert "takes to learn from" in taught.note
    stranger = Take(other.positions, other.rate, [f"X{label}" for label in walk.labels])
    same = repair(dark, "THIGH1", span, "auto", training=(stranger,))
    np.testing.assert_array_equal(same.values, alone.values)


def test_a_gap_is_hard_where_the_members_disagree():
    there = np.array([1.0, 2.0, 4.0])
    calm, wild = hardness(1.0, there), hardness(4.0, there)
    assert calm[0] == pytest.approx(1.0)
    assert (wild > calm).all()
    np.testing.assert_array_equal(hardness(100.0, there), wild)


def test_under_noise_the_clean_axes_stay_and_the_noisy_one_is_helped(walk):
    spoilt = walk.positions.copy()
    marker = walk.index("THIGH1")
    spoilt[SPAN.frames, marker, 1] += np.random.default_rng(1).normal(0, 3, len(SPAN))
    done = repair(walk.with_positions(spoilt), "THIGH1", SPAN, "auto", kind="noise")
    plain = repair(walk.with_positions(spoilt), "THIGH1", SPAN, "auto")
    truth = walk.positions[SPAN.frames, marker]
    assert np.abs(done.values - truth)[:, [0, 2]].max() < 0.3
    assert np.std((done.values - truth)[:, 1]) < 1.0
    assert error(done, walk, "THIGH1") < error(plain, walk, "THIGH1")
    assert done.expected_mm < plain.expected_mm


def test_under_a_peak_only_the_axis_that_jumps_is_filled(walk):
    spoilt = walk.positions.copy()
    marker, span = walk.index("THIGH1"), Span(600, 601)
    spoilt[600, marker, 2] += 40.0
    done = repair(walk.with_positions(spoilt), "THIGH1", span, "auto", kind="peak")
    np.testing.assert_array_equal(done.values[:, :2], spoilt[600:601, marker, :2])
    assert abs(done.values[0, 2] - walk.positions[600, marker, 2]) < 1.0
    assert "x, y stays as recorded" in done.note


@pytest.mark.parametrize("off", [-3, 0, 1])
def test_a_step_is_found_where_the_span_is_not_exact(walk, off):
    spoilt = walk.positions.copy()
    marker = walk.index("THIGH1")
    spoilt[SPAN.frames, marker, 0] += 15.0
    asked = Span(SPAN.start - 3, SPAN.stop + 3 + off)
    done = repair(walk.with_positions(spoilt), "THIGH1", asked, "unstep", kind="step")
    truth = walk.positions[asked.frames, marker]
    assert np.abs(done.values - truth).max() < 0.6
