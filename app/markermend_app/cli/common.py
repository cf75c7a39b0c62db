"""What several commands share."""

import argparse
import math
import sys
from collections.abc import Callable, Iterable
from pathlib import Path

from tqdm import tqdm

from markermend import io
from markermend.errors import BadInput
from markermend.io.jsontext import json_text
from markermend.model import KINDS, Take
from markermend_app.cli.terminal import plain, say, sentence

__all__ = [
    "hertz",
    "json_text",
    "kinds",
    "lacking",
    "positive",
    "progress",
    "read",
    "take_argument",
    "warn",
    "whole",
]  # fmt: skip

_SHORT_S = 0.5
_LARGE_BYTES = 20_000_000  # about a second to read


def take_argument(parser: argparse.ArgumentParser) -> None:
    """Add TAKE, and what a file may lack."""
    parser.add_argument("take", metavar="TAKE", type=Path, help="a recording, e.g. walk.c3d")
    lacking(parser)


def lacking(parser: argparse.ArgumentParser) -> None:
    """Add the options that supply what a file lacks."""
    parser.add_argument("--units", choices=("mm", "cm", "m"), help="unit, where the file has none")
    parser.add_argument("--rate", type=hertz, metavar="HZ", help="rate, where the file has none")
    parser.add_argument(
        "--ignore-residuals",
        action="store_true",
        help="take all samples of a C3D as seen, whatever their residuals say",
    )


def hertz(text: str) -> float:
    """Read a rate."""
    return positive("Hz")(text)


def positive(unit: str) -> Callable[[str], float]:
    """Give a function that reads a positive number."""

    def read_positive(text: str) -> float:
        try:
            number = float(text)
        except ValueError:
            number = math.nan
        if not (math.isfinite(number) and number > 0):
            raise argparse.ArgumentTypeError(f"must be a positive number of {unit}; got {text!r}")
        return number

    return read_positive


def whole(least: int, most: int) -> Callable[[str], int]:
    """Give a function that reads a whole number between two others."""

    def read_whole(text: str) -> int:
        try:
            number = int(text)
        except ValueError:
            number = least - 1
        if not least <= number <= most:
            raise argparse.ArgumentTypeError(
                f"must be a whole number from {least} to {most}; got {text!r}"
            )
        return number

    return read_whole


def read(path: Path, options: argparse.Namespace) -> Take:
    """Read a take with the options of `lacking` and print its warnings.

    A terminal says what is being read while a large file is: how far, no reader tells.
    """
    quick = not path.is_file() or path.stat().st_size < _LARGE_BYTES
    silent = quick or not sys.stderr.isatty()
    with tqdm(desc=f"Reading {plain(path.name)}", bar_format="{desc}", disable=silent, leave=False):
        take = io.read(
            path,
            units=options.units,
            rate=options.rate,
            ignore_residuals=options.ignore_residuals,
        )
    warn(take.warnings)
    return take


def warn(sentences: Iterable[str]) -> None:
    """Print warnings, one line each, on stderr."""
    for one in sentences:
        say(f"warning: {sentence(one)}", file=sys.stderr)


def kinds(text: str) -> tuple[str, ...]:
    """Read a list of kinds such as ``gap,peak``."""
    wanted = tuple(word.strip() for word in text.split(",") if word.strip())
    unknown = [word for word in wanted if word not in KINDS]
    if unknown or not wanted:
        raise BadInput(
            f"--kinds takes some of {', '.join(KINDS)} with commas between; got {text!r}."
        )
    return wanted


def progress(total: int, what: str) -> Callable[[int], None]:
    """Give a function that moves a progress bar on a terminal, and nothing elsewhere.

    What is over at once shows none.
    """
    bar = tqdm(total=total, desc=what, disable=not sys.stderr.isatty(), leave=False, delay=_SHORT_S)

    def move(done: int) -> None:
        bar.update(done - bar.n)
        if done >= total:
            bar.close()

    return move
