"""CSV as Vicon Nexus exports it: blocks of which one is called Trajectories."""

import re

import numpy as np

from markermend.errors import UnreadableTake
from markermend.io.contents import unit_name
from markermend.io.table import Table, find_rows
from markermend.io.text_format import Parsed, number_in, text_format
from markermend.io.textfile import TextFile

_FRAME = re.compile(r'^"?Frame"?([,;\t])"?Sub Frame"?', re.IGNORECASE)


def recognises(text: str) -> bool:
    """Whether a line names Frame and Sub Frame, as every block of Nexus has it."""
    return any(_FRAME.match(line) for line in text.splitlines())


def parse(text: TextFile) -> Parsed:
    """Find the block of trajectories, after model outputs or devices if need be.

    Raises
    ------
    UnreadableTake
        If there is no such block.
    """
    lines = text.lines
    at = next((i for i, line in enumerate(lines) if _title(line) == "trajectories"), None)
    if at is None or at + 5 >= len(lines):
        raise UnreadableTake(
            "The Nexus file has no block of trajectories; export the trajectories with it."
        )
    match = _FRAME.match(lines[at + 3])
    if match is None:
        raise UnreadableTake("The block of trajectories has no line Frame, Sub Frame, X, Y, Z.")
    separator = match.group(1)
    rate = number_in(re.split(r"[,;\t]", lines[at + 1].strip("\r").replace('"', "")), 0)
    if separator == ";" and rate is not None:
        rate = number_in([lines[at + 1].split(";")[0]], 0)
    titles = _cells(lines[at + 2], separator)
    axes = _cells(lines[at + 3], separator)
    units = _cells(lines[at + 4], separator)
    names, columns = [], []
    for i, title in enumerate(titles):
        if title and [axis.upper() for axis in axes[i : i + 3]] == ["X", "Y", "Z"]:
            names.append(title)
            columns.append((i, i + 1, i + 2))
    if not names:
        raise UnreadableTake("The block of trajectories names no markers.")
    rows = find_rows(text, at + 5, separator, 2 + 3 * len(names), stop_at_blank=True)
    decimal = "," if separator != "," and "," in lines[rows[0]] else "."
    table = Table(text, rows, np.array(columns), separator, decimal)
    unit = unit_name(units[columns[0][0]] if columns[0][0] < len(units) else None)
    first = number_in(table.cells(rows[0]), 0)
    return Parsed(table, names, rate if rate and rate > 0 else None, unit, int(first or 1))


def _title(line: str) -> str:
    return line.strip('\r,;\t "').lower()


def _cells(line: str, separator: str) -> list[str]:
    return [cell.strip().strip('"').strip() for cell in line.split(separator)]


FORMAT = text_format("nexus_csv", "Vicon Nexus CSV", (".csv",), recognises, parse)
