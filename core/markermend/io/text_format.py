"""Make a format of a function that finds the table in a text file."""

import hashlib
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from markermend.errors import UnreadableTake
from markermend.io.contents import Contents, unique_labels, warned
from markermend.io.format import Format, Patch, Patching, Reading
from markermend.io.roles import roles_of
from markermend.io.table import Table, as_number, bare
from markermend.io.textfile import MOST_BYTES, TextFile, sniff
from markermend.model import BoolArray, FloatArray, Role, Take


@dataclass(frozen=True, eq=False)
class Parsed:
    """What the header of a text file says, and where its table is.

    Attributes
    ----------
    table
        Where the coordinates are.
    names
        One per point, as the file has them.
    rate, units
        Hz and normalised unit, or None where the file does not say them.
    first_frame
        Number of the first row.
    roles
        One per point where the file says them, else none.
    warnings
        Where the header is wrong.
    """

    table: Table
    names: Sequence[str]
    rate: float | None
    units: str | None
    first_frame: int = 1
    roles: Sequence[Role] = ()
    warnings: Sequence[str] = ()


def text_format(
    name: str,
    title: str,
    extensions: tuple[str, ...],
    recognises: Callable[[str], bool],
    parse: Callable[[TextFile], Parsed],
    write: Callable[[Take], bytes] | None = None,
    *,
    generic: bool = False,
) -> Format:
    """Make a format.

    Parameters
    ----------
    recognises
        Whether text begins like this format.
    parse
        Finds the table; raises UnreadableTake.
    name, title, extensions, write, generic
        As in `Format`.
    """

    def open_text(path: Path, _reading: Reading) -> Contents:
        if path.stat().st_size > MOST_BYTES:
            raise UnreadableTake(
                f"{path.name} has {path.stat().st_size / 1e6:.0f} MB of text, more than the "
                f"{MOST_BYTES / 1e6:.0f} MB that are read; cut the recording into parts."
            )
        data = path.read_bytes()
        parsed = parse(TextFile.decode(data))
        positions, odd = parsed.table.positions()
        labels = unique_labels(parsed.names)
        doubles = len(parsed.names) - len(set(parsed.names))
        if doubles:
            odd = (f"{doubles} labels occur more than once and are numbered.", *odd)
        return Contents(
            path=path,
            format=name,
            sha256=hashlib.sha256(data).hexdigest(),
            positions=positions,
            rate=parsed.rate,
            units=parsed.units,
            labels=labels,
            roles=tuple(parsed.roles) or roles_of(labels, parsed.names),
            first_frame=parsed.first_frame,
            warnings=warned((*parsed.warnings, *odd)),
        )

    def positions_in(data: bytes, _reading: Reading) -> FloatArray:
        return parse(TextFile.decode(data)).table.positions()[0]

    def patch(data: bytes, _reading: Reading, positions: FloatArray, changed: BoolArray) -> Patch:
        return parse(TextFile.decode(data)).table.patched(positions, changed)

    def compare(old: bytes, new: bytes, _reading: Reading) -> BoolArray | None:
        before = TextFile.decode(old)
        return parse(before).table.compare(TextFile.decode(new, before.encoding))

    return Format(
        name=name,
        title=title,
        extensions=extensions,
        recognises=lambda _path, head: recognises(sniff(head)),
        open=open_text,
        patching=Patching(positions_in, patch, compare),
        write=write,
        generic=generic,
    )


_LATEST_S = 1e9
"""No recording has later times; what is beyond is no time."""


def number_in(cells: Sequence[str], place: int) -> float | None:
    """Read a finite number of a header line, or None."""
    number = as_number(cells[place].replace(",", ".")) if place < len(cells) else None
    return number if number is not None and math.isfinite(number) else None


def rate_of_times(table: Table, column: int) -> float | None:
    """Find the rate by a column of times in s; None where they do not rise evenly."""
    cells = [table.cells(row) for row in table.rows]
    times = [as_number(c[column]) if column < len(c) else None for c in cells]
    array = np.array([math.nan if t is None else t for t in times])
    if len(array) < 2 or not (np.abs(array) < _LATEST_S).all():
        return None
    steps = np.diff(array)
    if (steps <= 0).any():
        return None
    mean = float(steps.mean())
    # Times are often rounded to ms, so the mean step is the measure and single ones may differ.
    if (np.abs(steps - mean) > 0.0015 + 0.02 * mean).any():
        return None
    rate = 1.0 / mean
    return float(round(rate)) if abs(rate - round(rate)) < 0.02 * rate / len(steps) else rate


def coordinate_names(cells: Sequence[str]) -> list[tuple[str, tuple[int, ...]]]:
    """Find runs of three columns ``name-TX, name-TY, name-TZ`` and the like in a header line."""
    found: list[tuple[str, tuple[int, ...]]] = []
    words = [bare(cell) for cell in cells]
    for i in range(len(words) - 2):
        if words[i][-1:] not in ("X", "x"):
            continue
        names = [_axis(words[i + k], "XYZ"[k]) for k in range(3)]
        if names[0] is not None and names[0] == names[1] == names[2]:
            found.append((names[0], (i, i + 1, i + 2)))
    return found


def _axis(cell: str, axis: str) -> str | None:
    """Give the name of a column without the axis at its end, or None where it has another."""
    if cell[-1:].upper() != axis:
        return None
    name = cell[:-1]
    for ending in ("-T", "_T", ".T", " T", ":T", "-", "_", ".", " ", ":"):
        if name.upper().endswith(ending):
            return name[: -len(ending)].strip() or None
    return None
