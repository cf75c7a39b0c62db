"""The demonstration take: a person who walks, sits and turns, with artefacts of every kind."""

import json
from pathlib import Path
from typing import NamedTuple

import numpy as np

from markermend.errors import CannotWrite
from markermend.io import write
from markermend.io.disk import write_whole
from markermend.model import AXES, Kind, Span, Take
from markermend.simulate.artefacts import distort
from markermend.simulate.take import simulate
from markermend.truth import Truth

DEMO_SEED = 0
"""The seed of the take that is shipped."""
DEMO_FILES = ("demo.c3d", "demo.truth.json")
"""What `make_demo` writes."""
PLANNED_S = 29.0
"""Length of the take that the plan below is made for."""
JITTER = 6
"""Frames by which another seed moves an artefact at most."""


class _Planned(NamedTuple):
    marker: str
    at_s: float
    frames: int
    kind: Kind
    amplitude: float | None = None
    axes: str = "xyz"
    partner: str | None = None


# Gaps are where cameras lose markers: hips while the trunk bends over them, wrists that pass the
# thighs, the inner sides of the knees, the back against a chair, a heel behind its neighbour.
_PLAN: tuple[_Planned, ...] = (
    _Planned("LFIN", 0.0, 18, "gap"),
    _Planned("LELM", 1.9, 6, "gap"),
    _Planned("RKNM", 2.2, 9, "gap"),
    _Planned("LWRB", 3.4, 22, "gap"),
    _Planned("RWRA", 5.1, 14, "gap"),
    _Planned("RHEE", 8.9, 48, "gap"),
    _Planned("LASI", 11.7, 100, "gap"),
    _Planned("RASI", 11.9, 125, "gap"),
    _Planned("T10", 14.2, 150, "gap"),
    _Planned("LASI", 17.2, 85, "gap"),
    _Planned("STRN", 17.6, 60, "gap"),
    _Planned("LKNM", 20.1, 35, "gap"),
    _Planned("RMT5", 28.7, 30, "gap"),
    _Planned("RTIB", 2.9, 2, "peak", 18.0, "y"),
    _Planned("RANK", 4.3, 1, "peak", 40.0),
    _Planned("LSHO", 7.6, 1, "peak", 12.0, "xz"),
    _Planned("LFHD", 14.4, 1, "peak", 25.0, "z"),
    _Planned("LTOE", 15.8, 2, "peak", 14.0, "y"),
    _Planned("LPSI", 22.5, 1, "peak", 9.0, "x"),
    _Planned("RTHI", 5.3, 45, "noise", 6.0),
    _Planned("LUPA", 15.0, 70, "noise", 3.5),
    _Planned("LWRA", 18.2, 40, "noise", 8.0, "xy"),
    _Planned("LTIB", 7.9, 60, "step", 20.0, "xy"),
    _Planned("RBHD", 13.5, 40, "step", 15.0, "z"),
    _Planned("RTOE", 19.7, 50, "step", partner="RMT1"),
    _Planned("RUPA", 3.2, 71, "slow", 20.0, "xy"),
    _Planned("C7", 15.4, 81, "slow", 12.0, "z"),
    _Planned("LTHI", 22.8, 61, "slow", 10.0, "y"),
    _Planned("LBHD", 25.4, 91, "slow", 14.0, "x"),
    _Planned("LBHD", 25.9, 1, "peak", 22.0, "x"),
)


def demonstration(
    seed: int = DEMO_SEED, scenario: str = "demo"
) -> tuple[Take, Take, tuple[Truth, ...]]:
    """Simulate the demonstration take, or another scenario with the same artefacts.

    Parameters
    ----------
    seed
        Of the movement, the measurement and the artefacts.
    scenario
        A name in `SCENARIOS`; in a shorter one the artefacts are nearer to one another.

    Returns
    -------
    take
        With gaps and artefacts of every kind, two swapped labels and a peak on a slow change.
    clean
        The same without.
    truth
        What was put in, ordered by time.

    Raises
    ------
    UnknownName
        If there is no such scenario.
    """
    clean = simulate(scenario, seed)
    rng = np.random.default_rng(np.random.SeedSequence([seed, 1]))
    jitter = 0 if seed == DEMO_SEED else JITTER
    wanted = [_placed(planned, clean, jitter, rng) for planned in _PLAN]
    take, truth = distort(clean, wanted, rng)
    return take, clean, truth


def _placed(planned: _Planned, take: Take, jitter: int, rng: np.random.Generator) -> Truth:
    last = take.n_frames - planned.frames
    start = min(round(planned.at_s * take.n_frames / PLANNED_S), last)
    if 0 < start < last:
        start += int(rng.integers(-jitter, jitter + 1))
    return Truth(
        planned.marker,
        Span(start, start + planned.frames),
        planned.kind,
        planned.amplitude,
        AXES if planned.kind == "gap" else tuple(planned.axes),
        planned.partner,
    )


def make_demo(folder: str | Path, seed: int = DEMO_SEED) -> tuple[Path, Path]:
    """Write the demonstration take, ``demo.c3d``, and its truth, ``demo.truth.json``.

    Files of these names are replaced. The same seed gives the same bytes.

    Parameters
    ----------
    folder
        Where to; it is made if it is missing.
    seed
        As for `demonstration`.

    Returns
    -------
    Paths of the take and of the truth.

    Raises
    ------
    CannotWrite
        If the disk refuses.
    """
    take, _, truth = demonstration(seed)
    folder = Path(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise CannotWrite(
            f"The folder {folder} cannot be made: {error.strerror or error}; choose another."
        ) from None
    target, record = (folder / name for name in DEMO_FILES)
    write(take, target, overwrite=True)
    text = json.dumps(truth_record(take, truth, seed), indent=1)
    write_whole(record, f"{text}\n".encode("ascii"), overwrite=True)
    return target, record


def truth_record(take: Take, truth: tuple[Truth, ...], seed: int) -> dict[str, object]:
    """Give the truth as plain values: frames 0-based, stop exclusive, mm and Hz."""
    return {
        "version": 1,
        "take": "demo.c3d",
        "seed": seed,
        "rate": take.rate,
        "n_frames": take.n_frames,
        "artefacts": [one.to_json() for one in truth],
    }


def read_truth(path: str | Path) -> tuple[Truth, ...]:
    """Read the artefacts of a ``demo.truth.json``."""
    record = json.loads(Path(path).read_text(encoding="utf-8"))
    return tuple(Truth.from_json(one) for one in record["artefacts"])
