"""``markermend join A B --gap SECONDS -o OUT``: two takes in one, the time between filled."""

import argparse
from pathlib import Path

import numpy as np

from markermend import io
from markermend.repairing.joining import joined
from markermend_app.cli.common import lacking, read, warn
from markermend_app.cli.terminal import say


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("first", metavar="A", type=Path, help="the take that comes first")
    parser.add_argument("second", metavar="B", type=Path, help="the take that goes on from it")
    parser.add_argument(
        "--gap", type=float, required=True, metavar="SECONDS", help="time between the two"
    )
    parser.add_argument("--method", default="auto", metavar="NAME", help="default: auto")
    parser.add_argument("-o", "--out", metavar="OUT", type=Path, required=True, help="new file")
    parser.add_argument("--force", action="store_true", help="replace OUT if it is there")
    lacking(parser)


def run(options: argparse.Namespace) -> None:
    """Join, fill and write."""
    first, second = read(options.first, options), read(options.second, options)
    whole, repairs, refusals = joined(first, second, options.gap, options.method)
    io.write(whole, options.out, overwrite=options.force)
    lost = (
        f"{options.out} is written anew: it holds the {whole.n_markers} measured markers that both "
        "takes have, and nothing else of either file, such as events, analog data or models"
    )
    open_ = [f"{r.wish.marker} stays open between the takes: {r.reason}" for r in refusals]
    warn([lost, *open_])
    expected = [done.expected_mm for done in repairs if done.expected_mm is not None]
    said = f", {np.mean(expected):.1f} {whole.units} expected error" if expected else ""
    say(
        f"{options.out}: {whole.n_frames} frames, {len(repairs)} of {whole.n_markers} markers "
        f"filled over {options.gap:g} s{said}"
    )
