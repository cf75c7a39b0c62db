"""Footsteps along a path, on a treadmill and on the spot.

Speed sets step length and cadence through a constant walk ratio of 6.5 mm per step a minute
(Sekiya and Nagasaki, *Gait Posture* 7 (1998) 225-227); the share of the cycle that a foot stands
falls with speed from 66 to 58 % (Murray et al., *Am. J. Phys. Med.* 45 (1966) 8-24).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from markermend.simulate.body import SIGN, Side
from markermend.simulate.script import Foothold, Step

WALK_RATIO = 6.5
"""mm per step a minute."""
WIDTH = 95.0
"""Between the lines of both feet in walking, in mm."""
STANCE_WIDTH = 190.0
"""The same in standing."""
TOE_OUT = np.radians(7.0)
COMMON_STRIDE = 1370.0
"""Stride in mm whose rolling of the foot is taken as 1."""


@dataclass(frozen=True)
class Cadence:
    """Timing of steps at some speed."""

    speed: float

    @property
    def per_minute(self) -> float:
        """Steps a minute."""
        return float(np.sqrt(60.0 * self.speed / WALK_RATIO))

    @property
    def step_s(self) -> float:
        """Time from one landing to the next."""
        return 60.0 / self.per_minute

    @property
    def step_length(self) -> float:
        """Way between two landings, in mm."""
        return self.speed * self.step_s

    @property
    def swing_s(self) -> float:
        """Time that a foot is in the air."""
        stance = np.clip(0.655 - 0.035 * (self.speed - 800.0) / 400.0, 0.58, 0.67)
        return float(2.0 * self.step_s * (1.0 - stance))


@dataclass(frozen=True)
class Place:
    """Where a person stands and faces."""

    x: float
    y: float
    yaw: float

    def foothold(self, side: Side, width: float) -> Foothold:
        """Where the foot of one side stands."""
        across = 0.5 * width * SIGN[side]
        return Foothold(
            self.x - across * float(np.sin(self.yaw)),
            self.y + across * float(np.cos(self.yaw)),
            self.yaw + SIGN[side] * TOE_OUT,
        )

    def both(self, width: float = STANCE_WIDTH) -> dict[Side, Foothold]:
        """Where both feet stand."""
        return {"L": self.foothold("L", width), "R": self.foothold("R", width)}

    def ahead(self, way: float, turn: float) -> "Place":
        """Go on by `way` mm along an arc that turns by `turn` radians."""
        chord = way if turn == 0.0 else 2.0 * way / turn * float(np.sin(turn / 2.0))
        towards = self.yaw + turn / 2.0
        return Place(
            self.x + chord * float(np.cos(towards)),
            self.y + chord * float(np.sin(towards)),
            self.yaw + turn,
        )


Leg = tuple[float, float]
"""A stretch of a path: its length in mm and by how much it turns to the left, in degrees."""


def along(start: Place, stretches: Sequence[Leg], way: float) -> Place:
    """Where one is after `way` mm of a path."""
    place = start
    for length, turn in stretches:
        part = min(way, length)
        place = place.ahead(part, float(np.radians(turn)) * part / length)
        way -= part
        if way <= 0.0:
            break
    return place


def alternating(first: Side) -> Iterator[Side]:
    """Left, right, left, right."""
    side = first
    while True:
        yield side
        side = "R" if side == "L" else "L"


def walk(
    start: Place,
    stretches: Sequence[Leg],
    speed: float,
    begin_s: float,
    first: Side,
    rng: np.random.Generator,
) -> tuple[tuple[Step, ...], Place]:
    """Walk along a path from standing to standing; give the steps and where it ends.

    The first step leaves at `begin_s`; `speed` in mm/s.
    """
    total = sum(length for length, _ in stretches)
    pace = Cadence(speed)
    # The first step is shorter, the last one only brings the feet together.
    n_steps = max(2, round(total / pace.step_length - 0.75) + 2)
    ways = np.concatenate([[0.75], np.ones(n_steps - 2), [0.0]])
    reached = np.concatenate([np.cumsum(ways[:-1]), [np.sum(ways)]]) / np.sum(ways) * total
    steps: list[Step] = []
    last: dict[Side, float] = {"L": 0.0, "R": 0.0}
    for k, (side, way) in enumerate(zip(alternating(first), reached, strict=False)):
        final = way >= total - 1e-6
        place = along(start, stretches, float(way))
        hold = place.foothold(side, STANCE_WIDTH * 0.85 if final else WIDTH)
        land = begin_s + pace.swing_s + k * pace.step_s + float(rng.normal(0.0, 0.006))
        stride = float(way) - last[side]
        last[side] = float(way)
        if not final:
            hold = _near(hold, rng)
        steps.append(Step(side, land - pace.swing_s, land, hold, min(stride / COMMON_STRIDE, 1.2)))
    return tuple(steps), along(start, stretches, total)


def steady(
    speed: float, begin_s: float, end_s: float, rng: np.random.Generator
) -> tuple[dict[Side, Foothold], tuple[Step, ...]]:
    """Walk straight along x without begin and end; at time 0 the person is at x = 0."""
    pace = Cadence(speed)
    roll = min(2.0 * pace.step_length / COMMON_STRIDE, 1.2)
    first_way = speed * begin_s
    start: dict[Side, Foothold] = {
        "L": Place(first_way, 0.0, 0.0).foothold("L", WIDTH),
        "R": Place(first_way - pace.step_length, 0.0, 0.0).foothold("R", WIDTH),
    }
    steps = []
    n_steps = int((end_s - begin_s) / pace.step_s)
    for k, side in zip(range(1, n_steps + 1), alternating("R"), strict=False):
        place = Place(first_way + k * pace.step_length, 0.0, 0.0)
        land = begin_s + k * pace.step_s + float(rng.normal(0.0, 0.006))
        hold = _near(place.foothold(side, WIDTH), rng)
        steps.append(Step(side, land - pace.swing_s, land, hold, roll))
    return start, tuple(steps)


def turn_on_spot(
    start: Place, degrees: float, n_steps: int, begin_s: float, step_s: float = 0.62
) -> tuple[tuple[Step, ...], Place]:
    """Turn by small steps, the foot of the inner side first; it ends with both feet together.

    Each pair of steps turns by an equal share: the inner foot opens, the outer one closes.
    """
    inner: Side = "L" if degrees > 0 else "R"
    n_pairs = max(1, n_steps // 2)
    steps = []
    for k, side in zip(range(2 * n_pairs), alternating(inner), strict=False):
        turned = np.radians(degrees) * (k // 2 + 1) / n_pairs
        place = Place(start.x, start.y, start.yaw + float(turned))
        lift = begin_s + k * step_s
        hold = place.foothold(side, STANCE_WIDTH)
        steps.append(Step(side, lift, lift + 0.72 * step_s, hold, 0.06))
    return tuple(steps), Place(start.x, start.y, start.yaw + float(np.radians(degrees)))


def _near(hold: Foothold, rng: np.random.Generator) -> Foothold:
    """Beside it: nobody steps exactly where he should."""
    dx, dy, turn = rng.normal(0.0, 1.0, 3) * (9.0, 7.0, 0.02)
    return Foothold(hold.x + float(dx), hold.y + float(dy), hold.yaw + float(turn))
