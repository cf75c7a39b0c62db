"""From a script to the frames of all segments over time."""

from dataclasses import replace

import numpy as np

from markermend.model import FloatArray
from markermend.simulate.arms import arm
from markermend.simulate.body import SIDES, Body, Side
from markermend.simulate.curves import keyed, smooth, wander
from markermend.simulate.feet import FootMotion, foot_motion, load_left
from markermend.simulate.frames import Drive, Frames, Movement
from markermend.simulate.legs import solve_leg
from markermend.simulate.pelvis import seating
from markermend.simulate.script import Script
from markermend.simulate.trunk import trunk

RUNS_OUT_S = 1.5
"""Time that is moved beyond both ends and cut off, so that no smoothing shows at the ends."""


def move(script: Script, body: Body, rate: float, rng: np.random.Generator) -> Movement:
    """Play a script.

    Parameters
    ----------
    script
        What the person does.
    body, rate
        Who, and how many frames a second.
    rng
        Source of the small irregularities of every movement.
    """
    before = round((RUNS_OUT_S + script.preroll_s) * rate)
    after = round(RUNS_OUT_S * rate)
    n_frames = round(script.duration_s * rate)
    time = (np.arange(n_frames + before + after) - before) / rate
    feet = {side: foot_motion(time, body, side, script.start[side], script.steps) for side in SIDES}
    load = load_left(feet["L"], feet["R"], keyed(time, script.load_left))
    drive = _drive(time, script, feet, load, rate)
    noise = _irregularities(rng, len(time), rate)
    spine = trunk(time, script, body, feet, load, drive, noise, rate)
    segments = spine | _legs(body, feet, spine["pelvis"], drive)
    for side in SIDES:
        segments |= arm(time, script, body, side, segments["thorax"], drive, noise, rate)
    belt = script.belt * time
    kept = slice(before, before + n_frames)
    shift = np.column_stack([belt, np.zeros((len(belt), 2))])
    return Movement(
        body,
        rate,
        {
            name: Frames((frames.origin - shift)[kept], frames.rotation[kept])
            for name, frames in segments.items()
        },
        {side: _cut(foot, kept) for side, foot in feet.items()},
        belt[kept],
    )


def _cut(foot: FootMotion, kept: slice) -> FootMotion:
    return replace(foot, **{name: values[kept] for name, values in vars(foot).items()})


def _drive(
    time: FloatArray,
    script: Script,
    feet: dict[Side, FootMotion],
    load: FloatArray,
    rate: float,
) -> Drive:
    heading = smooth(0.5 * (feet["L"].yaw + feet["R"].yaw), 0.22, rate)
    apart = (feet["L"].ankle - feet["R"].ankle)[:, :2]
    ahead = apart[:, 0] * np.cos(heading) + apart[:, 1] * np.sin(heading)
    return Drive(
        heading,
        smooth(ahead / 650.0, 0.05, rate),
        smooth(load, 0.11, rate),
        seating(time, script.seats),
    )


_ARM = ("flex", "spread", "turn", "elbow", "roll", "wrist", "girdle", "shrug")
_TRUNK = ("lean", "side", "twist", "head_lean", "head_turn", "tilt", "list")
_CHANNELS = (*_TRUNK, *(side + joint for side in SIDES for joint in _ARM))


def _irregularities(rng: np.random.Generator, n_frames: int, rate: float) -> dict[str, FloatArray]:
    """No two movements are the same: slow and quicker wandering of each joint, in radians."""
    slow = wander(rng, n_frames, len(_CHANNELS), 0.9, rate)
    quick = wander(rng, n_frames, len(_CHANNELS), 0.16, rate)
    mixed = np.radians(0.8 * slow + 0.12 * quick)
    return dict(zip(_CHANNELS, mixed.T, strict=True))


def _legs(
    body: Body, feet: dict[Side, FootMotion], pelvis: Frames, drive: Drive
) -> dict[str, Frames]:
    segments = {}
    for side in SIDES:
        foot = feet[side]
        hip = pelvis.point(body.hip(side))
        # Knees point where the feet do, more than where the pelvis does.
        knee_yaw = drive.heading + 0.6 * (foot.yaw - drive.heading)
        forward = np.column_stack([np.cos(knee_yaw), np.sin(knee_yaw), np.full(len(hip), 0.1)])
        leg = solve_leg(hip, foot.ankle, forward, body.thigh, body.shank)
        segments[side + "thigh"] = Frames(hip, leg.thigh)
        segments[side + "shank"] = Frames(leg.knee, leg.shank)
        segments[side + "foot"] = Frames(foot.ankle, foot.rotation)
    return segments
