"""The only room that knows file formats.

`read` gives a take, `open_contents` what a file holds before its unit and rate are known, `export`
and `write` give takes back as files.
"""

from pathlib import Path

from markermend.errors import UnreadableTake
from markermend.io.contents import Contents
from markermend.io.exporting import Written, export, write
from markermend.io.format import Format, Reading, all_formats, format_of
from markermend.model import Take

__all__ = [
    "Contents",
    "Format",
    "Reading",
    "Written",
    "all_formats",
    "export",
    "open_contents",
    "read",
    "write",
]


def open_contents(path: str | Path, *, ignore_residuals: bool = False) -> Contents:
    """Read a file without asking for its unit and rate.

    Parameters
    ----------
    path
        A recording in any known format.
    ignore_residuals
        Take every sample of a C3D file as seen, whatever its residual says.

    Raises
    ------
    UnreadableTake
        If the file is in no known format, is broken beyond reading, or is beyond a limit.
    """
    path = Path(path)
    try:
        return format_of(path).open(path, Reading(ignore_residuals))
    except UnreadableTake as refusal:
        if path.name in str(refusal):
            raise
        # Among many files of a folder, the sentence has to say which one it is about.
        raise UnreadableTake(f"{path.name}: {refusal}") from None


def read(
    path: str | Path,
    *,
    units: str | None = None,
    rate: float | None = None,
    ignore_residuals: bool = False,
) -> Take:
    """Read a take.

    Parameters
    ----------
    path
        A recording in any known format.
    units
        ``"mm"``, ``"cm"`` or ``"m"``, where the file does not say it.
    rate
        Hz, where the file does not say it.
    ignore_residuals
        Take every sample of a C3D file as seen, whatever its residual says.

    Raises
    ------
    UnreadableTake
        If the file is in no known format, is broken beyond reading, or is beyond a limit.
    Lacking
        If the file does not say its unit or its rate and it is not given.
    """
    return open_contents(path, ignore_residuals=ignore_residuals).take(units=units, rate=rate)
