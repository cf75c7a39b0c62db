"""The path of the pelvis: over the feet that carry it, as high as bent knees allow, onto a seat.

Height over a standing foot follows the published flexion of the knee in stance: 5 degrees at heel
strike, about 18 after 12 % of the cycle, 6 before the heel rises and near 40 at toe-off (Winter,
*The Biomechanics and Motor Control of Human Gait*, 2nd ed., 1991, table 3.32(b)).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from markermend.model import FloatArray
from markermend.simulate.body import SIDES, Body, Side
from markermend.simulate.curves import placed, rise, smooth
from markermend.simulate.feet import FootMotion
from markermend.simulate.legs import MOST_STRETCHED, reach
from markermend.simulate.script import Seat

ALMOST_STRAIGHT = np.radians(5.0)
"""Flexion below which a knee does not go but for a moment."""
AHEAD = 28.0
"""A standing person's hips are this far in front of the ankles, in mm."""


@dataclass(frozen=True, eq=False)
class Pelvis:
    """Midpoint of the hips, (n, 3), and the pelvis' rotation, (n, 3, 3)."""

    origin: FloatArray
    rotation: FloatArray

    def hip(self, body: Body, side: Side) -> FloatArray:
        """Hip joint centre, (n, 3)."""
        return self.origin + placed(self.rotation, body.hip(side))


@dataclass(frozen=True, eq=False)
class Seating:
    """How far seated, from 0 to 1, (n,) each.

    `back` is the way backwards, `down` the way down, `lean` how far the trunk is bent forward on
    the way (most when the seat is left or met), and `rest` whether the person sits back.
    """

    back: FloatArray
    down: FloatArray
    lean: FloatArray
    rest: FloatArray


def seating(time: FloatArray, seats: Sequence[Seat]) -> Seating:
    """Sit down and stand up: the trunk bends first, then the hips move.

    Phases after Schenkman et al., *Physical Therapy* 70 (1990) 638-648: flexion momentum, momentum
    transfer, extension.
    """
    back, down, lean, rest = (np.zeros_like(time) for _ in range(4))
    for seat in seats:
        a, b, d = seat.sit_s, seat.stand_s, seat.takes_s
        down += rise(time, a + 0.10 * d, a + 0.88 * d) - rise(time, b + 0.26 * d, b + d)
        back += rise(time, a, a + 0.72 * d) - rise(time, b + 0.22 * d, b + 0.92 * d)
        lean += rise(time, a, a + 0.62 * d) - rise(time, a + 0.66 * d, a + 1.25 * d)
        lean += rise(time, b - 0.14 * d, b + 0.40 * d) - rise(time, b + 0.42 * d, b + 1.02 * d)
        rest += rise(time, a + 0.7 * d, a + 1.3 * d) - rise(time, b - 0.2 * d, b + 0.3 * d)
    return Seating(back, down, lean, rest)


def pelvis_path(
    body: Body,
    feet: dict[Side, FootMotion],
    load: FloatArray,
    rotation: FloatArray,
    heading: FloatArray,
    seated: Seating,
    rate: float,
) -> Pelvis:
    """Carry the pelvis over the feet.

    Parameters
    ----------
    body, feet
        Whose pelvis, and over which feet.
    load
        (n,): share of the weight on the left foot, not yet smoothed.
    rotation
        (n, 3, 3): how the pelvis is turned.
    heading
        (n,) radians: where the person faces.
    seated
        How far seated.
    """
    weights: dict[Side, FloatArray] = {"L": load, "R": 1.0 - load}
    # A person passes the weight on while moving; this also gives the sway of the gait.
    carried = sum(weights[side][:, None] * feet[side].anchor for side in SIDES)
    ground = smooth(np.asarray(carried), 0.2, rate)
    middle = smooth(0.5 * (feet["L"].anchor + feet["R"].anchor), 0.3, rate)
    facing = np.column_stack([np.cos(heading), np.sin(heading)])
    walking = smooth(np.maximum(feet["L"].roll_in, feet["L"].roll_out), 0.3, rate)
    ground = ground + (AHEAD * (1.0 + 1.6 * walking**2) * body.scale)[:, None] * facing
    seat = middle - 0.80 * body.thigh * facing
    ground += seated.back[:, None] * (seat - ground)
    hips = {side: ground + placed(rotation, body.hip(side))[:, :2] for side in SIDES}
    lift = {side: placed(rotation, body.hip(side))[:, 2] for side in SIDES}
    height = _carried_height(body, feet, load, hips, lift, rate)
    height += seated.down * (body.sitting_hip_height - height)
    height = np.minimum(height, _highest(body, feet, hips, lift, rate))
    return Pelvis(np.column_stack([ground, height]), rotation)


def _carried_height(
    body: Body,
    feet: dict[Side, FootMotion],
    load: FloatArray,
    hips: dict[Side, FloatArray],
    lift: dict[Side, FloatArray],
    rate: float,
) -> FloatArray:
    """Height at which the loaded knees are bent as in published gait."""
    share = smooth(load, 0.045, rate)
    height = np.zeros(len(load))
    weights: dict[Side, FloatArray] = {"L": share, "R": 1.0 - share}
    for side in SIDES:
        foot = feet[side]
        height += weights[side] * (
            _height(body, foot, hips[side], stance_flexion(foot)) - lift[side]
        )
    return smooth(height, 0.05, rate)


def stance_flexion(foot: FootMotion) -> FloatArray:
    """Published flexion of the knee of a standing leg, (n,) in radians."""
    yielding = np.exp(-(((foot.since_land - 0.16) / 0.085) ** 2))
    leaving = np.clip(1.0 - foot.until_lift / 0.19, 0.0, 1.0) ** 2
    degrees = 4.5 + 13.0 * foot.roll_in * yielding + 34.0 * foot.roll_out * leaving
    return np.radians(degrees)


def _height(body: Body, foot: FootMotion, hip: FloatArray, flexion: FloatArray) -> FloatArray:
    away = np.linalg.norm(hip - foot.ankle[:, :2], axis=1)
    distance = reach(body.thigh, body.shank, flexion)
    height: FloatArray = foot.ankle[:, 2] + np.sqrt(np.maximum(distance**2 - away**2, 1.0))
    return height


def _highest(
    body: Body,
    feet: dict[Side, FootMotion],
    hips: dict[Side, FloatArray],
    lift: dict[Side, FloatArray],
    rate: float,
) -> FloatArray:
    """Height that no leg is too short for: a smooth curve below both legs' limits."""
    limit, hardest = (
        np.minimum(
            *(
                _height(body, feet[side], hips[side], np.full(len(lift[side]), flexion))
                - lift[side]
                for side in SIDES
            )
        )
        for flexion in (ALMOST_STRAIGHT, MOST_STRETCHED)
    )
    eased = smooth(limit, 0.04, rate)
    # Lower the smooth curve, smoothly, wherever it would still stretch a leg.
    for _ in range(40):
        excess = np.maximum(eased - limit, 0.0)
        if excess.max() < 1e-3:
            break
        eased = eased - 1.5 * smooth(excess, 0.04, rate) - 0.02 * excess
    return np.minimum(eased, hardest)
