"""Options, progress, tables and files of the experiments."""

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from markermend.errors import CannotWrite
from markermend_app.cli.common import json_text, progress
from markermend_app.cli.terminal import say


def json_argument(parser: argparse.ArgumentParser) -> None:
    """Add ``--json``."""
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all figures as JSON")


def work_arguments(parser: argparse.ArgumentParser) -> None:
    """Add ``--jobs``, ``--seed`` and ``--json``."""
    parser.add_argument("--jobs", type=int, default=1, metavar="J", help="processes")
    parser.add_argument("--seed", type=int, default=0)
    json_argument(parser)


def bar(what: str) -> Callable[[int, int], None]:
    """Give a function that makes a bar when it first hears how much there is to do."""
    bars: dict[int, Callable[[int], None]] = {}

    def move(done: int, total: int) -> None:
        if total not in bars:
            bars[total] = progress(total, what)
        bars[total](done)

    return move


def words(text: str) -> tuple[str, ...]:
    """Read words with commas between."""
    return tuple(word.strip() for word in text.split(",") if word.strip())


def numbers(text: str) -> tuple[float, ...]:
    """Read numbers with commas between."""
    return tuple(float(word) for word in words(text))


def whole_numbers(text: str) -> tuple[int, ...]:
    """Read whole numbers with commas between."""
    return tuple(int(word) for word in words(text))


def print_table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print a table, numbers to the right."""
    widths = [max(len(str(row[i])) for row in (columns, *rows)) for i in range(len(columns))]
    for row in (columns, *rows):
        say("  ".join(f"{cell:>{w}}" for cell, w in zip(row, widths, strict=True)).rstrip())


def write_json(path: Path | None, record: dict[str, Any]) -> None:
    """Write all figures, where a file was asked for."""
    if path is None:
        return
    try:
        path.write_text(json_text(record), encoding="utf-8")
    except OSError as error:
        raise CannotWrite(f"{path} cannot be written: {error.strerror}.") from None
