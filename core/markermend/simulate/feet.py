"""How a foot moves from foothold to foothold: planted, rolling over heel and ball, swinging.

The pitch of the foot follows published gait: about 20 degrees up at heel strike, flat after a tenth
of the cycle, the heel rising from a third of it on, 55 to 60 degrees down at toe-off (Perry and
Burnfield, *Gait Analysis*, 2nd ed., 2010, chapter 4). While it stands the foot turns about a point
of its sole that does not move; so it cannot slide.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import BPoly

from markermend.model import BoolArray, FloatArray, Span
from markermend.simulate.body import Body, Side
from markermend.simulate.curves import placed, rise, smooth, turned
from markermend.simulate.script import Foothold, Step

STRIKE_PITCH = np.radians(21.0)
TOE_OFF_PITCH = np.radians(-56.0)
LANDING_S = 0.13
"""From heel strike to the flat foot."""
SWING_THRUST = 4.0
"""Acceleration at toe-off, relative to the way of the swing over its squared duration."""
LANDING_SPEED = 0.12
"""Speed at heel strike, relative to the mean speed of the swing: the heel stops with a jerk."""
LANDING_BRAKE = 5.0
"""Deceleration at heel strike, relative to the way of the swing over its squared duration."""
CLEARANCE = 16.0
"""What the sole keeps above the floor in the middle of a swing, in mm."""


@dataclass(frozen=True, eq=False)
class FootMotion:
    """One foot over time.

    Attributes
    ----------
    ankle
        (n, 3) mm.
    pitch, yaw
        (n,) radians; toes up, and heading to the left.
    planted
        (n,): whether any part of the sole stands on the floor.
    anchor
        (n, 2) mm: where the ankle is when the foot is flat; in a swing the last one.
    since_land, until_lift
        (n,) s: time since the last landing and until the next lift; large where there is none.
    roll_in, roll_out
        (n,): `Step.roll` of the step before and after each frame.
    """

    ankle: FloatArray
    pitch: FloatArray
    yaw: FloatArray
    planted: BoolArray
    anchor: FloatArray
    since_land: FloatArray
    until_lift: FloatArray
    roll_in: FloatArray
    roll_out: FloatArray

    @property
    def rotation(self) -> FloatArray:
        """(n, 3, 3), foot frame to lab."""
        return turned("z", self.yaw) @ turned("y", -self.pitch)


def foot_motion(
    time: FloatArray, body: Body, side: Side, start: Foothold, steps: Sequence[Step]
) -> FootMotion:
    """Move one foot through its steps.

    Parameters
    ----------
    time
        (n,) s, evenly spaced.
    body
        Whose foot.
    side, steps
        The foot, and the steps of both feet in order of time.
    start
        Where it stands at first.
    """
    rate = 1.0 / (time[1] - time[0])
    own = [
        _on_frames(step, time, rate)
        for step in steps
        if step.side == side and step.land_s < time[-2]
    ]
    swings = [_swing(step, time, rate) for step in own]
    anchor, yaw = _holds(time, start, own)
    since, until, roll_in, roll_out = _clocks(time, own)
    planted = np.ones(len(time), bool)
    for swing in swings:
        planted[swing.frames] = False
    pitch = _pitch(time, own, swings, since, until, roll_in, roll_out)
    ankle = _rolling(body, anchor, yaw, pitch)
    for step, swing in zip(own, swings, strict=True):
        ankle[swing.frames] = _swung(body, ankle, yaw, pitch, swing, step, rate)
    return FootMotion(ankle, pitch, yaw, planted, anchor, since, until, roll_in, roll_out)


def _on_frames(step: Step, time: FloatArray, rate: float) -> Step:
    """Let the foot lift and land exactly at frames."""
    first = max(1, round((step.lift_s - time[0]) * rate))
    last = max(first + 2, round((step.land_s - time[0]) * rate))
    return replace(step, lift_s=float(time[first]), land_s=float(time[last]))


def _swing(step: Step, time: FloatArray, rate: float) -> Span:
    return Span(round((step.lift_s - time[0]) * rate), round((step.land_s - time[0]) * rate))


def _holds(time: FloatArray, start: Foothold, own: Sequence[Step]) -> tuple[FloatArray, FloatArray]:
    """Where the foot is glued to (it changes at landing), and its heading (turns in the swing)."""
    anchor = np.tile((start.x, start.y), (len(time), 1))
    yaw = np.full(len(time), start.yaw)
    before = start.yaw
    for step in own:
        anchor[time >= step.land_s - 1e-9] = (step.to.x, step.to.y)
        yaw += (step.to.yaw - before) * rise(time, step.lift_s, step.land_s)
        before = step.to.yaw
    return anchor, yaw


def _clocks(
    time: FloatArray, own: Sequence[Step]
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    since, until = np.full(len(time), 60.0), np.full(len(time), 60.0)
    roll_in, roll_out = np.zeros(len(time)), np.zeros(len(time))
    for step in own:
        later = time >= step.land_s - 1e-9
        since[later], roll_in[later] = time[later] - step.land_s, step.roll
    for step in reversed(own):
        earlier = time <= step.lift_s + 1e-9
        until[earlier], roll_out[earlier] = step.lift_s - time[earlier], step.roll
    return since, until, roll_in, roll_out


def _pitch(
    time: FloatArray,
    own: Sequence[Step],
    swings: Sequence[Span],
    since: FloatArray,
    until: FloatArray,
    roll_in: FloatArray,
    roll_out: FloatArray,
) -> FloatArray:
    """Pitch of the foot: landing, flat, heel rise; and in a swing back from one to the other."""
    rate = 1.0 / (time[1] - time[0])
    landing = np.clip(1.0 - since / LANDING_S, 0.0, 1.0)
    pitch = STRIKE_PITCH * roll_in * landing**1.6
    rising_s = np.minimum(0.12 + 0.24 * roll_out, 0.45 * (since + until))
    rising = np.clip(1.0 - until / rising_s, 0.0, 1.0)
    leaving = 0.25 + 0.75 * roll_out
    pitch += TOE_OFF_PITCH * leaving * rising**2.6 * (1.5 - 0.5 * rising)
    for step, swing in zip(own, swings, strict=True):
        a, b = swing.start - 1, swing.stop
        start = TOE_OFF_PITCH * (0.25 + 0.75 * step.roll)
        end = STRIKE_PITCH * step.roll
        lasts = (b - a) / rate
        # The foot still turns down when it leaves, and already turns down again when it lands.
        leave_rate, land_rate = start * 3.5, -end * 1.0
        curve = BPoly.from_derivatives(
            [0.0, 0.72 * lasts, lasts],
            [[start, leave_rate], [0.18 * start * (1 - step.roll)], [end, land_rate]],
        )
        pitch[a : b + 1] = curve(np.arange(b - a + 1) / rate)
    return smooth(pitch, 0.012, rate)


def _rolling(body: Body, anchor: FloatArray, yaw: FloatArray, pitch: FloatArray) -> FloatArray:
    """Ankle of a foot that stands: turned about the heel, or about the ball, which stays put."""
    heading, tilt = turned("z", yaw), turned("y", -pitch)
    ground = np.column_stack([anchor, np.full(len(anchor), body.ankle_height)])
    pivot = np.where(pitch[:, None] > 0.0, body.heel, body.ball)
    moved = pivot - np.einsum("nij,nj->ni", tilt, pivot)
    ankle: FloatArray = ground + np.einsum("nij,nj->ni", heading, moved)
    return ankle


def _swung(
    body: Body,
    ankle: FloatArray,
    yaw: FloatArray,
    pitch: FloatArray,
    swing: Span,
    step: Step,
    rate: float,
) -> FloatArray:
    """Ankle in a swing: leaves and lands with the velocity of the rolling foot."""
    a, b = swing.start - 1, swing.stop
    lasts = (b - a) / rate
    leave = (ankle[a] - ankle[a - 1]) * rate
    following = min(b + 1, len(ankle) - 1)
    land = (ankle[following] - ankle[b]) * rate
    way = step.roll * (ankle[b] - ankle[a]) * (1.0, 1.0, 0.0)
    thrust = SWING_THRUST * way / lasts**2
    land += LANDING_SPEED * way / lasts
    curve = BPoly.from_derivatives(
        [0.0, lasts], [[ankle[a], leave, thrust], [ankle[b], land, -LANDING_BRAKE * way / lasts**2]]
    )
    time = np.arange(1, b - a) / rate
    path: FloatArray = curve(time)
    s = time / lasts
    hump = (s * (1.0 - s) ** 1.6 / 0.17688) ** 2.5
    path[:, 2] += (55.0 - 30.0 * step.roll) * body.scale * hump
    rotation = turned("z", yaw[swing.frames]) @ turned("y", -pitch[swing.frames])
    lowest = path[:, 2] + np.minimum(
        placed(rotation, body.heel)[:, 2], placed(rotation, body.ball)[:, 2]
    )
    lacking = CLEARANCE * np.minimum(1.0, 4.0 * s * (1.0 - s)) - lowest
    # Zero at both ends, so that the foot leaves and lands where it should.
    lifted = smooth(np.pad(np.maximum(lacking, 0.0), 30), 0.03, rate)[30:-30]
    path[:, 2] += lifted * (1.0 - (2.0 * s - 1.0) ** 8)
    return path


def load_left(left: FootMotion, right: FootMotion, standing: FloatArray) -> FloatArray:
    """Share of the weight on the left foot, (n,): all of it while the right one swings.

    Parameters
    ----------
    left, right
        Both feet.
    standing
        (n,): the share while both stand.
    """
    both = left.planted & right.planted
    return np.where(both, standing, left.planted.astype(np.float64))
