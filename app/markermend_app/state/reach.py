"""What of the disk can be reached from a page of a lab's server: one folder and what is in it."""

import os
from pathlib import Path, PureWindowsPath

from markermend.errors import BadInput

LONGEST = 1024
"""Characters of a path; file systems take about as many."""


class Reach:
    """One folder; a path leads into it, or is refused.

    Parameters
    ----------
    folder
        The archive.

    Raises
    ------
    BadInput
        If it is no folder.
    """

    def __init__(self, folder: Path) -> None:
        if not folder.is_dir():
            raise BadInput(f"There is no folder {folder}; give the folder of the archive.")
        self.root = folder.resolve(strict=True)

    def inside(self, given: str | Path) -> Path:
        """Give where a path leads, links followed; a relative one begins in the folder.

        Whatever leads out gets the same answer, whether there is something or not.

        Raises
        ------
        BadInput
            If it does not end in the folder.
        """
        text = str(given)
        if not _is_plain(text):
            raise _refused(text)
        try:
            path = (self.root / text).resolve()
        except (OSError, RuntimeError, ValueError):  # a loop of links, a name of no file system
            raise _refused(text) from None
        if not path.is_relative_to(self.root):
            raise _refused(text)
        return path

    def holds(self, path: Path) -> bool:
        """Say whether a path leads into the folder."""
        try:
            self.inside(path)
        except BadInput:
            return False
        return True


def _is_plain(text: str) -> bool:
    """Say whether a path is written as this system writes paths, and means a file.

    A drive, a share, a device or a stream of Windows means the same refusal everywhere.
    """
    if not text.isprintable() or text.startswith("~") or len(text) > LONGEST:
        return False
    windows = PureWindowsPath(text)
    if os.name == "nt":
        return ":" not in text.removeprefix(windows.drive) and not text.startswith("\\\\")
    return "\\" not in text and not windows.drive


def _refused(text: str) -> BadInput:
    shown = text if text.isprintable() and len(text) <= 120 else repr(text)[:120]
    return BadInput(
        f"{shown} does not lie in the archive that this server shows; choose a take from the list."
    )
