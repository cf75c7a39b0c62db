"""What a person is told to do: footsteps, seats, looks and gestures, without any posture yet."""

from dataclasses import dataclass

from markermend.simulate.body import Side
from markermend.simulate.curves import Keys


@dataclass(frozen=True)
class Foothold:
    """Where a foot stands: its ankle on the floor in mm, and its heading in radians."""

    x: float
    y: float
    yaw: float


@dataclass(frozen=True)
class Step:
    """One foot leaves the floor, moves and lands.

    Attributes
    ----------
    side
        The foot.
    lift_s, land_s
        When the toe leaves the floor, and when the heel meets it again.
    to
        Where it lands.
    roll
        How much the foot rolls: 0 for stepping on the spot, 1 for walking at a common speed.
    """

    side: Side
    lift_s: float
    land_s: float
    to: Foothold
    roll: float


@dataclass(frozen=True)
class Seat:
    """Sitting down and standing up again: when each begins, and how long it takes."""

    sit_s: float
    stand_s: float
    takes_s: float = 2.1


@dataclass(frozen=True)
class Script:
    """One recording.

    Attributes
    ----------
    duration_s
        Length of the take.
    start
        Where both feet stand at first.
    steps, seats
        In order of time.
    look
        Keys of how far the head is turned to the left, in degrees.
    nod
        Keys of how far the head is bent down, in degrees.
    load_left
        Keys of the share of the weight on the left foot while both feet stand.
    wave
        Keys from 0 to 1: the right hand is raised in front of the chest.
    belt
        Speed of a treadmill towards -x, in mm/s; footholds are then those on the belt.
    preroll_s
        What happens before the take begins, so that it may begin in full motion.
    """

    duration_s: float
    start: dict[Side, Foothold]
    steps: tuple[Step, ...] = ()
    seats: tuple[Seat, ...] = ()
    look: Keys = ((0.0, 0.0),)
    nod: Keys = ((0.0, 0.0),)
    load_left: Keys = ((0.0, 0.5),)
    wave: Keys = ((0.0, 0.0),)
    belt: float = 0.0
    preroll_s: float = 0.0
