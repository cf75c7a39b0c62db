"""``markermend simulate SCENARIO -o OUT``: a take of a simulated person."""

import argparse
from pathlib import Path

from markermend import io
from markermend.errors import BadInput, CannotWrite
from markermend.simulate import DEMO_FILES, DEMO_SEED, SCENARIOS, make_demo, simulate
from markermend_app.cli.common import whole
from markermend_app.cli.terminal import say


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument(
        "scenario",
        metavar="SCENARIO",
        choices=tuple(SCENARIOS),
        help=f"one of {', '.join(SCENARIOS)}; demo comes with artefacts and their truth",
    )
    parser.add_argument(
        "-o", "--out", metavar="OUT", type=Path, required=True, help="new file; for demo a folder"
    )
    parser.add_argument(
        "--seed", type=whole(0, 2**32 - 1), default=DEMO_SEED, help="default: %(default)s"
    )
    parser.add_argument(
        "--duration", type=float, metavar="S", help="seconds, at most the scenario's"
    )
    parser.add_argument("--force", action="store_true", help="replace OUT if it is there")


def run(options: argparse.Namespace) -> None:
    """Write the take."""
    if options.scenario == "demo":
        _demonstration(options)
        return
    take = simulate(options.scenario, options.seed, duration_s=options.duration)
    io.write(take, options.out, overwrite=options.force)
    say(f"{options.out}: {take.n_frames} frames, {take.n_markers} markers, {take.rate:g} Hz")


def _demonstration(options: argparse.Namespace) -> None:
    if options.duration is not None:
        raise BadInput("The demonstration take has one length; leave out --duration.")
    there = [name for name in DEMO_FILES if (options.out / name).exists()]
    if there and not options.force:
        raise CannotWrite(f"{options.out / there[0]} exists; choose another folder or add --force.")
    take_path, truth_path = make_demo(options.out, seed=options.seed)
    say(f"{take_path}, and its truth in {truth_path.name}")
