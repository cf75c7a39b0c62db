"""``markermend simulate SCENARIO -o OUT``: a take of a simulated person."""

import argparse
from pathlib import Path

from markermend import io
from markermend.simulate import DEMO_SEED, SCENARIOS, make_demo, simulate


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument(
        "scenario",
        metavar="SCENARIO",
        choices=[*SCENARIOS, "demo"],
        help=f"one of {', '.join(SCENARIOS)}; or demo: with artefacts and their truth beside it",
    )
    parser.add_argument(
        "-o", "--out", metavar="OUT", type=Path, required=True, help="new file; for demo a folder"
    )
    parser.add_argument("--seed", type=int, default=DEMO_SEED, help="default: %(default)s")
    parser.add_argument(
        "--duration", type=float, metavar="S", help="seconds, at most the scenario's"
    )
    parser.add_argument("--force", action="store_true", help="replace OUT if it is there")


def run(options: argparse.Namespace) -> None:
    """Write the take."""
    if options.scenario == "demo":
        take_path, truth_path = make_demo(options.out, seed=options.seed)
        print(f"{take_path}, and its truth in {truth_path.name}")
        return
    take = simulate(options.scenario, options.seed, duration_s=options.duration)
    io.write(take, options.out, overwrite=options.force)
    print(f"{options.out}: {take.n_frames} frames, {take.n_markers} markers, {take.rate:g} Hz")
