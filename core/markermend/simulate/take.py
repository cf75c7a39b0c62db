"""From a scenario to a take."""

from dataclasses import replace

import numpy as np

from markermend.errors import BadParameter, UnknownName
from markermend.model import FloatArray, Take
from markermend.simulate.body import REFERENCE_HEIGHT, Body
from markermend.simulate.frames import Movement
from markermend.simulate.markers import LABELS, Marker, markers_of
from markermend.simulate.posture import move
from markermend.simulate.scenarios import SCENARIOS
from markermend.simulate.script import Script
from markermend.simulate.tissue import measurement_noise, skin_motion

RATE = 100.0
"""Hz."""


def perform(
    scenario: str,
    seed: int = 0,
    *,
    duration_s: float | None = None,
    rate: float = RATE,
    height: float = REFERENCE_HEIGHT,
) -> Movement:
    """Give the movement of the bones, from which `simulate` takes the markers.

    Parameters
    ----------
    scenario
        A name in `SCENARIOS`.
    seed
        Of everything that is random.
    duration_s
        Length of the take, at most that of the scenario, which is the default.
    rate, height
        Frames a second, and the height of the person in mm.

    Raises
    ------
    UnknownName
        If there is no such scenario.
    BadParameter
        If a number is out of bounds.
    """
    if scenario not in SCENARIOS:
        raise UnknownName.among("scenario", scenario, SCENARIOS)
    for name, value, low, high in (("rate", rate, 50.0, 500.0), ("height", height, 1000.0, 2200.0)):
        if not low <= value <= high:
            raise BadParameter(f"{name} must be in {low:g} to {high:g}; got {value!r}.")
    script_rng, move_rng, _ = _generators(scenario, seed)
    script = SCENARIOS[scenario](script_rng)
    return move(_cut_to(script, duration_s), Body(height), rate, move_rng)


def simulate(
    scenario: str,
    seed: int = 0,
    *,
    duration_s: float | None = None,
    rate: float = RATE,
    height: float = REFERENCE_HEIGHT,
    measured: bool = True,
) -> Take:
    """Simulate a person with 53 markers.

    Parameters
    ----------
    scenario, seed, duration_s, rate, height
        As for `perform`.
    measured
        Whether skin moves on the bones and cameras err; if not, markers are glued to the bones.

    Returns
    -------
    A complete take without artefacts, z up, in mm.

    Raises
    ------
    UnknownName
        If there is no such scenario.
    BadParameter
        If a number is out of bounds.
    """
    movement = perform(scenario, seed, duration_s=duration_s, rate=rate, height=height)
    *_, rng = _generators(scenario, seed)
    markers = markers_of(movement.body, rng)
    positions = _positions(movement, markers, rng, measured)
    return Take(positions=positions, rate=rate, labels=LABELS)


def _generators(scenario: str, seed: int) -> tuple[np.random.Generator, ...]:
    """Independent generators for script, movement and measurement."""
    entropy = [seed, *scenario.encode()]
    children = np.random.SeedSequence(entropy).spawn(3)
    return tuple(np.random.default_rng(child) for child in children)


def _cut_to(script: Script, duration_s: float | None) -> Script:
    if duration_s is None:
        return script
    if not 1.0 <= duration_s <= script.duration_s:
        raise BadParameter(
            f"duration_s must be in 1 to {script.duration_s:g} for this scenario; "
            f"got {duration_s!r}."
        )
    return replace(script, duration_s=duration_s)


def _positions(
    movement: Movement, markers: tuple[Marker, ...], rng: np.random.Generator, measured: bool
) -> FloatArray:
    n_frames = len(movement.belt)
    skin = skin_motion(movement, markers, rng)
    if not measured:
        skin[:] = 0.0
    positions = np.empty((n_frames, len(markers), 3))
    for k, marker in enumerate(markers):
        frames = movement.segments[marker.segment]
        place = marker.offset + skin[:, k]
        positions[:, k] = frames.origin + np.einsum("nij,nj->ni", frames.rotation, place)
    if measured:
        positions += measurement_noise(n_frames, len(markers), rng)
    return positions
