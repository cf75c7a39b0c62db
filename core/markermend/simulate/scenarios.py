"""The scenarios that can be simulated; each gives a script for a random generator.

`static` and `sitting` are those of table 1 of Skurowski and Pawlyta (2022): an actor stands, looks
around and shifts from one foot to another; and one who stands, sits on a chair, stands up again,
three times.
"""

from collections.abc import Callable
from functools import partial

import numpy as np

from markermend.simulate.script import Script, Seat, Step
from markermend.simulate.walking import Place, steady, turn_on_spot, walk


def static(rng: np.random.Generator) -> Script:
    """Stand in the middle, look around and shift the weight from one foot to the other; 22 s."""
    duration, look, nod, load = 22.0, [(0.0, 0.0)], [(0.0, 0.0)], [(0.0, 0.5)]
    at = 1.0
    for towards in (38.0, -8.0, -42.0, -20.0, 25.0, 0.0):
        look += [(at, look[-1][1]), (at + 1.0, towards + float(rng.normal(0, 4)))]
        nod += [(at, nod[-1][1]), (at + 1.0, float(rng.normal(2, 6)))]
        at += 1.9 + float(rng.uniform(0.6, 1.6))
    at = 1.6
    for share in (0.80, 0.22, 0.74, 0.30, 0.5):
        load += [(at, load[-1][1]), (at + 1.5, share + float(rng.normal(0, 0.04)))]
        at += 3.5 + float(rng.uniform(0.0, 0.9))
    return Script(
        duration,
        Place(0.0, 0.0, 0.0).both(),
        look=tuple(look),
        nod=tuple(nod),
        load_left=tuple(load),
    )


def sitting(rng: np.random.Generator) -> Script:
    """Stand, sit on a chair for some seconds and stand again, three times; 29 s."""
    seats, look, at = [], [(0.0, 0.0)], 1.8
    for towards in (24.0, -28.0, 12.0):
        stays = float(rng.uniform(2.2, 2.9))
        takes = float(rng.uniform(1.9, 2.3))
        seats.append(Seat(at, at + takes + stays, takes))
        look += [(at + takes, 0.0), (at + takes + 0.9, towards)]
        look += [(at + takes + stays - 1.1, towards), (at + takes + stays - 0.2, 0.0)]
        at += 2.0 * takes + stays + float(rng.uniform(1.5, 2.0))
    return Script(29.0, Place(0.0, 0.0, 0.0).both(), seats=tuple(seats), look=tuple(look))


def walking(rng: np.random.Generator) -> Script:
    """Walk up and down the room in a long loop, from standing to standing; 20 s."""
    start = Place(-1900.0, -900.0, 0.0)
    stretches = (
        (3400.0, 0.0),
        (2830.0, 180.0),
        (3400.0, 0.0),
        (2830.0, 180.0),
        (3400.0, 0.0),
        (2830.0, 180.0),
        (700.0, 0.0),
    )
    steps, _ = walk(start, stretches, 1150.0, 1.2, "R", rng)
    look = ((0.0, 0.0), (13.0, 0.0), (13.9, -16.0), (14.6, -16.0), (15.6, 0.0))
    return Script(20.0, start.both(), steps, look=look)


def treadmill(rng: np.random.Generator, speed: float) -> Script:
    """Walk on a belt of `speed` mm/s; 20 s."""
    duration, preroll = 20.0, 5.0
    start, steps = steady(speed, -preroll, duration + 3.0, rng)
    return Script(duration, start, steps, belt=speed, preroll_s=preroll - 1.0)


def demo(rng: np.random.Generator) -> Script:
    """Walk, turn before a chair, sit and look around, stand up, walk off, turn and wave; 29 s."""
    start = Place(-1700.0, -650.0, 0.0)
    away = ((2300.0, 0.0), (2200.0, 170.0), (1300.0, 0.0))
    steps, chair = walk(start, away, 1100.0, 0.9, "R", rng)
    steps, place = _then(steps, turn_on_spot(chair, 180.0, 8, _over(steps) + 0.25, 0.52))
    sit = _over(steps) + 0.2
    seat = Seat(sit, sit + 5.6, 2.1)
    up = seat.stand_s + seat.takes_s + 0.25
    off = ((900.0, 0.0), (900.0, -50.0))
    steps, place = _then(steps, walk(place, off, 1000.0, up, "L", rng))
    steps, place = _then(steps, turn_on_spot(place, -90.0, 4, _over(steps) + 0.3, 0.58))
    end = _over(steps)
    look = (
        *((0.0, 0.0), (sit + 2.1, 0.0), (sit + 2.9, 36.0), (sit + 3.5, 36.0)),
        *((sit + 4.3, -30.0), (sit + 4.8, -30.0), (sit + 5.5, 0.0)),
        *((end + 0.1, 0.0), (end + 0.8, 18.0), (end + 2.2, 18.0), (end + 2.9, 0.0)),
    )
    nod = ((0.0, 0.0), (sit + 3.4, 0.0), (sit + 4.1, 9.0), (sit + 5.2, 0.0))
    wave = ((0.0, 0.0), (end + 0.1, 0.0), (end + 0.9, 1.0), (end + 1.9, 1.0), (end + 2.8, 0.0))
    load = ((0.0, 0.5), (end + 2.4, 0.5), (end + 3.4, 0.7))
    return Script(29.0, start.both(), steps, (seat,), look=look, nod=nod, load_left=load, wave=wave)


def _over(steps: tuple[Step, ...]) -> float:
    return max(step.land_s for step in steps)


def _then(
    steps: tuple[Step, ...], more: tuple[tuple[Step, ...], Place]
) -> tuple[tuple[Step, ...], Place]:
    return steps + more[0], more[1]


SCENARIOS: dict[str, Callable[[np.random.Generator], Script]] = {
    "static": static,
    "sitting": sitting,
    "walk": walking,
    "treadmill-slow": partial(treadmill, speed=800.0),
    "treadmill": partial(treadmill, speed=1200.0),
    "treadmill-fast": partial(treadmill, speed=1600.0),
    "demo": demo,
}
"""Scenario name to the function that writes its script."""
