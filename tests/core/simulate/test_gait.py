"""Joint angles, arms and pelvis of the treadmill walkers against published gait.

Bounds hold the mean curves of healthy adults and about two standard deviations: Winter, *The
Biomechanics and Motor Control of Human Gait*, 2nd ed. (1991), tables 3.32(a) to (c) (slow, natural
and fast cadence), and Perry and Burnfield, *Gait Analysis*, 2nd ed. (2010), chapters 4 to 6.
"""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from markermend.model import FloatArray, Take
from markermend.simulate.body import SIDES, Side
from markermend.simulate.frames import Movement
from markermend.simulate.walking import Cadence

Moved = Callable[[str], Movement]
SPEEDS = {"treadmill-slow": 800.0, "treadmill": 1200.0, "treadmill-fast": 1600.0}
every_speed = pytest.mark.parametrize("scenario", SPEEDS)


def landings(movement: Movement, side: Side) -> FloatArray:
    return np.flatnonzero(np.diff(movement.feet[side].planted.astype(int)) == 1) + 1


def flexion(movement: Movement, parent: str, child: str) -> FloatArray:
    """Turn of the child about the parent's left axis, in degrees; forward is positive."""
    segments = movement.segments
    between = np.swapaxes(segments[parent].rotation, 1, 2) @ segments[child].rotation
    return -Rotation.from_matrix(between).as_euler("YXZ", degrees=True)[:, 0]


def mean_cycle(movement: Movement, side: Side, values: FloatArray) -> FloatArray:
    """Mean over cycles, from landing to landing, at 101 per cent points."""
    at = landings(movement, side)
    cycles = [
        np.interp(np.linspace(0, 1, 101), np.linspace(0, 1, b - a + 1), values[a : b + 1])
        for a, b in pairwise(at)
    ]
    assert len(cycles) >= 10
    return np.mean(cycles, axis=0)


@every_speed
@pytest.mark.parametrize("side", SIDES)
def test_knee_flexion(scenario: str, side: Side, moved: Moved) -> None:
    movement = moved(scenario)
    knee = mean_cycle(movement, side, -flexion(movement, side + "thigh", side + "shank"))
    assert 0.0 < knee[0] < 15.0
    assert 8.0 < knee[8:25].max() < 26.0, "yields to the load"
    assert 0.0 < knee[25:45].min() < 12.0, "straightens in mid-stance"
    assert 50.0 < knee.max() < 70.0, "swings"
    assert 66 <= int(knee.argmax()) <= 82
    assert knee.min() > 0.0


@every_speed
@pytest.mark.parametrize("side", SIDES)
def test_hip_flexion(scenario: str, side: Side, moved: Moved) -> None:
    movement = moved(scenario)
    hip = mean_cycle(movement, side, flexion(movement, "pelvis", side + "thigh"))
    assert 18.0 < hip[0] < 40.0
    assert -27.0 < hip.min() < -5.0
    assert 45 <= int(hip.argmin()) <= 68
    assert 25.0 < hip[75:].max() < 42.0
    assert 30.0 < np.ptp(hip) < 62.0


@every_speed
@pytest.mark.parametrize("side", SIDES)
def test_ankle_flexion(scenario: str, side: Side, moved: Moved) -> None:
    movement = moved(scenario)
    ankle = mean_cycle(movement, side, flexion(movement, side + "shank", side + "foot"))
    assert -12.0 < ankle[0] < 8.0
    assert ankle[3:15].min() < ankle[0], "the foot comes down"
    assert 8.0 < ankle[35:55].max() < 25.0
    assert -32.0 < ankle[55:75].min() < -10.0, "pushes off"
    assert 20.0 < np.ptp(ankle) < 52.0


@every_speed
def test_steps_and_belt(scenario: str, moved: Moved) -> None:
    movement, speed = moved(scenario), SPEEDS[scenario]
    pace = Cadence(speed)
    for side in SIDES:
        at = landings(movement, side)
        assert np.diff(at).mean() / movement.rate == pytest.approx(2 * pace.step_s, rel=0.02)
        ankle = movement.segments[side + "foot"].origin[:, 0]
        stance = np.concatenate([np.arange(a + 20, a + 30) for a in at[:-1]])
        velocity = np.gradient(ankle)[stance] * movement.rate
        assert velocity.mean() == pytest.approx(-speed, rel=0.02)
    # The person stays where the belt is.
    assert np.ptp(movement.segments["pelvis"].origin[:, 0]) < 150.0
    stance_share = np.mean([foot.planted.mean() for foot in movement.feet.values()])
    assert 0.55 < stance_share < 0.70


@every_speed
def test_arms_swing_against_the_legs(scenario: str, moved: Moved) -> None:
    movement = moved(scenario)
    for side in SIDES:
        hand = movement.segments[side + "hand"].origin[:, 0]
        ankle = movement.segments[side + "foot"].origin[:, 0]
        assert np.corrcoef(hand, ankle)[0, 1] < -0.7
        swing = flexion(movement, "thorax", side + "upperarm")
        assert 15.0 < np.ptp(mean_cycle(movement, side, swing)) < 50.0
        elbow = flexion(movement, side + "upperarm", side + "forearm")
        assert elbow.min() >= 2.0
        assert elbow.max() < 60.0


@every_speed
def test_the_pelvis_rises_twice_a_cycle(scenario: str, moved: Moved) -> None:
    movement = moved(scenario)
    height = mean_cycle(movement, "R", movement.segments["pelvis"].origin[:, 2])
    assert 20.0 < np.ptp(height) < 70.0
    # Low when both feet stand, high in the middle of each stance.
    assert min(height[15:40].max(), height[65:90].max()) - height[[0, 50]].max() > 10.0
    sideways = mean_cycle(movement, "R", movement.segments["pelvis"].origin[:, 1])
    assert 15.0 < np.ptp(sideways) < 75.0
    assert 5 <= int(sideways.argmin()) <= 50, "over the right foot while it carries"


def test_who_walks_faster_steps_further_and_quicker(moved: Moved) -> None:
    durations = [float(np.diff(landings(moved(name), "L")).mean()) for name in SPEEDS]
    assert durations[0] > durations[1] > durations[2]
    hips = [
        float(np.ptp(mean_cycle(moved(name), "L", flexion(moved(name), "pelvis", "Lthigh"))))
        for name in SPEEDS
    ]
    assert hips[0] < hips[1] < hips[2]


def test_markers_show_the_same_as_bones(taken: Callable[[str], Take], moved: Moved) -> None:
    """Knee flexion from markers alone, as an operator would see it."""
    take, movement = taken("treadmill"), moved("treadmill")
    at = {label: take.positions[:, take.index(label)] for label in take.labels}
    knee, ankle = (0.5 * (at["R" + a] + at["R" + b]) for a, b in (("KNE", "KNM"), ("ANK", "MED")))
    hip = movement.segments["Rthigh"].origin
    thigh, shank = knee - hip, ankle - knee
    cosine = np.sum(thigh * shank, axis=1) / (
        np.linalg.norm(thigh, axis=1) * np.linalg.norm(shank, axis=1)
    )
    bones = -flexion(movement, "Rthigh", "Rshank")
    assert np.quantile(abs(np.degrees(np.arccos(cosine)) - bones), 0.95) < 4.0
