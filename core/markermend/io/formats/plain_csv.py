"""Tables of which one header line names every column: ``name-TX, name-TY, name-TZ``.

Comma, semicolon or tab between the cells, point or comma in the numbers; ``name_X``, ``name X``,
``name.X`` and ``name:X`` are understood as well. A column called Time gives the rate.
"""

import numpy as np

from markermend.errors import CannotWrite, UnreadableTake
from markermend.io.table import Table, find_rows
from markermend.io.text_format import (
    Parsed,
    coordinate_names,
    number_in,
    rate_of_times,
    text_format,
)
from markermend.io.textfile import TextFile
from markermend.model import Take

_MOST_HEADER_LINES = 30
_FORMULA = tuple("=+-@")
"""What makes spreadsheets compute a cell, with `_TEXT` before it they show it."""
_TEXT = "'"


def recognises(text: str) -> bool:
    """Whether one of the first lines names coordinates."""
    return _header(text.splitlines()) is not None


def _header(lines: list[str]) -> tuple[int, str, list[tuple[str, tuple[int, ...]]]] | None:
    """Find the line that names the columns: its place, separator and columns."""
    for i, line in enumerate(lines[:_MOST_HEADER_LINES]):
        for separator in "\t;,":
            named = coordinate_names(line.rstrip("\r").split(separator))
            if named:
                return i, separator, named
    return None


def parse(text: TextFile) -> Parsed:
    """Find header and table.

    Raises
    ------
    UnreadableTake
        If no line names the columns.
    """
    header = _header(list(text.lines[:_MOST_HEADER_LINES]))
    if header is None:
        raise UnreadableTake(
            "No line of the table names its columns (as in NAME-TX, NAME-TY, NAME-TZ), so its "
            "markers are not known; export it with its header."
        )
    at, separator, named = header
    columns = np.array([places for _, places in named])
    rows = find_rows(text, at + 1, separator, int(columns.max()) + 1)
    decimal = "," if separator != "," and "," in text.lines[rows[0]] else "."
    table = Table(text, rows, columns, separator, decimal)
    titles = [cell.strip().strip('"').lower() for cell in text.lines[at].split(separator)]
    time = next((i for i, t in enumerate(titles) if t.split(" ")[0].split("(")[0] == "time"), None)
    first = number_in(table.cells(rows[0]), 0) if 0 not in columns and time != 0 else 1
    whole = first is not None and first == int(first)
    return Parsed(
        table,
        [_unguarded(name) for name, _ in named],
        None if time is None else rate_of_times(table, time),
        None,
        int(first or 0) if whole else 1,
    )


def _unguarded(name: str) -> str:
    guarded = name.startswith(_TEXT) and name[1:2] in _FORMULA
    return name[1:] if guarded else name


def write_csv(take: Take) -> bytes:
    """Give the bytes of a table in mm with a header line; blank where a marker was not seen.

    A label that a spreadsheet would take for a formula gets an apostrophe before it, which a
    spreadsheet does not show and `parse` takes off again.

    Raises
    ------
    CannotWrite
        If the take is two-dimensional or a label holds a separator.
    """
    if take.n_dims != 3:
        raise CannotWrite("The table holds three dimensions, this take has two; write .npz.")
    if any(set(label) & set(',;"\t\r\n') for label in take.labels):
        raise CannotWrite("A label holds a comma, quote or tab, which CSV cannot; write .npz.")
    names = [f"{_TEXT}{name}" if name[:1] in _FORMULA else name for name in take.labels]
    head = "Frame,Time," + ",".join(f"{name}-T{axis}" for name in names for axis in "XYZ")
    rows = [
        f"{take.first_frame + i},{i / take.rate:.6f},"
        + ",".join("" if np.isnan(x) else f"{x:.5f}" for x in frame.ravel())
        for i, frame in enumerate(take.positions)
    ]
    return ("\n".join([head, *rows]) + "\n").encode()


FORMAT = text_format(
    "plain_csv",
    "CSV with a header line",
    (".csv", ".tsv", ".txt"),
    recognises,
    parse,
    write_csv,
    generic=True,
)
