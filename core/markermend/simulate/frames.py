"""Where the segments are: what a movement is made of."""

from dataclasses import dataclass

from markermend.model import FloatArray
from markermend.simulate.body import Body, Side
from markermend.simulate.curves import placed
from markermend.simulate.feet import FootMotion
from markermend.simulate.pelvis import Seating


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
class Drive:
    """What the whole body follows, (n,) each: radians but for `stride` and `share`."""

    heading: FloatArray
    stride: FloatArray
    share: FloatArray
    seated: Seating
