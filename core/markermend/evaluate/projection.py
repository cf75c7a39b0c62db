"""A take as a single camera and OpenPose would have seen it: a stand-in for 2D recordings.

It is no recording: the points are means of markers near the joints, the camera is an ideal
pinhole, and the errors are simpler than those of a neural network.
"""

from collections.abc import Mapping

import numpy as np

from markermend.errors import BadInput
from markermend.model import BoolArray, FloatArray, Take, short

WIDTH, HEIGHT = 1920, 1080
"""Size of the picture in px."""
NOISE_PX = 1.5
"""Standard deviation of a point's error on each axis, independent from frame to frame."""
LOST, LOST_S = 0.02, 0.05
"""Share of the samples that are not detected, and how long on average a point stays so."""

Alternatives = tuple[tuple[str, ...], ...]


def _both_sides() -> Mapping[str, Alternatives]:
    points = {}
    for side in "RL":
        limbs: Mapping[str, Alternatives] = {
            "Shoulder": (("SHO",),),
            "Elbow": (("ELB", "ELM"), ("ELB",)),
            "Wrist": (("WRA", "WRB"),),
            "Hip": (("ASI", "PSI"), ("FWT", "BWT")),
            "Knee": (("KNE", "KNM"), ("KNE",)),
            "Ankle": (("ANK", "MED"), ("ANK",)),
            "Eye": (("FHD",),),
            "Ear": (("FHD", "BHD"),),
            "BigToe": (("TOE", "MT1"), ("TOE",)),
            "SmallToe": (("MT5",),),
            "Heel": (("HEE",),),
        }
        for name, sets in limbs.items():
            points[side + name] = tuple(tuple(side + m for m in markers) for markers in sets)
    return points


POINTS: Mapping[str, Alternatives] = {
    "Nose": (("LFHD", "RFHD"),),
    "Neck": (("C7", "CLAV"),),
    "MidHip": (("LASI", "RASI", "LPSI", "RPSI"), ("LFWT", "RFWT", "LBWT", "RBWT")),
    **_both_sides(),
}
"""OpenPose's 25 points, each the mean of the first of these sets of markers that a take has."""


def body25(take: Take) -> FloatArray:
    """Give OpenPose's 25 points from the markers near them.

    Returns
    -------
    (n_frames, 25, 3) mm, in the order of `POINTS`.

    Raises
    ------
    BadInput
        If the take lacks markers of the conventional names, or is of two dimensions.
    """
    if take.n_dims != 3:
        raise BadInput("Only a take of three dimensions can be projected; give one.")
    place = {short(take.labels[m]): m for m in take.measured}
    points, lacking = [], []
    for name, sets in POINTS.items():
        markers = next((s for s in sets if all(label in place for label in s)), None)
        if markers is None:
            lacking.append(f"{name} ({' and '.join(sets[-1])})")
        else:
            points.append(take.positions[:, [place[label] for label in markers]].mean(axis=1))
    if lacking:
        raise BadInput(
            f"The take has no markers for {', '.join(lacking[:5])}"
            f"{' …' if len(lacking) > 5 else ''} of OpenPose's points; give a take with the "
            "conventional names, or ask for three dimensions only."
        )
    return np.stack(points, axis=1)


def pinhole(points: FloatArray, azimuth: float = 30.0, distance: float = 4000.0) -> FloatArray:
    """Project points onto a picture in which all of them fit.

    Parameters
    ----------
    points
        (n_frames, 25, 3) mm, in the order of `POINTS`.
    azimuth
        Degrees by which the camera stands round the vertical, which is the mean direction from the
        heels to the nose.
    distance
        From the camera to the nearest point that the take could reach, mm.

    Returns
    -------
    (n_frames, 25, 2) px, x to the right and y downwards.
    """
    names = list(POINTS)
    heels = points[:, [names.index("RHeel"), names.index("LHeel")]].mean(axis=1)
    up = np.nanmean(points[:, names.index("Nose")] - heels, axis=0)
    up = up / np.linalg.norm(up)
    start = np.eye(3)[int(np.argmin(np.abs(up)))]
    first = np.cross(up, start)
    first /= np.linalg.norm(first)
    second = np.cross(up, first)
    angle = np.radians(azimuth)
    right = np.cos(angle) * first + np.sin(angle) * second
    low, high = np.nanmin(points, axis=(0, 1)), np.nanmax(points, axis=(0, 1))
    away = points - (low + high) / 2.0
    depth = away @ np.cross(right, up)
    depth += distance + float(np.nanmax(np.linalg.norm(away, axis=2)))
    flat = np.stack([away @ right, -(away @ up)], axis=2) / depth[..., None]
    half = np.array([WIDTH, HEIGHT]) / 2.0
    focal = 0.95 * float(np.min(half / np.nanmax(np.abs(flat), axis=(0, 1))))
    return np.asarray(flat * focal + half)


def openpose(
    take: Take, *, noise: float = NOISE_PX, lost: float = LOST, seed: int = 0
) -> tuple[Take, FloatArray]:
    """Give what a camera would see, with noise and drop-outs, and what it would see without them.

    Parameters
    ----------
    noise
        Standard deviation in px.
    lost
        Share of the samples that are not detected, in runs of geometric length.
    seed
        Of noise and drop-outs.

    Returns
    -------
    The take in px, NaN where a point was not detected, and (n_frames, 25, 2) px without errors.

    Raises
    ------
    BadInput
        As `body25`.
    """
    rng = np.random.default_rng(seed)
    truth = pinhole(body25(take))
    seen = truth + rng.normal(0.0, noise, truth.shape)
    again = 1.0 / max(1.0, LOST_S * take.rate)
    vanish = again * lost / (1.0 - lost)
    gone: BoolArray = np.asarray(rng.random(truth.shape[1]) < lost)
    for frame in range(len(seen)):
        seen[frame, gone] = np.nan
        gone = np.asarray(rng.random(len(gone)) < np.where(gone, 1.0 - again, vanish))
    return Take(seen, take.rate, tuple(POINTS), units="px"), truth
