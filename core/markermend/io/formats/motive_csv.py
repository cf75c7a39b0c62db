"""CSV as OptiTrack Motive exports it; every version from 1.2 on that names its version."""

import numpy as np

from markermend.errors import UnreadableTake
from markermend.io.contents import unit_name
from markermend.io.table import Table, find_rows
from markermend.io.text_format import Parsed, number_in, rate_of_times, text_format
from markermend.io.textfile import TextFile
from markermend.model import Role

_MOST_HEADER_LINES = 40


def recognises(text: str) -> bool:
    """Whether the text begins with a format version."""
    return text.lstrip('" ').startswith("Format Version")


def parse(text: TextFile) -> Parsed:
    """Find the positions among rotations, errors and qualities.

    A rigid body's or bone's own position is an output of the solver; ``Unlabeled`` markers are
    unlabelled trajectories.

    Raises
    ------
    UnreadableTake
        If there are no positions.
    """
    lines = text.lines
    separator = next((mark for mark in ",;\t" if f"Version{mark}" in lines[0]), ",")
    cells = _cells(lines[0], separator)
    said = dict(zip(cells[::2], cells[1::2], strict=False))
    at = next(
        (
            i
            for i, line in enumerate(lines[:_MOST_HEADER_LINES])
            if _cells(line, separator)[:1] == ["Frame"]
        ),
        None,
    )
    above = [line for line in lines[1 : at or 1] if line.strip(f"\r {separator}")]
    if at is None or len(above) < 3:
        raise UnreadableTake("The Motive file has no line Frame, Time, X, Y, Z under its header.")
    axes, quantities = _cells(lines[at], separator), _cells(above[-1], separator)
    kinds, titles = _cells(above[0], separator), _cells(above[1], separator)
    if min(len(kinds), len(titles), len(quantities)) < len(axes):
        raise UnreadableTake(
            "The header lines of the Motive file have fewer cells than its columns; export it "
            "again."
        )
    names: list[str] = []
    roles: list[Role] = []
    columns = []
    for i in range(2, len(axes) - 2):
        if axes[i : i + 3] != ["X", "Y", "Z"] or quantities[i : i + 3] != ["Position"] * 3:
            continue
        names.append(titles[i])
        roles.append(_role(kinds[i], titles[i]))
        columns.append((i, i + 1, i + 2))
    if not names:
        raise UnreadableTake("The Motive file holds no positions; export them with it.")
    rows = find_rows(text, at + 1, separator, len(axes))
    decimal = "," if separator != "," and "," in lines[rows[0]] else "."
    table = Table(text, rows, np.array(columns), separator, decimal)
    rate = number_in([said.get("Export Frame Rate") or said.get("Capture Frame Rate") or ""], 0)
    if rate is None or rate <= 0:
        rate = rate_of_times(table, 1)
    announced = number_in([said.get("Total Exported Frames", "")], 0)
    warnings = []
    if announced is not None and announced != len(rows):
        warnings.append(f"The header announces {announced:g} frames, {len(rows)} are there.")
    first = number_in(table.cells(rows[0]), 0)
    units = unit_name(said.get("Length Units"))
    return Parsed(table, names, rate, units, int(first or 0), roles, warnings)


def _role(kind: str, title: str) -> Role:
    if "unlabeled" in f"{kind} {title}".lower():
        return "unlabelled"
    return "measured" if "marker" in kind.lower() else "model"


def _cells(line: str, separator: str) -> list[str]:
    return [cell.strip().strip('"').strip() for cell in line.split(separator)]


FORMAT = text_format("motive_csv", "OptiTrack Motive CSV", (".csv",), recognises, parse)
