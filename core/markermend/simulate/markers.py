"""The 53 markers: where each is glued.

The set is a common full-body one: head, trunk, arms and pelvis of the usual clinical set, legs with
the medial knee and ankle markers and one more marker on the front of each thigh and shank.
"""

from typing import NamedTuple

import numpy as np

from markermend.model import FloatArray
from markermend.simulate.body import SIDES, SIGN, Body

_Place = tuple[str, str, tuple[float, float, float]]

# label, segment, offset in mm in the segment's frame for a height of 1750 mm.
_MIDDLE: tuple[_Place, ...] = (
    ("LFHD", "head", (88, 66, 118)),
    ("RFHD", "head", (88, -66, 120)),
    ("LBHD", "head", (-82, 62, 132)),
    ("RBHD", "head", (-82, -64, 130)),
    ("C7", "thorax", (-72, 0, 402)),
    ("T10", "thorax", (-98, 2, 172)),
    ("CLAV", "thorax", (82, 0, 322)),
    ("STRN", "thorax", (128, 0, 168)),
    ("RBAK", "thorax", (-92, -92, 262)),
    ("LASI", "pelvis", (78, 121, 74)),
    ("RASI", "pelvis", (78, -121, 74)),
    ("LPSI", "pelvis", (-92, 46, 88)),
    ("RPSI", "pelvis", (-92, -46, 88)),
)

# The same for the left side; the right is its mirror image but for the three that labs stagger so
# that software can tell left from right.
_PAIRED: tuple[_Place, ...] = (
    ("SHO", "clavicle", (-35, 144, 50)),
    ("UPA", "upperarm", (8, 56, -150)),
    ("ELB", "upperarm", (-6, 44, -322)),
    ("ELM", "upperarm", (-6, -42, -320)),
    ("FRM", "forearm", (6, 44, -118)),
    ("WRA", "forearm", (38, 4, -248)),
    ("WRB", "forearm", (-36, 6, -246)),
    ("FIN", "hand", (6, 24, -86)),
    ("THI", "thigh", (6, 84, -212)),
    ("THAP", "thigh", (86, 8, -178)),
    ("KNE", "thigh", (0, 58, -427)),
    ("KNM", "thigh", (4, -54, -425)),
    ("TIB", "shank", (2, 60, -198)),
    ("TIAP", "shank", (52, 6, -132)),
    ("ANK", "shank", (-8, 44, -428)),
    ("MED", "shank", (2, -42, -418)),
    ("HEE", "foot", (-66, 0, -30)),
    ("TOE", "foot", (124, 6, -12)),
    ("MT1", "foot", (122, -44, -28)),
    ("MT5", "foot", (100, 52, -42)),
)
_STAGGER = {"RUPA": (0.0, 0.0, -34.0), "RTHI": (0.0, 0.0, 52.0), "RTIB": (0.0, 0.0, 46.0)}


class Marker(NamedTuple):
    """A marker: its label, the segment that carries it and its place there, (3,) in mm."""

    label: str
    segment: str
    offset: FloatArray


def _glued(body: Body) -> tuple[Marker, ...]:
    found = [Marker(label, segment, body.scaled(*at)) for label, segment, at in _MIDDLE]
    for side in SIDES:
        for name, segment, at in _PAIRED:
            mirrored = np.array([1.0, SIGN[side], 1.0]) * at
            offset = body.scaled(*(mirrored + _STAGGER.get(side + name, (0.0, 0.0, 0.0))))
            found.append(Marker(side + name, side + segment, offset))
    return tuple(found)


def markers_of(body: Body, rng: np.random.Generator | None = None) -> tuple[Marker, ...]:
    """Give the markers of a body, in the order of `LABELS`.

    Parameters
    ----------
    body
        Whose markers.
    rng
        Where given, every marker is glued up to some mm beside its nominal place.
    """
    found = _glued(body)
    if rng is None:
        return found
    shifts = np.clip(rng.normal(0.0, 3.0, (len(found), 3)), -7.0, 7.0)
    return tuple(
        Marker(marker.label, marker.segment, marker.offset + shift)
        for marker, shift in zip(found, shifts, strict=True)
    )


LABELS: tuple[str, ...] = tuple(marker.label for marker in _glued(Body()))
"""Labels of the 53 markers, in file order."""
