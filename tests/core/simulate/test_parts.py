"""The parts that movements are made of: curves, legs, body, markers."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from markermend.errors import BadParameter, UnknownName
from markermend.simulate import SCENARIOS, simulate
from markermend.simulate.body import PARENT, SIDES, Body
from markermend.simulate.curves import keyed, rise, wander
from markermend.simulate.legs import reach, solve_leg
from markermend.simulate.markers import LABELS, markers_of
from markermend.simulate.walking import WALK_RATIO, Cadence, Place, along, walk


@given(start=st.floats(-5, 5), lasts=st.floats(0.1, 5), at=st.lists(st.floats(-20, 20), min_size=2))
def test_a_rise_goes_from_0_to_1_and_never_back(
    start: float, lasts: float, at: list[float]
) -> None:
    values = rise(np.sort(at), start, start + lasts)
    assert (np.diff(values) >= 0).all()
    assert ((values >= 0) & (values <= 1)).all()
    np.testing.assert_allclose(rise(np.array([start, start + lasts]), start, start + lasts), [0, 1])


def test_keys_are_reached_and_rested_at() -> None:
    time = np.linspace(0, 10, 1001)
    values = keyed(time, ((1.0, 2.0), (3.0, -1.0), (4.0, -1.0), (6.0, 5.0)))
    np.testing.assert_allclose(values[[0, 100, 300, 350, 400, 600, 1000]], [2, 2, -1, -1, -1, 5, 5])
    assert abs(np.gradient(values, time)[[100, 300, 400, 600]]).max() < 0.01


def test_wandering_has_unit_variance_and_is_smooth() -> None:
    values = wander(np.random.default_rng(1), 20000, 8, 0.3, 100.0)
    assert abs(values.std() - 1.0) < 0.05
    # A Gaussian-smoothed white noise has a derivative of standard deviation 1 / (sqrt(2) sigma).
    assert np.diff(values, axis=0).std() * 100 == pytest.approx(1 / (np.sqrt(2) * 0.3), rel=0.05)


@given(
    at=st.tuples(st.floats(-250, 250), st.floats(-200, 200), st.floats(420, 800)),
    yaw=st.floats(-3, 3),
    thigh=st.floats(380, 480),
    shank=st.floats(380, 480),
)
def test_a_solved_leg_has_its_lengths_and_bends_forward(
    at: tuple[float, float, float], yaw: float, thigh: float, shank: float
) -> None:
    hip, ankle = np.array([at]), np.zeros((1, 3))
    if np.linalg.norm(hip) > 0.999 * (thigh + shank):
        return
    forward = np.array([[np.cos(yaw), np.sin(yaw), 0.0]])
    leg = solve_leg(hip, ankle, forward, thigh, shank)
    assert np.linalg.norm(leg.knee - hip) == pytest.approx(thigh)
    assert np.linalg.norm(leg.knee - ankle) == pytest.approx(shank)
    # Off the line from ankle to hip, the knee lies on the side of `forward`.
    line = hip[0] / np.linalg.norm(hip)
    off = leg.knee[0] - (leg.knee[0] @ line) * line
    assert off @ forward[0] > 0.0
    for rotation in (leg.thigh[0], leg.shank[0]):
        np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-9)
        assert np.linalg.det(rotation) == pytest.approx(1.0)
    np.testing.assert_allclose(leg.knee[0] - hip[0], -thigh * leg.thigh[0][:, 2], atol=1e-6)


def test_reach_is_the_law_of_cosines() -> None:
    assert float(reach(400.0, 300.0, 0.0)) == pytest.approx(700.0)
    assert float(reach(400.0, 300.0, np.pi / 2)) == pytest.approx(500.0)


@given(st.floats(1200, 2100))
def test_the_body_adds_up_as_published(height: float) -> None:
    body = Body(height)
    # Drillis and Contini: hip at 0.530, shoulder at 0.818 of the height.
    hip = body.ankle_height + body.shank + body.thigh
    assert hip == pytest.approx(0.530 * height, rel=0.001)
    shoulder = hip + (body.lumbar + body.sternoclavicular("L") + body.shoulder("L"))[2]
    assert shoulder == pytest.approx(0.818 * height, rel=0.02)
    assert body.heel[2] == body.ball[2] == -body.ankle_height


def test_there_are_53_markers_each_on_a_segment() -> None:
    assert len(LABELS) == len(set(LABELS)) == 53
    markers = markers_of(Body())
    assert {marker.segment for marker in markers} == {"pelvis", *PARENT}
    for side in SIDES:
        for name in ("FHD", "BHD", "SHO", "ELB", "WRA", "WRB", "FIN", "ASI", "PSI", "KNE", "ANK"):
            assert side + name in LABELS
    shifted = markers_of(Body(), np.random.default_rng(0))
    assert max(abs(a.offset - b.offset).max() for a, b in zip(markers, shifted, strict=True)) <= 7


@given(st.floats(500, 2000))
def test_speed_is_step_length_times_cadence(speed: float) -> None:
    pace = Cadence(speed)
    assert pace.step_length * pace.per_minute / 60 == pytest.approx(speed)
    assert pace.step_length / pace.per_minute == pytest.approx(WALK_RATIO)
    assert 0.5 < 1 - pace.swing_s / (2 * pace.step_s) < 0.7


def test_a_path_is_followed_to_its_end() -> None:
    start, path = Place(0, 0, 0), ((1000.0, 0.0), (np.pi * 500, 180.0), (1000.0, 0.0))
    steps, end = walk(start, path, 1100.0, 0.0, "L", np.random.default_rng(0))
    assert (end.x, end.y) == (pytest.approx(0.0, abs=1e-9), pytest.approx(1000.0))
    assert end.yaw == pytest.approx(np.pi)
    assert along(start, path, 1e9).x == pytest.approx(end.x, abs=1e-6)
    last = steps[-2:]
    assert {step.side for step in last} == {"L", "R"}
    assert np.mean([step.to.x for step in last]) == pytest.approx(end.x, abs=1)
    assert all(a.land_s < b.land_s and a.side != b.side for a, b in pairwise(steps))


def test_what_cannot_be_simulated_is_refused() -> None:
    with pytest.raises(UnknownName, match="scenario 'fly'; known are static, sitting, walk"):
        simulate("fly")
    for name, value in (("duration_s", 99.0), ("rate", 7.0), ("height", 17.0)):
        with pytest.raises(BadParameter, match=f"{name} must be in"):
            simulate("static", **{name: value})  # type: ignore[arg-type]


@pytest.mark.parametrize("scenario", ["treadmill", "demo"])
def test_a_seed_says_all(scenario: str) -> None:
    one, same, other = (simulate(scenario, seed, duration_s=2.0) for seed in (5, 5, 6))
    assert np.array_equal(one.positions, same.positions)
    assert not np.allclose(one.positions, other.positions, atol=1.0)


def test_duration_rate_and_height_are_obeyed() -> None:
    take = simulate("walk", duration_s=3.0, rate=120.0, height=1500.0)
    assert (take.n_frames, take.n_markers, take.rate, take.units) == (360, 53, 120.0, "mm")
    top = take.positions[:20, take.index("LBHD"), 2].mean()
    assert 0.9 * 1500 < top < 1.0 * 1500


def test_the_scenarios_of_the_paper_last_as_printed() -> None:
    durations = {
        name: write(np.random.default_rng(0)).duration_s for name, write in SCENARIOS.items()
    }
    assert (durations["static"], durations["sitting"]) == (22.0, 29.0)
    assert len(SCENARIOS) == 7
