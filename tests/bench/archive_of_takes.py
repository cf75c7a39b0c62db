"""Make an archive for trying: short takes cut out of recordings, each with artefacts of its own."""

from collections.abc import Sequence
from functools import cache
from pathlib import Path

import numpy as np

import markermend as mm
from markermend.simulate import simulate

SECONDS = 5.0
RECORDINGS = (
    "cmu_85_12_dynamic.c3d",
    "hdm05_mm_01-02_clean.c3d",
    "walk_vicon_clean_rtosim.c3d",
    "raw_sprintbasket_gaps_metres.c3d",
    "vicon_box_gaps.c3d",
    "pair_tennis_serve_clean.c3d",
    "tennis_2players_metres.c3d",
)
SCENARIOS = ("walk", "sitting", "static")


@cache
def recordings(folder: Path | None) -> tuple[mm.Take, ...]:
    """Read what takes are cut out of, or simulate a person where there are no recordings."""
    if folder is None:
        return tuple(simulate(name, seed=seed) for seed, name in enumerate(SCENARIOS))
    return tuple(mm.read(folder / name) for name in RECORDINGS)


def make_archive(
    target: Path, n: int, folder: Path | None, seed: int = 7, seconds: float = SECONDS
) -> Sequence[Path]:
    """Write `n` takes of some seconds into folders of a hundred; no two are the same."""
    rng = np.random.default_rng(seed)
    sources = recordings(folder)
    made = []
    for i in range(n):
        path = target / f"session_{i // 100:02}" / f"take_{i:04}.c3d"
        path.parent.mkdir(parents=True, exist_ok=True)
        mm.write(short_take(sources[i % len(sources)], seconds, rng), path)
        made.append(path)
    return made


def short_take(source: mm.Take, seconds: float, rng: np.random.Generator) -> mm.Take:
    """Cut a few seconds out, anywhere, and add gaps and peaks."""
    n = min(source.n_frames, round(seconds * source.rate))
    start = int(rng.integers(0, source.n_frames - n + 1))
    labels = [source.labels[int(m)] for m in source.measured]
    positions = source.positions[start : start + n, source.measured].copy()
    for _ in range(int(rng.integers(1, 6))):
        marker, at = int(rng.integers(len(labels))), int(rng.integers(1, n - 30))
        if rng.random() < 0.5:
            positions[at : at + int(rng.integers(3, 29)), marker] = np.nan
        else:
            positions[at, marker] += rng.normal(0, 25, 3)
    return mm.Take(positions, source.rate, labels)
