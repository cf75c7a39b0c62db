"""Pelvis, thorax and head."""

import numpy as np

from markermend.model import FloatArray
from markermend.simulate.body import Body, Side
from markermend.simulate.curves import ahead_by, keyed, smooth, turned
from markermend.simulate.feet import FootMotion
from markermend.simulate.frames import Drive, Frames
from markermend.simulate.pelvis import pelvis_path
from markermend.simulate.script import Script


def trunk(
    time: FloatArray,
    script: Script,
    body: Body,
    feet: dict[Side, FootMotion],
    load: FloatArray,
    drive: Drive,
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
    thorax_turn = ahead_by(drive.heading, 0.08, rate) + np.radians(4.5) * ahead_by(
        stride, -0.03, rate
    )
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
        turned("z", ahead_by(drive.heading, 0.22, rate) + look + noise["head_turn"])
        @ turned("x", 0.3 * noise["side"] + 0.06 * look)
        @ turned("y", nod - 0.0008 * bob + noise["head_lean"]),
    )
    return {"pelvis": pelvis, "thorax": thorax, "head": head}
