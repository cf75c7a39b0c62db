"""What the default detector costs: CPU seconds of one core, and peak memory, each in a child.

``python -m tests.bench.detection [--frames A,B] [--json FILE]`` scans simulated takes of 53 markers
of 2,200, 22,000 and 200,000 frames with artefacts in them, and gives the seconds, how they grow
with the frames, and the largest memory that the process ever held, the take itself included. Python
and its libraries, once loaded, hold about 120 MB of it. The seconds of a take below 10,000 frames
are the median of five; on a busy machine they are half as much again, since caches are shared.
"""

import argparse
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

FRAMES = "2200,22000,200000"
CHILD = """
import json, resource, statistics, sys, time
import numpy as np
from markermend.detection import scan
from markermend.evaluate.contamination import contaminate
from markermend.model import Take
from markermend.simulate import simulate

n_frames, repeats = int(sys.argv[1]), int(sys.argv[2])
clean = simulate("static", 0)
take, _ = contaminate(clean, amplitude_mm=10.0, share=0.05, seed=0)
pieces = -(-n_frames // take.n_frames)
# Forwards and backwards, so that no frame jumps.
forth = take.positions
take = Take(
    np.concatenate([forth if i % 2 == 0 else forth[::-1] for i in range(pieces)])[:n_frames],
    take.rate, take.labels,
)
del clean, forth
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
seconds = []
for _ in range(repeats):
    start = time.process_time()
    found = scan(take, "likelihood")
    seconds.append(time.process_time() - start)
print(json.dumps({
    "frames": n_frames, "markers": take.positions.shape[1], "findings": len(found),
    "cpu_s": round(statistics.median(seconds), 2),
    "peak_mb": round(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024),
    "before_mb": round(before / 1024),
}))
"""


def measured(n_frames: int, repeats: int) -> dict[str, Any]:
    """Scan one take in a process of its own, on one thread."""
    env = os.environ | dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
    command = [sys.executable, "-c", CHILD, str(n_frames), str(repeats)]
    done = subprocess.run(command, env=env, capture_output=True, text=True, check=True)
    result: dict[str, Any] = json.loads(done.stdout)
    return result


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--frames", default=FRAMES)
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    rows: list[dict[str, Any]] = []
    for n_frames in map(int, given.frames.split(",")):
        row = measured(n_frames, 5 if n_frames < 10_000 else 1)
        row["ratio"] = round(row["cpu_s"] / rows[0]["cpu_s"], 2) if rows else 1.0
        rows.append(row)
        print(
            f"{row['frames']:>7,} frames x {row['markers']}: {row['cpu_s']:.2f} s of one core, "
            f"x {row['ratio']:.2f}; {row['peak_mb']} MB at most ({row['before_mb']} MB before)",
            flush=True,
        )
    if given.json:
        given.json.write_text(json.dumps({"version": 1, "rows": rows}, indent=2) + "\n")


if __name__ == "__main__":
    main()
