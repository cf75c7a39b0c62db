"""What several commands share."""

import argparse
import json
import sys
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

from tqdm import tqdm

from markermend import io
from markermend.errors import BadInput
from markermend.model import KINDS, Take


def take_argument(parser: argparse.ArgumentParser) -> None:
    """Add TAKE, and what a file may lack."""
    parser.add_argument("take", metavar="TAKE", type=Path, help="a recording, e.g. walk.c3d")
    lacking(parser)


def lacking(parser: argparse.ArgumentParser) -> None:
    """Add the options that supply what a file lacks."""
    parser.add_argument("--units", choices=("mm", "cm", "m"), help="unit, where the file has none")
    parser.add_argument("--rate", type=float, metavar="HZ", help="rate, where the file has none")
    parser.add_argument(
        "--ignore-residuals",
        action="store_true",
        help="take all samples of a C3D as seen, whatever their residuals say",
    )


def read(options: argparse.Namespace) -> Take:
    """Read the take of a command and print its warnings."""
    take = io.read(
        options.take,
        units=options.units,
        rate=options.rate,
        ignore_residuals=options.ignore_residuals,
    )
    warn(take.warnings)
    return take


def warn(sentences: Iterable[str]) -> None:
    """Print warnings, one line each, on stderr."""
    for sentence in sentences:
        print(f"warning: {' '.join(sentence.split())}", file=sys.stderr)


def kinds(text: str) -> tuple[str, ...]:
    """Read a list of kinds such as ``gap,peak``."""
    wanted = tuple(word.strip() for word in text.split(",") if word.strip())
    unknown = [word for word in wanted if word not in KINDS]
    if unknown or not wanted:
        raise BadInput(
            f"--kinds takes some of {', '.join(KINDS)} with commas between; got {text!r}."
        )
    return wanted


def print_json(record: Mapping[str, Any]) -> None:
    """Print strict JSON: no NaN, no infinity."""
    print(json.dumps(record, indent=1, allow_nan=False))


def progress(total: int, what: str) -> Callable[[int], None]:
    """Give a function that moves a progress bar on a terminal, and nothing elsewhere."""
    bar = tqdm(total=total, desc=what, disable=not sys.stderr.isatty(), leave=False)

    def move(done: int) -> None:
        bar.update(done - bar.n)
        if done >= total:
            bar.close()

    return move
