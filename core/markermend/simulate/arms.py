"""Shoulder girdle, arm and hand."""

import numpy as np

from markermend.model import FloatArray
from markermend.simulate.body import SIGN, Body, Side
from markermend.simulate.curves import ahead_by, keyed, smooth, turned
from markermend.simulate.frames import Drive, Frames
from markermend.simulate.script import Script


def arm(
    time: FloatArray,
    script: Script,
    body: Body,
    side: Side,
    thorax: Frames,
    drive: Drive,
    noise: dict[str, FloatArray],
    rate: float,
) -> dict[str, Frames]:
    """Swing the arm against the leg of its side; lay the hand on the thigh; raise it.

    Shoulder about 20 degrees back to 15 forward and elbow 10 to 45 degrees at a common speed
    (Murray, Sepic and Barnard, *Physical Therapy* 47 (1967) 272-284).
    """
    sign = SIGN[side]
    forth = -sign * ahead_by(drive.stride, -0.05, rate)
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
