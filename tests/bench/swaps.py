"""Exchange two markers in takes, and count what the whole detector makes of it.

``python -m tests.bench.swaps TAKE... [--exchanges N] [--json FILE]`` makes N exchanges in each
take, one at a time: two markers at least 30 mm apart throughout, drawn at random, for 0.3 to 1.5 s.
It counts those that are found as a step with the right partner on both markers (span with IoU of at
least 0.5), and partners that are named where none were exchanged, also in the take as it is.
"""

import argparse
import json
from pathlib import Path

import numpy as np

import markermend as mm
from markermend.detection import detect
from markermend.model import Finding, Span, Take

APART_MM = 30.0
LENGTHS_S = (0.3, 1.5)


def exchanged(take: Take, rng: np.random.Generator) -> tuple[Take, str, str, Span]:
    """Exchange two markers that are seen, and at least 30 mm apart, throughout a random span."""
    while True:  # the takes are larger than what is refused
        length = round(rng.uniform(*LENGTHS_S) * take.rate)
        start = int(rng.integers(5, take.n_frames - length - 5))
        span = Span(start, start + length)
        a, b = (int(m) for m in rng.choice(take.measured, 2, replace=False))
        between = take.positions[span.frames, a] - take.positions[span.frames, b]
        apart = np.linalg.norm(between, axis=1)
        if take.seen[span.frames][:, [a, b]].all() and apart.min() >= APART_MM:
            positions = take.positions.copy()
            positions[span.frames, [a, b]] = positions[span.frames, [b, a]]
            return take.with_positions(positions), take.labels[a], take.labels[b], span


def named(take: Take) -> list[Finding]:
    """Findings of a partner."""
    return [f for f in detect(take, kinds=("step",)) if f.partner]


def counted(take: Take, exchanges: int, seed: int) -> dict[str, int]:
    """Count what was found right, and what was invented."""
    rng = np.random.default_rng(seed)
    right = invented = 0
    for _ in range(exchanges):
        dirty, a, b, span = exchanged(take, rng)
        found = named(dirty)
        good = [
            f
            for f in found
            if (f.marker, f.partner) in ((a, b), (b, a)) and f.span.iou(span) >= 0.5
        ]
        right += {f.marker for f in good} == {a, b}
        invented += len(found) - len(good)
    return {
        "exchanges": exchanges,
        "right": right,
        "invented": invented,
        "in_the_take_as_it_is": len(named(take)),
    }


def main() -> None:
    """Count and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("takes", nargs="+", type=Path)
    parser.add_argument("--exchanges", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    rows = {}
    for path in given.takes:
        row = rows[path.name] = counted(mm.read(path), given.exchanges, given.seed)
        print(
            f"{path.name}: {row['right']} of {row['exchanges']} with the right partner, "
            f"{row['invented']} invented, {row['in_the_take_as_it_is']} in the take as it is",
            flush=True,
        )
    right, total = (sum(row[key] for row in rows.values()) for key in ("right", "exchanges"))
    print(f"all: {right} of {total} ({right / total:.0%})")
    if given.json:
        given.json.write_text(json.dumps({"version": 1, "takes": rows}, indent=2) + "\n")


if __name__ == "__main__":
    main()
