"""TRC, the tab-separated tracks of Motion Analysis, OpenSim and many others."""

from collections import Counter

import numpy as np

from markermend.errors import CannotWrite, UnreadableTake
from markermend.io.contents import quoted, unit_name
from markermend.io.table import Table, find_rows
from markermend.io.text_format import Parsed, number_in, rate_of_times, text_format
from markermend.io.textfile import TextFile
from markermend.model import Take

_HEADER_LINES = 5
_LEADING = 2
_KEYS = (
    "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame"
    "\tOrigNumFrames"
)


def recognises(text: str) -> bool:
    """Whether the first line says PathFileType."""
    return text.lstrip().startswith("PathFileType")


def parse(text: TextFile) -> Parsed:
    """Find header and table.

    Rows that hold nothing but their number and time, before the first or after the last row of
    usual width, are no frames; between those they are frames in which nothing was seen.
    Columns beyond the named ones are trajectories that nobody labelled; they are left alone.

    Raises
    ------
    UnreadableTake
        If the header names no markers, or there are no rows.
    """
    lines = text.lines
    if len(lines) < _HEADER_LINES or not lines[3].lower().lstrip().startswith("frame"):
        raise UnreadableTake(
            "The TRC file ends in its header, or its fourth line does not name the markers; "
            "export it again."
        )
    said = dict(zip(lines[1].lower().split(), lines[2].split(), strict=False))
    separator = "\t" if "\t" in lines[3] else ""
    cells = lines[3].split(separator or None)
    names = [name.strip() for name in cells[2:] if name.strip()]
    if not names:
        raise UnreadableTake("The TRC file names no markers in its fourth line.")
    rows = find_rows(text, _HEADER_LINES - 1, separator, 2 + 3 * len(names))
    columns = 2 + np.arange(3 * len(names)).reshape(-1, 3)
    table = Table(text, rows, columns, separator, _decimal(lines[rows[0]], separator))
    warnings = []
    announced = number_in([said.get("numframes", "")], 0)
    if announced is not None and announced != len(rows):
        warnings.append(f"The header announces {announced:g} frames, {len(rows)} are there.")
    table, empty, before = _without_empty_ends(table)
    if empty:
        warnings.append(
            f"{empty} rows at the ends hold no samples, only number and time, and are no frames."
        )
    markers = number_in([said.get("nummarkers", "")], 0)
    if markers is not None and markers != len(names):
        warnings.append(f"The header announces {markers:g} markers and names {len(names)}.")
    widest = max(len(table.cells(row)) for row in table.rows)
    unnamed = (widest - 2 - 3 * len(names)) // 3
    if unnamed > 0:
        warnings.append(
            f"Some rows have up to {unnamed} trajectories more than the header names; those were "
            "not read and stay as they are."
        )
    rate, rate_warnings = _rate(number_in([said.get("datarate", "")], 0), table)
    units = unit_name(said.get("units"))
    if units is None and "units" in said:
        warnings.append(f"The file's unit {quoted(said['units'])!r} is not known.")
    # Counted back from the first usual row, so that every sample has the file's own number.
    first = int(number_in(table.cells(table.rows[before]), 0) or 0) - before
    return Parsed(table, names, rate, units, first, warnings=[*warnings, *rate_warnings])


def _decimal(line: str, separator: str) -> str:
    cells = line.split(separator or None)[1:]
    return "," if any("," in cell for cell in cells) and "." not in line else "."


def _without_empty_ends(table: Table) -> tuple[Table, int, int]:
    """Leave out rows without any cells before the first and after the last usual row.

    Says how many they are, and how many other rows are left before the first usual one.
    """
    widths = [len(table.cells(row)) for row in table.rows]
    (usual, _), *_ = Counter(widths).most_common(1)
    first, last = widths.index(usual), len(widths) - 1 - widths[::-1].index(usual)
    if usual <= _LEADING:
        return table, 0, 0
    kept = [
        row
        for i, (row, width) in enumerate(zip(table.rows, widths, strict=True))
        if width > _LEADING or first < i < last
    ]
    before = kept.index(table.rows[first])
    left_out = len(table.rows) - len(kept)
    return table.with_rows(kept, before if before < first else 0), left_out, before


def _rate(said: float | None, table: Table) -> tuple[float | None, list[str]]:
    timed = rate_of_times(table, 1)
    if said is not None and said > 0:
        if timed is not None and abs(timed - said) > 0.05 * said:
            return said, [f"The header says {said:g} Hz, the times {timed:.4g} Hz."]
        return said, []
    if timed is None:
        return None, []
    return timed, [f"The header says no rate; the times say {timed:.6g} Hz."]


def write_trc(take: Take) -> bytes:
    """Give the bytes of a TRC file in mm; blank cells where a marker was not seen.

    Raises
    ------
    CannotWrite
        If the take is two-dimensional or a label holds a tab or a line end.
    """
    if take.n_dims != 3:
        raise CannotWrite("TRC holds three dimensions, this take has two; write it as .npz.")
    if any(set(label) & set("\t\r\n") for label in take.labels):
        raise CannotWrite("A label holds a tab or a line end, which TRC cannot; write .npz.")
    rate, n_frames = f"{take.rate:g}", take.n_frames
    values = (rate, rate, n_frames, take.n_markers, "mm", rate, take.first_frame, n_frames)
    head = [
        "PathFileType\t4\t(X/Y/Z)\tmarkermend.trc",
        _KEYS,
        "\t".join(map(str, values)),
        "Frame#\tTime\t" + "\t\t\t".join(take.labels) + "\t\t",
        "\t\t" + "\t".join(f"X{i}\tY{i}\tZ{i}" for i in range(1, take.n_markers + 1)),
        "",
    ]
    rows = [
        f"{take.first_frame + i}\t{i / take.rate:.6f}\t"
        + "\t".join("" if np.isnan(x) else f"{x:.5f}" for x in frame.ravel())
        for i, frame in enumerate(take.positions)
    ]
    return ("\n".join([*head, *rows]) + "\n").encode()


FORMAT = text_format("trc", "TRC", (".trc",), recognises, parse, write_trc)
