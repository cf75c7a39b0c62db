"""What holds for every scenario: bones, feet, floor, smoothness; and what the persons do."""

from collections.abc import Callable

import numpy as np
import pytest

from markermend.model import Take, runs
from markermend.simulate import SCENARIOS, perform
from markermend.simulate.body import SIDES, Body, Side
from markermend.simulate.frames import Movement

Moved = Callable[[str], Movement]
Taken = Callable[[str], Take]
every_scenario = pytest.mark.parametrize("scenario", SCENARIOS)


def flat_spans(moved: Movement, side: Side) -> list[slice]:
    foot = moved.feet[side]
    return [span.frames for span in runs(foot.planted & (abs(foot.pitch) < np.radians(0.5)))]


@every_scenario
def test_bones_keep_their_lengths_and_no_leg_is_overstretched(scenario: str, moved: Moved) -> None:
    movement = moved(scenario)
    segments, body = movement.segments, movement.body
    for side in SIDES:
        hip, knee, ankle = (segments[side + name].origin for name in ("thigh", "shank", "foot"))
        assert np.ptp(np.linalg.norm(hip - knee, axis=1)) < 1e-6
        assert np.ptp(np.linalg.norm(knee - ankle, axis=1)) < 1e-6
        reached = np.linalg.norm(hip - ankle, axis=1) / (body.thigh + body.shank)
        assert reached.max() < 0.9999
        # The hip that the leg hangs on is the one of the pelvis.
        np.testing.assert_allclose(hip, segments["pelvis"].point(body.hip(side)), atol=1e-6)


@every_scenario
def test_feet_stay_above_the_floor(scenario: str, moved: Moved, taken: Taken) -> None:
    movement, take = moved(scenario), taken(scenario)
    for side in SIDES:
        foot = movement.segments[side + "foot"]
        for point in (movement.body.heel, movement.body.ball):
            assert foot.point(point)[:, 2].min() > -0.5
    assert take.positions[:, :, 2].min() > 10.0


@every_scenario
def test_planted_feet_do_not_slide(scenario: str, moved: Moved, taken: Taken) -> None:
    movement, take = moved(scenario), taken(scenario)
    n_spans = 0
    for side in SIDES:
        for frames in flat_spans(movement, side):
            n_spans += 1
            for name in ("HEE", "TOE", "MT1", "MT5"):
                path = take.positions[frames, take.index(side + name), :2].copy()
                path[:, 0] += movement.belt[frames]
                assert np.linalg.norm(path - np.median(path, axis=0), axis=1).max() < 10.0
    assert n_spans >= 2


@every_scenario
def test_movement_is_smooth(scenario: str, glued: Taken, taken: Taken) -> None:
    """No jump: accelerations stay within those of real walking takes, heel strikes included.

    Unfiltered laboratory takes of walking reach 55 to 200 m/s² at single frames.
    """
    paths = glued(scenario).positions
    acceleration = np.linalg.norm(np.diff(paths, 2, axis=0), axis=2) * 100.0**2 / 1000.0
    assert acceleration.max() < 200.0
    assert np.quantile(acceleration, 0.99) < 80.0
    speed = np.linalg.norm(np.diff(paths, axis=0), axis=2) * 100.0
    assert speed.max() < 6000.0
    if scenario in ("static", "sitting"):
        assert acceleration.max() < 40.0
    measured = taken(scenario).positions
    assert np.linalg.norm(np.diff(measured, 2, axis=0), axis=2).max() < 25.0


def test_who_stands_keeps_his_feet_shifts_and_looks_around(moved: Moved) -> None:
    movement = moved("static")
    assert all(foot.planted.all() for foot in movement.feet.values())
    sway = movement.segments["pelvis"].origin[:, 1]
    assert 40.0 < np.ptp(sway) < 200.0
    gaze = movement.segments["head"].rotation[:, :, 0]
    turned = np.degrees(np.arctan2(gaze[:, 1], gaze[:, 0]))
    assert turned.max() > 20.0
    assert turned.min() < -20.0


def test_who_sits_does_it_three_times_and_bends_forward(moved: Moved) -> None:
    movement = moved("sitting")
    pelvis, thorax = movement.segments["pelvis"], movement.segments["thorax"]
    seated = runs(pelvis.origin[:, 2] < movement.body.sitting_hip_height + 20.0)
    assert len(seated) == 3
    assert all(len(span) > 200 for span in seated)
    lean = np.degrees(np.arcsin(thorax.rotation[:, 0, 2]))
    for span in seated:
        settled = slice(span.start + 100, span.stop - 100)
        assert abs(lean[settled]).max() < 15.0
        assert lean[span.start - 40 : span.start + 20].max() > 25.0
        assert lean[span.stop - 20 : span.stop + 40].max() > 25.0
    # Hands rest on the thighs: above their middle line by less than a thigh is thick.
    middle = seated[0].start + len(seated[0]) // 2
    for side in SIDES:
        hand = movement.segments[side + "hand"].origin[middle]
        thigh = movement.segments[side + "thigh"]
        along = thigh.rotation[middle].T @ (hand - thigh.origin[middle])
        assert -0.98 * movement.body.thigh < along[2] < -150.0
        assert 30.0 < along[0] < 130.0
        assert abs(along[1]) < 160.0


def test_who_demonstrates_walks_turns_sits_and_waves(moved: Moved) -> None:
    movement = moved("demo")
    assert 27.0 < len(movement.belt) / movement.rate < 33.0
    pelvis = movement.segments["pelvis"]
    ground = pelvis.origin[:, :2]
    travelled = np.linalg.norm(np.diff(ground, axis=0), axis=1).sum()
    assert travelled > 6000.0
    facing = np.unwrap(np.arctan2(pelvis.rotation[:, 1, 0], pelvis.rotation[:, 0, 0]))
    assert np.degrees(np.ptp(facing)) > 300.0
    # Turning is fluent: nobody turns faster than half a turn a second.
    assert abs(np.diff(np.degrees(facing))).max() * movement.rate < 180.0
    assert pelvis.origin[:, 2].min() == pytest.approx(movement.body.sitting_hip_height, abs=5.0)
    hand, shoulder = (movement.segments["R" + name].origin for name in ("hand", "upperarm"))
    assert (hand[:, 2] - shoulder[:, 2]).max() > 0.0
    # Head first: it turns before the pelvis does, where the person walks a curve.
    gaze = movement.segments["head"].rotation
    looks = np.unwrap(np.arctan2(gaze[:, 1, 0], gaze[:, 0, 0]))
    curve = slice(250, 650)
    lags = range(-30, 31, 2)
    errors = [np.std(np.roll(looks, lag)[curve] - facing[curve]) for lag in lags]
    assert 8 <= lags[int(np.argmin(errors))] <= 30


def test_a_person_of_any_height_moves(moved: Moved) -> None:
    for height in (1200.0, 2000.0):
        movement = perform("demo", 1, height=height)
        assert movement.body == Body(height)
        assert all(np.isfinite(frames.origin).all() for frames in movement.segments.values())
    assert moved("demo").body.height == 1750.0
