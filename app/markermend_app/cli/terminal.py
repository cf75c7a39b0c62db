"""Text for a terminal: what a file says of itself cannot steer the terminal it is shown on."""

import os
import sys
from typing import TextIO


class ReaderGone(Exception):
    """The other end of stdout or stderr was closed, as by ``markermend info take | head -1``."""


def plain(text: object) -> str:
    r"""Escape what does not print: control and formatting characters, e.g. ``\x1b``.

    Labels and file names come from anywhere; shown as they are, they could move the cursor, hide a
    line, or turn the direction of writing.
    """
    return "".join(
        char if char.isprintable() else char.encode("unicode_escape").decode("ascii")
        for char in str(text)
    )


def sentence(text: object) -> str:
    """Bring a message onto one line."""
    return " ".join(str(text).split())


def put(text: str, *, file: TextIO | None = None) -> None:
    """Print text as it is.

    Raises
    ------
    ReaderGone
        If nobody reads it any more.
    """
    try:
        (file or sys.stdout).write(text)
    except BrokenPipeError:
        raise ReaderGone from None


def say(text: object, *, file: TextIO | None = None) -> None:
    """Print one line, escaped; raises as `put` does."""
    put(f"{plain(text)}\n", file=file)


def finish() -> None:
    """Hand on what is still held back; raises as `put` does."""
    try:
        sys.stdout.flush()
    except BrokenPipeError:
        raise ReaderGone from None


def hush() -> None:
    """Send what is still held back nowhere, so that the end of the process does not fail on it."""
    with open(os.devnull, "wb") as nowhere:  # noqa: PTH123  a device, for its number
        for stream in (sys.stdout, sys.stderr):
            os.dup2(nowhere.fileno(), stream.fileno())


def show_anything() -> None:
    """Escape what the terminal's own character set does not have, where it would fail."""
    for stream in (sys.stdout, sys.stderr):
        reconfigure = getattr(stream, "reconfigure", None)
        if reconfigure is not None:
            reconfigure(errors="backslashreplace")
