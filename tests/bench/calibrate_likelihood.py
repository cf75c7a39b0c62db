"""Refit the curves of markermend.detection.likelihood.calibration on contaminated takes.

    python tests/bench/calibrate_likelihood.py TAKE.npz... [--seeds N] [--jobs J] [--check]

TAKE is anything that ``markermend.read`` reads, or a ``.npy`` of positions in mm at 100 Hz. A
finding is real where an artefact of its kind was put in at its place; one that the detector also
finds at the same place in the take as given is left out, since it may be real too. Prints the
curves, or with ``--check`` the calibration error of the stored ones, and in both cases the
reliability of all kinds together in ten bins.
"""

import argparse
from collections import defaultdict
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from itertools import product
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

import markermend
from markermend.detection import detect, scan
from markermend.detection.likelihood.calibration import probability
from markermend.evaluate.contamination import contaminate
from markermend.model import Finding, Take

AMPLITUDES, SHARES = (5.0, 10.0), (0.05, 0.1, 0.2)
IOU = 0.3


def open_take(path: Path) -> Take:
    if path.suffix == ".npy":
        positions = np.load(path)
        return Take(positions, 100.0, [f"m{i}" for i in range(positions.shape[1])])
    return markermend.read(path)


@cache
def found_as_given(path: Path) -> tuple[Finding, ...]:
    return detect(open_take(path), "likelihood")


def one(job: tuple[Path, float, float, int]) -> list[tuple[str, float, bool]]:
    path, amplitude, share, seed = job
    take = open_take(path)
    before = found_as_given(path)
    distorted, truths = contaminate(take, amplitude_mm=amplitude, share=share, seed=seed)
    rows = []
    for f in scan(distorted, "likelihood"):
        if f.kind == "gap":
            continue
        real = any(
            t.kind == f.kind and t.marker == f.marker and t.span.iou(f.span) >= IOU for t in truths
        )
        known = any(
            b.kind == f.kind and b.marker == f.marker and b.span.iou(f.span) > 0.5 for b in before
        )
        if real or not known:
            rows.append((f.kind, f.strength, real))
    return rows


def fitted(strengths: np.ndarray, real: np.ndarray) -> tuple[float, float]:
    """Logistic curve on the logarithm of the strength, weakly pulled to a slope of 3."""
    x, sign = np.log(strengths), 2.0 * real - 1.0

    def loss(w: np.ndarray) -> float:
        return float(np.logaddexp(0, -sign * (w[0] + w[1] * x)).sum() + 0.05 * (w[1] - 3.0) ** 2)

    a, b = minimize(loss, np.array([0.0, 3.0]), method="BFGS").x
    return float(a), float(b)


def error(predicted: np.ndarray, real: np.ndarray, bins: int = 10) -> float:
    """Expected calibration error over equally wide bins."""
    place = np.minimum((predicted * bins).astype(int), bins - 1)
    return float(
        sum(
            abs(predicted[place == i].mean() - real[place == i].mean()) * (place == i).mean()
            for i in np.unique(place)
        )
    )


def reliability(predicted: np.ndarray, real: np.ndarray, bins: int = 10) -> list[str]:
    """Rows of a table: bin, number of findings, mean score, share that was real."""
    place = np.minimum((predicted * bins).astype(int), bins - 1)
    return [
        f"| {i / bins:.1f} to {(i + 1) / bins:.1f} | {(place == i).sum()} | "
        f"{predicted[place == i].mean():.2f} | {real[place == i].mean():.2f} |"
        for i in np.unique(place)
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("takes", nargs="+", type=Path)
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--check", action="store_true")
    given = parser.parse_args()
    jobs = list(product(given.takes, AMPLITUDES, SHARES, range(given.seeds)))
    with ProcessPoolExecutor(given.jobs) as pool:
        rows = [row for part in pool.map(one, jobs) for row in part]
    per_kind: dict[str, list[tuple[float, bool]]] = defaultdict(list)
    for kind, strength, real in rows:
        per_kind[kind].append((strength, real))
    every_p, every_real = [], []
    for kind, pairs in sorted(per_kind.items()):
        strengths = np.array([s for s, _ in pairs])
        real = np.array([r for _, r in pairs], float)
        a, b = fitted(strengths, real)
        if given.check:
            p = np.array([probability(kind, s) for s in strengths])
        else:
            p = 1.0 / (1.0 + np.exp(-(a + b * np.log(strengths))))
        every_p.append(p)
        every_real.append(real)
        print(
            f'"{kind}": ({a:.2f}, {b:.2f}),  # {len(real)} findings, {real.mean():.0%} real, '
            f"calibration error {error(p, real):.3f}"
        )
    p, real = np.concatenate(every_p), np.concatenate(every_real)
    print(f"all: calibration error {error(p, real):.3f}")
    print("| score | findings | mean score | share real |\n|---|---|---|---|")
    print("\n".join(reliability(p, real)))


if __name__ == "__main__":
    main()
