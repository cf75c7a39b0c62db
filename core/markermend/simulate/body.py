"""The body: segments, joint centres and proportions.

Every segment has a frame at its proximal joint: x forward, y to the left, z up while the person
stands upright with hanging arms. All lengths are in mm.

Sources: segment lengths as fractions of the height from Drillis and Contini (1966) as printed in
Winter, *Biomechanics and Motor Control of Human Movement*, 4th ed. (2009), figure 4.1; the hip
joint centre relative to the pelvis markers from Bell, Brand and Pedersen, *J. Biomech.* 23
(1990) 617-621.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from markermend.model import FloatArray

Side = Literal["L", "R"]
SIDES: tuple[Side, Side] = ("L", "R")
SIGN: dict[Side, float] = {"L": 1.0, "R": -1.0}

REFERENCE_HEIGHT = 1750.0

PARENT: dict[str, str] = {
    "thorax": "pelvis",
    "head": "thorax",
    **{
        side + child: (parent if parent in ("pelvis", "thorax") else side + parent)
        for side in SIDES
        for child, parent in (
            ("clavicle", "thorax"),
            ("upperarm", "clavicle"),
            ("forearm", "upperarm"),
            ("hand", "forearm"),
            ("thigh", "pelvis"),
            ("shank", "thigh"),
            ("foot", "shank"),
        )
    },
}
"""The segment that each segment hangs on; the pelvis is the root."""


@dataclass(frozen=True)
class Body:
    """A person of some height, in published proportions."""

    height: float = REFERENCE_HEIGHT

    @property
    def scale(self) -> float:
        """Size relative to the person of 1750 mm for whom all offsets are written."""
        return self.height / REFERENCE_HEIGHT

    def scaled(self, *offset: float) -> FloatArray:
        """Give an offset that is written for a height of 1750 mm."""
        return np.array(offset) * self.scale

    @property
    def thigh(self) -> float:
        """Hip to knee."""
        return 0.245 * self.height

    @property
    def shank(self) -> float:
        """Knee to ankle."""
        return 0.246 * self.height

    @property
    def ankle_height(self) -> float:
        """Sole to ankle."""
        return 0.039 * self.height

    @property
    def upperarm(self) -> float:
        """Shoulder to elbow."""
        return 0.186 * self.height

    @property
    def forearm(self) -> float:
        """Elbow to wrist."""
        return 0.146 * self.height

    @property
    def sitting_hip_height(self) -> float:
        """Height of the hips on a chair: knees at about a right angle."""
        return 0.281 * self.height

    def hip(self, side: Side) -> FloatArray:
        """Hip joint centre in the pelvis frame, whose origin is midway between the hips."""
        return self.scaled(0.0, 87.0 * SIGN[side], 0.0)

    @property
    def lumbar(self) -> FloatArray:
        """Where the thorax turns on the pelvis, in the pelvis frame."""
        return self.scaled(-25.0, 0.0, 135.0)

    def sternoclavicular(self, side: Side) -> FloatArray:
        """Where the shoulder girdle turns on the thorax, in the thorax frame."""
        return self.scaled(40.0, 28.0 * SIGN[side], 352.0)

    def shoulder(self, side: Side) -> FloatArray:
        """Shoulder joint centre, in the frame of the shoulder girdle."""
        return self.scaled(-30.0, 150.0 * SIGN[side], -2.0)

    @property
    def neck(self) -> FloatArray:
        """Where the head turns on the thorax, in the thorax frame."""
        return self.scaled(5.0, 0.0, 450.0)

    @property
    def heel(self) -> FloatArray:
        """Point of the sole under the heel, in the foot frame."""
        return np.array([-50.0 * self.scale, 0.0, -self.ankle_height])

    @property
    def ball(self) -> FloatArray:
        """Point of the sole under the heads of the metatarsals, in the foot frame."""
        return np.array([128.0 * self.scale, 0.0, -self.ankle_height])
