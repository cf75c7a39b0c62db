"""Short windows: all gaps at once, and the switch between that and a tested mix."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from markermend.errors import CannotRepair
from markermend.model import Span, Take
from markermend.repairing.blend.short import share_of_tested
from markermend.repairing.run import fill, repair
from markermend.repairing.shortwindow import fill_at_once, nugget_by_evidence, prefilled

GAPS = ((1, 20, 50), (2, 40, 70), (7, 30, 60), (8, 45, 90), (10, 10, 22))


@pytest.fixture(scope="module")
def short(walk) -> tuple[Take, Take]:
    """120 frames with overlapping gaps in 5 of 12 markers, and the truth."""
    truth = Take(walk.positions[300:420], walk.rate, walk.labels)
    holed = truth.positions.copy()
    for marker, start, stop in GAPS:
        holed[start:stop, marker] = np.nan
    return truth.with_positions(holed), truth


def errors(filled, truth):
    return [np.linalg.norm(filled[a:b, m] - truth[a:b, m], axis=1).mean() for m, a, b in GAPS]


def test_overlapping_gaps_are_filled_better_than_each_on_its_own(short):
    holed, truth = short
    ours = np.mean(errors(fill(holed).positions, truth.positions))
    others = [
        np.mean(errors(fill(holed, name).positions, truth.positions))
        for name in ("pchip", "spline", "lgrnn")
    ]
    assert ours < 0.5 * min(others)


def test_what_is_seen_is_kept_and_nothing_is_left_open(short):
    holed, _ = short
    filled = fill_at_once(holed.positions, holed.rate)
    seen = np.isfinite(holed.positions)
    assert np.isfinite(filled).all()
    np.testing.assert_allclose(filled[seen], holed.positions[seen], atol=1e-9)
    assert not filled.flags.writeable


def test_the_model_turns_and_moves_with_the_room(short):
    holed, _ = short
    turn, _ = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    moved = holed.positions @ turn.T + [500.0, -200.0, 90.0]
    one = fill_at_once(holed.positions, holed.rate) @ turn.T + [500.0, -200.0, 90.0]
    np.testing.assert_allclose(fill_at_once(moved, holed.rate), one, atol=1e-6)


def test_the_nugget_follows_the_noise():
    time = np.arange(200) / 100
    rng = np.random.default_rng(1)
    smooth = np.column_stack([np.sin(2 * time + p) for p in range(6)]).reshape(-1, 2, 3) * 100
    calm = nugget_by_evidence(smooth + rng.normal(0, 1e-3, smooth.shape), 100)
    noisy = nugget_by_evidence(smooth + rng.normal(0, 3, smooth.shape), 100)
    assert noisy > 30 * calm


def test_prefilling_holds_the_outermost_positions():
    positions = np.full((10, 2, 3), np.nan)
    positions[3:6, 0] = np.arange(3)[:, None]
    filled = prefilled(positions)
    np.testing.assert_array_equal(filled[:3, 0], 0.0)
    np.testing.assert_array_equal(filled[6:, 0], 2.0)
    np.testing.assert_array_equal(filled[:, 1], 0.0)


@given(st.integers(0, 10**5), st.integers(1, 2000), st.floats(10, 500))
@settings(deadline=None)
def test_the_share_goes_from_none_to_all(seen, length, rate):
    share = share_of_tested(seen, length, rate)
    assert 0 <= share <= 1
    assert share_of_tested(seen + 100, length, rate) >= share
    if seen < 0.9 * rate or seen < length:
        assert share == 0
    if seen >= 3.01 * rate and seen >= 3 * length:
        assert share == 1


def test_a_marker_alone_in_a_short_take_is_carried_by_its_own_motion(walk):
    alone = Take(walk.positions[:60, [3]], walk.rate, walk.labels[3:4])
    span = Span(25, 33)
    done = repair(alone, walk.labels[3], span, "auto")
    off = np.linalg.norm(done.values - alone.positions[span.frames, 0], axis=1)
    assert off.mean() < 3.0
    with pytest.raises(CannotRepair, match="one side"):
        repair(alone, walk.labels[3], (50, 60), "auto")
