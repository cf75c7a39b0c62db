"""From a script to the frames of all segments over time."""

from dataclasses import dataclass, replace

import numpy as np

from markermend.model import FloatArray
from markermend.simulate.body import SIDES, SIGN, Body, Side
from markermend.simulate.curves import keyed, placed, smooth, turned, wander
from markermend.simulate.feet import FootMotion, foot_motion, load_left
from markermend.simulate.legs import solve_leg
from markermend.simulate.pelvis import Seating, pelvis_path, seating
from markermend.simulate.script import Script

RUNS_OUT_S = 1.5
"""Time that is moved beyond both ends and cut off, so that no smoothing shows at the ends."""


@dataclass(frozen=True, eq=False)
class Frames:
    """A segment over time: its proximal joint, (n, 3), and its rotation, (n, 3, 3)."""

    origin: FloatArray
    rotation: FloatArray

    def point(self, offset: FloatArray) -> FloatArray:
        """Where a point of the segment is in the lab, (n, 3)."""
        return self.origin + placed(self.rotation, offset)


@dataclass(frozen=True, eq=False)
class Movement:
    """A body in motion.

    Attributes
    ----------
    body
        Whose.
    rate
        Hz.
    segments
        The frames of every segment.
    feet
        The motion of both feet; on a treadmill relative to the belt.
    belt
        (n,) mm: how far the belt has moved towards -x.
    """

    body: Body
    rate: float
    segments: dict[str, Frames]
    feet: dict[Side, FootMotion]
    belt: FloatArray


@dataclass(frozen=True, eq=False)
class _Drive:
    """What the whole body follows, (n,) each: radians but for `stride` and `share`."""

    heading: FloatArray
    stride: FloatArray
    share: FloatArray
    seated: Seating


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
    feet = {
        side: foot_motion(time, body, side, script.start[side], script.steps) for side in SIDES
    }
    load = load_left(feet["L"], feet["R"], keyed(time, script.load_left))
    drive = _drive(time, script, feet, load, rate)
    noise = _irregularities(rng, len(time), rate)
    trunk = _trunk(time, script, body, feet, load, drive, noise, rate)
    segments = trunk | _legs(body, feet, trunk["pelvis"], drive)
    for side in SIDES:
        segments |= _arm(time, script, body, side, segments["thorax"], drive, noise, rate)
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
) -> _Drive:
    heading = smooth(0.5 * (feet["L"].yaw + feet["R"].yaw), 0.22, rate)
    apart = (feet["L"].ankle - feet["R"].ankle)[:, :2]
    ahead = apart[:, 0] * np.cos(heading) + apart[:, 1] * np.sin(heading)
    return _Drive(
        heading,
        smooth(ahead / 650.0, 0.05, rate),
        smooth(load, 0.11, rate),
        seating(time, script.seats),
    )


_CHANNELS = ("lean", "side", "twist", "head_lean", "head_turn", "tilt", "list") + tuple(
    side + joint
    for side in SIDES
    for joint in ("flex", "spread", "turn", "elbow", "roll", "wrist", "girdle", "shrug")
)


def _irregularities(rng: np.random.Generator, n_frames: int, rate: float) -> dict[str, FloatArray]:
    """No two movements are the same: slow and quicker wandering of each joint, in radians."""
    slow = wander(rng, n_frames, len(_CHANNELS), 0.9, rate)
    quick = wander(rng, n_frames, len(_CHANNELS), 0.16, rate)
    mixed = np.radians(0.8 * slow + 0.12 * quick)
    return dict(zip(_CHANNELS, mixed.T, strict=True))


def _trunk(
    time: FloatArray,
    script: Script,
    body: Body,
    feet: dict[Side, FootMotion],
    load: FloatArray,
    drive: _Drive,
    noise: dict[str, FloatArray],
    rate: float,
) -> dict[str, Frames]:
    """Pelvis, thorax and head.

    Pelvis: 4 to 5 degrees of turning and of listing towards the leg that swings (Perry and
    Burnfield 2010, chapter 6); the thorax turns the other way; head before trunk in turns.
    """
    seated, stride = drive.seated, drive.stride
    walking = smooth(np.abs(stride), 0.4, rate)
    list_ = np.radians(7.0) * (drive.share - 0.5) * np.minimum(1.0, 2.2 * walking)
    list_ += np.radians(2.5) * (drive.share - 0.5)
    lean = seated.lean * (1.0 - 0.25 * seated.rest)
    tilt = np.radians(1.5 * walking + 22.0 * lean - 14.0 * seated.rest)
    pelvis_turn = drive.heading - np.radians(5.0) * stride
    rotation = (
        turned("z", pelvis_turn)
        @ turned("x", list_ + 0.5 * noise["list"])
        @ turned("y", tilt + 0.5 * noise["tilt"])
    )
    path = pelvis_path(body, feet, load, rotation, drive.heading, seated, rate)
    pelvis = Frames(path.origin, path.rotation)
    bob = path.origin[:, 2] - smooth(path.origin[:, 2], 0.25, rate)
    thorax_turn = _ahead(drive.heading, 0.08, rate) + np.radians(4.5) * _ahead(stride, -0.03, rate)
    look = np.radians(keyed(time, script.look))
    thorax = Frames(
        pelvis.point(body.lumbar),
        turned("z", thorax_turn + noise["twist"] + 0.16 * look)
        @ turned("x", -0.25 * list_ + np.radians(1.5) * (0.5 - drive.share) + noise["side"])
        @ turned(
            "y",
            np.radians(2.0 + 2.0 * walking + 37.0 * lean - 1.0 * seated.rest)
            + 0.0006 * bob
            + noise["lean"],
        ),
    )
    nod = np.radians(2.0 + keyed(time, script.nod) + 13.0 * lean)
    head = Frames(
        thorax.point(body.neck),
        turned("z", _ahead(drive.heading, 0.22, rate) + look + noise["head_turn"])
        @ turned("x", 0.3 * noise["side"] + 0.06 * look)
        @ turned("y", nod - 0.0008 * bob + noise["head_lean"]),
    )
    return {"pelvis": pelvis, "thorax": thorax, "head": head}


def _ahead(values: FloatArray, by_s: float, rate: float) -> FloatArray:
    """Take the values from `by_s` later (from before, where negative)."""
    frames = np.clip(np.arange(len(values)) + round(by_s * rate), 0, len(values) - 1)
    return values[frames]


def _legs(
    body: Body, feet: dict[Side, FootMotion], pelvis: Frames, drive: _Drive
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


def _arm(
    time: FloatArray,
    script: Script,
    body: Body,
    side: Side,
    thorax: Frames,
    drive: _Drive,
    noise: dict[str, FloatArray],
    rate: float,
) -> dict[str, Frames]:
    """Swing the arm against the leg of its side; lay the hand on the thigh; raise it.

    Shoulder about 20 degrees back to 15 forward and elbow 10 to 45 degrees at a common speed
    (Murray, Sepic and Barnard, *Phys. Ther.* 47 (1967) 272-284).
    """
    sign = SIGN[side]
    forth = -sign * _ahead(drive.stride, -0.05, rate)
    stepping = smooth(np.abs(drive.stride), 0.4, rate)
    seated = drive.seated
    lap = seated.rest
    wave = keyed(time, script.wave) if side == "R" else np.zeros_like(time)
    flex = np.radians(-2.0 + 17.0 * forth + 3.0 * stepping)
    elbow = np.radians(14.0 + 8.0 * stepping + 10.0 * forth + 4.0 * forth * np.abs(forth))
    spread = np.full_like(time, np.radians(8.0))
    turn = np.full_like(time, np.radians(14.0))
    roll = np.full_like(time, np.radians(12.0))
    # While the trunk bends, the arms hang down from it and reach for the knees.
    flex += np.radians(34.0) * seated.lean * (1.0 - 0.3 * lap)
    elbow += np.radians(8.0) * seated.lean
    for blend, pose in (
        (lap, (21.0, 10.0, 18.0, 48.0, 62.0)),
        (wave, (52.0, 22.0, -14.0, 106.0, 25.0)),
    ):
        for values, target in zip((flex, spread, turn, elbow, roll), pose, strict=True):
            values += blend * (np.radians(target) - values)
    turn += np.radians(13.0) * wave**3 * np.sin(2.0 * np.pi * 1.7 * time)
    raised = flex - np.radians(5.0)
    girdle = (
        thorax.rotation
        @ turned("z", -sign * (0.14 * raised + noise[side + "girdle"]))
        @ turned("x", sign * (0.10 * np.abs(raised) + 0.7 * noise[side + "shrug"]))
    )
    clavicle = Frames(thorax.point(body.sternoclavicular(side)), girdle)
    upper = (
        thorax.rotation
        @ turned("y", -(flex + noise[side + "flex"]))
        @ turned("x", sign * (spread + noise[side + "spread"]))
        @ turned("z", -sign * (turn + noise[side + "turn"]))
    )
    upperarm = Frames(clavicle.point(body.shoulder(side)), upper)
    fore = (
        upper
        @ turned("y", -np.maximum(elbow + 1.5 * noise[side + "elbow"], np.radians(2.0)))
        @ turned("z", -sign * (roll + 2.0 * noise[side + "roll"]))
    )
    forearm = Frames(upperarm.point(np.array([0.0, 0.0, -body.upperarm])), fore)
    wrist = np.radians(4.0) * forth + 3.0 * noise[side + "wrist"] + np.radians(10.0) * lap
    bend = turned("x", sign * wrist) @ turned("y", -1.5 * noise[side + "flex"])
    hand = Frames(forearm.point(np.array([0.0, 0.0, -body.forearm])), fore @ bend)
    return {
        side + "clavicle": clavicle,
        side + "upperarm": upperarm,
        side + "forearm": forearm,
        side + "hand": hand,
    }
