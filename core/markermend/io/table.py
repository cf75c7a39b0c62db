"""Tables of coordinates in text files: read them, and change single cells of them.

Numbers may have a decimal comma. Blank cells, NaN in any spelling and the like mean not seen. A
repaired coordinate is written with as many decimals as its column has, and everything else in the
file stays as it is.
"""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from markermend.errors import CannotWrite, UnreadableTake
from markermend.io.contents import seen_only
from markermend.io.format import Patch
from markermend.io.limits import check_size
from markermend.io.textfile import TextFile
from markermend.model import BoolArray, FloatArray

_MISSING = {"", "nan", "-nan", "na", "n/a", "null", "none", "-", "--", "nan(ind)", "-nan(ind)"}
_MISSING |= {"1.#qnan", "-1.#ind", "1.#ind", "missing", "."}
_MOST_DECIMALS = 12
_NUMBER = re.compile(r"^[+-]?(\d*)(?:\.(\d*))?(?:[eE][+-]?\d+)?$")


@dataclass(frozen=True, eq=False)
class Table:
    """Where the coordinates are in a text file.

    Attributes
    ----------
    text
        The file.
    rows
        Line of each frame.
    columns
        (n_points, n_dims) cell of each coordinate.
    separator
        Between cells; empty where any white space separates them.
    decimal
        ``"."`` or ``","``.
    blank
        What stands for a coordinate that was not seen, where the file shows no example.
    apart
        So many frames at the beginning are further from the others in the file than in the take;
        nothing is written into them.
    """

    text: TextFile
    rows: tuple[int, ...]
    columns: NDArray[np.intp]
    separator: str
    decimal: str = "."
    blank: str = ""
    apart: int = 0

    def positions(self) -> tuple[FloatArray, tuple[str, ...]]:
        """Read all coordinates, NaN = not seen, and say what was odd.

        Raises
        ------
        UnreadableTake
            If the table is beyond the limits.
        """
        n_points, n_dims = self.columns.shape
        check_size(len(self.rows), n_points)
        flat = [int(column) for column in self.columns.ravel()]
        last = max(flat, default=-1) + 1
        values = np.full((len(self.rows), n_points * n_dims), np.nan)
        strange = 0
        for i, row in enumerate(self.rows):
            cells = self.cells(row)
            if len(cells) < last:
                cells += [""] * (last - len(cells))
            try:
                values[i] = [float(cells[column]) for column in flat]
            except ValueError:
                for j, column in enumerate(flat):
                    number = as_number(cells[column])
                    values[i, j] = math.nan if number is None else number
                    strange += number is None
        clean, odd = seen_only(
            values.reshape(-1, n_points, n_dims), np.ones((len(self.rows), n_points), bool)
        )
        if strange:
            odd = (f"{strange} cells hold no number and count as not seen.", *odd)
        return clean, odd

    def with_rows(self, rows: Sequence[int], apart: int = 0) -> "Table":
        """Give the same table with other rows."""
        return replace(self, rows=tuple(rows), apart=apart)

    def cells(self, row: int) -> list[str]:
        """Split a line into its cells, with points as decimal marks."""
        line = self.text.lines[row]
        if self.decimal == ",":
            line = line.replace(",", ".")
        return line.split(self.separator) if self.separator else line.split()

    def patched(self, positions: FloatArray, changed: BoolArray) -> Patch:
        """Write changed coordinates into their cells.

        Raises
        ------
        CannotWrite
            If a row is to be changed whose place in time is not the one that it has in the take.
        """
        if changed[: self.apart].any():
            raise CannotWrite(
                f"Rows that hold nothing stand after the first {self.apart} frames of the file, so "
                "that their time is not certain; leave them as they are, or write another file."
            )
        lines = list(self.text.lines)
        formats = {int(m): self._written_as(int(m)) for m in np.flatnonzero(changed.any(axis=0))}
        blank = self._example_of_blank() if not np.isfinite(positions[changed]).all() else ""
        resolution = 0.0
        for i in np.flatnonzero(changed.any(axis=1)):
            parts = self._parts(lines[self.rows[i]])
            for m in np.flatnonzero(changed[i]):
                decimals, exponent = formats[int(m)]
                seen = np.isfinite(positions[i, m]).all()
                written = [
                    self._number(x, decimals, exponent) if seen else blank for x in positions[i, m]
                ]
                if seen and not any(as_number(x.replace(",", ".")) for x in written):
                    written[0] = self._number(10.0**-decimals, decimals, exponent)
                resolution = max(resolution, _step(positions[i, m], decimals, exponent))
                for column, cell in zip(self.columns[m], written, strict=True):
                    _put(parts, int(column), cell, self.separator)
            lines[self.rows[i]] = "".join(parts)
        return Patch(self.text.encode(lines), resolution)

    def compare(self, other: TextFile) -> BoolArray | None:
        """Find the coordinates whose cells differ; None where anything else does."""
        text = self.text
        differs = np.zeros((len(self.rows), len(self.columns)), bool)
        if replace(other, lines=()) != replace(text, lines=()) or len(text.lines) != len(
            other.lines
        ):
            return None
        frame = {row: i for i, row in enumerate(self.rows)}
        point = {int(c): m for m, columns in enumerate(self.columns) for c in columns}
        for row, (old, new) in enumerate(zip(text.lines, other.lines, strict=True)):
            if old == new:
                continue
            if row not in frame:
                return None
            before, after = self._parts(old), self._parts(new)
            missing = (len(after) - len(before)) // 2 if self.separator else 0
            if missing > 0:  # cells that the row had left out at its end
                before[-1], end = _body(before[-1])
                before += [self.separator, ""] * missing
                before[-1] += end
            if len(before) != len(after) or before[1::2] != after[1::2]:
                return None
            for cell, (one, two) in enumerate(zip(before[::2], after[::2], strict=True)):
                if one != two and not (one.strip() == two.strip() == ""):
                    if cell not in point:
                        return None
                    differs[frame[row], point[cell]] = True
        return differs

    def _parts(self, line: str) -> list[str]:
        """Split a line into cells (even places) and what is between them (odd places)."""
        if not self.separator:
            parts = re.split(r"(\s+)", line)
            if parts[0] == "" and len(parts) > 1:
                parts[:3] = ["".join(parts[:3])]  # leading blanks belong to the first cell
            return parts
        parts = []
        for cell in line.split(self.separator):
            parts += [cell, self.separator]
        return parts[:-1]

    def _number(self, value: float, decimals: int, exponent: bool) -> str:
        text = f"{value:.{decimals}{'e' if exponent else 'f'}}"
        if not float(text):
            text = text.lstrip("-")
        return text.replace(".", self.decimal)

    def _written_as(self, marker: int) -> tuple[int, bool]:
        """Find the number of decimals of a marker's columns, and whether they have exponents."""
        decimals, exponent = self._decimals([marker])
        if decimals < 0:  # never seen: as the others are written
            decimals, exponent = self._decimals(range(len(self.columns)))
        return (6 if decimals < 0 else decimals), exponent

    def _decimals(self, markers: Sequence[int]) -> tuple[int, bool]:
        wanted = [int(c) for m in markers for c in self.columns[m]]
        most, exponent = -1, False
        for row in self.rows[:: max(1, len(self.rows) // 500)]:
            cells = self.cells(row)
            for column in wanted:
                cell = bare(cells[column]) if column < len(cells) else ""
                match = _NUMBER.match(cell)
                if match and as_number(cell) and any(map(str.isdigit, cell)):
                    most = max(most, len(match.group(2) or ""))
                    exponent |= "e" in cell.lower()
        return min(most, _MOST_DECIMALS), exponent

    def _example_of_blank(self) -> str:
        """Find how the file itself writes a coordinate that was not seen."""
        positions, _ = self.positions()
        places = np.argwhere(np.isnan(positions[..., 0]))
        for i, m in places[:1]:
            parts = self._parts(self.text.lines[self.rows[i]])[::2]
            column = int(self.columns[m, 0])
            if column < len(parts):
                return bare(parts[column])
        return self.blank


def bare(cell: str) -> str:
    """Strip blanks and quotes off a cell."""
    return cell.strip().strip('"').strip()


def as_number(cell: str) -> float | None:
    """Read a cell with a decimal point; NaN for what means not seen, None for anything else."""
    cell = bare(cell)
    if cell.lower() in _MISSING:
        return math.nan
    try:
        return float(cell)
    except ValueError:
        return None


def _step(value: FloatArray, decimals: int, exponent: bool) -> float:
    largest = float(np.nan_to_num(np.abs(value)).max(initial=0.0))
    power = math.floor(math.log10(largest)) if exponent and largest > 0 else 0
    return float(10.0 ** (power - decimals))


def _put(parts: list[str], column: int, written: str, separator: str) -> None:
    """Replace the text of a cell and keep the blanks, quotes and line end around it."""
    if 2 * column >= len(parts):
        if not separator:
            raise CannotWrite(
                "A repaired coordinate lies where its row of the text file has no cell; export "
                "the take in another format."
            )
        last, end = _body(parts[-1])
        parts[-1] = last
        while 2 * column >= len(parts):
            parts += [separator, ""]
        parts[-1] = end
    old = parts[2 * column]
    core = old.strip()
    if not core:
        end = "\r" if old.endswith("\r") else ""
        width = len(old) - len(end)
        parts[2 * column] = written.rjust(width) + end
        return
    at = old.index(core)
    before, after = old[:at], old[at + len(core) :]
    if core.startswith('"') and core.endswith('"') and len(core) > 1:
        written = f'"{written}"'
    spare = len(core) - len(written) + len(before)
    parts[2 * column] = (" " * max(spare, 0) if before else "") + written + after


def _body(cell: str) -> tuple[str, str]:
    return (cell[:-1], "\r") if cell.endswith("\r") else (cell, "")


def find_rows(
    text: TextFile, first: int, separator: str, least_cells: int, stop_at_blank: bool = False
) -> tuple[int, ...]:
    """Find the lines that begin with a number, from line `first` on.

    A last line that is shorter than the others and has no line end was cut off and is left out.

    Raises
    ------
    UnreadableTake
        If there is no such line.
    """
    rows: list[int] = []
    for row in range(first, len(text.lines)):
        line = text.lines[row]
        head = line.split(separator, 1)[0] if separator else (line.split(maxsplit=1) or [""])[0]
        if not line.strip():
            if stop_at_blank and rows:
                break
            continue
        number = as_number(head.replace(",", ".") or "no")
        if number is None or not math.isfinite(number):
            if rows:
                break
            continue
        rows.append(row)
    if rows and rows[-1] == len(text.lines) - 1 and len(rows) > 1:
        line = text.lines[rows[-1]]
        n_cells = len(line.split(separator or None))
        if n_cells < min(least_cells, len(text.lines[rows[-2]].split(separator or None))):
            rows.pop()
    if not rows:
        raise UnreadableTake("The text file holds no rows of numbers.")
    return tuple(rows)
