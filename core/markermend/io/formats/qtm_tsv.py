"""TSV as Qualisys Track Manager exports it."""

import numpy as np

from markermend.errors import CannotWrite, UnreadableTake
from markermend.io.contents import quoted
from markermend.io.table import Table, find_rows
from markermend.io.text_format import Parsed, number_in, text_format
from markermend.io.textfile import TextFile
from markermend.model import Take

_MOST_HEADER_LINES = 60


def recognises(text: str) -> bool:
    """Whether the text begins with QTM's keywords."""
    return text.lstrip().startswith(("NO_OF_FRAMES", "NO_OF_CAMERAS", "NO_OF_MARKERS"))


def parse(text: TextFile) -> Parsed:
    """Find header and table; QTM exports mm and writes 0, 0, 0 or nothing for a gap.

    Raises
    ------
    UnreadableTake
        If the file holds no 3-D data or does not name its markers.
    """
    said: dict[str, list[str]] = {}
    for line in text.lines[:_MOST_HEADER_LINES]:
        key, *cells = line.rstrip("\r").split("\t")
        if key and key.upper() == key and key[0].isalpha():
            said.setdefault(key, cells)
    included = " ".join(said.get("DATA_INCLUDED", ["3D"])).strip()
    if included.upper() != "3D":
        raise UnreadableTake(
            f"The QTM file holds {quoted(included)} data, not 3D; export the 3D data from QTM."
        )
    names = [name.strip() for name in said.get("MARKER_NAMES", ())]
    while names and not names[-1]:
        names.pop()
    if not names:
        raise UnreadableTake("The QTM file has no line MARKER_NAMES; export it with its header.")
    rows = find_rows(text, len(said), "\t", 3 * len(names))
    filled = [i for i, cell in enumerate(text.lines[rows[0]].split("\t")) if cell.strip()]
    titles = text.lines[rows[0] - 1].split("\t")
    first_column = 2 if titles[0].strip().lower() == "frame" else 0
    if max(filled, default=-1) >= first_column + 3 * len(names):
        raise UnreadableTake(
            f"The QTM file names {len(names)} markers, and its rows have other columns than three "
            "for each; export the 3D data alone."
        )
    columns = first_column + np.arange(3 * len(names)).reshape(-1, 3)
    decimal = "," if "," in text.lines[rows[0]] else "."
    table = Table(text, rows, columns, "\t", decimal, blank=f"0{decimal}000")
    warnings = []
    announced = number_in(said.get("NO_OF_FRAMES", []), 0)
    if announced is not None and announced != len(rows):
        warnings.append(f"The header announces {announced:g} frames, {len(rows)} are there.")
    markers = number_in(said.get("NO_OF_MARKERS", []), 0)
    if markers is not None and markers != len(names):
        warnings.append(f"The header announces {markers:g} markers and names {len(names)}.")
    rate = number_in(said.get("FREQUENCY", []), 0)
    first = number_in(table.cells(rows[0]), 0) if first_column else 1
    return Parsed(
        table,
        names,
        rate if rate is not None and rate > 0 else None,
        "mm",
        int(first or 1),
        warnings=warnings,
    )


def write_tsv(take: Take) -> bytes:
    """Give the bytes of a QTM TSV file in mm; 0, 0, 0 where a marker was not seen.

    Raises
    ------
    CannotWrite
        If the take is two-dimensional or a label holds a tab or a line end.
    """
    if take.n_dims != 3:
        raise CannotWrite("QTM's TSV holds three dimensions, this take has two; write .npz.")
    if any(set(label) & set("\t\r\n") for label in take.labels):
        raise CannotWrite("A label holds a tab or a line end, which TSV cannot; write .npz.")
    head = [
        f"NO_OF_FRAMES\t{take.n_frames}",
        f"NO_OF_MARKERS\t{take.n_markers}",
        f"FREQUENCY\t{take.rate:g}",
        "DATA_INCLUDED\t3D",
        "MARKER_NAMES\t" + "\t".join(take.labels),
        "Frame\tTime\t" + "\t".join(f"{name} {a}" for name in take.labels for a in "XYZ"),
    ]
    rows = [
        f"{take.first_frame + i}\t{i / take.rate:.5f}\t"
        + "\t".join(f"{x:.5f}" for x in np.nan_to_num(frame.ravel()))
        for i, frame in enumerate(take.positions)
    ]
    return ("\r\n".join([*head, *rows]) + "\r\n").encode()


FORMAT = text_format("qtm_tsv", "QTM TSV", (".tsv",), recognises, parse, write_tsv)
