"""Text for a terminal: what a file says of itself cannot steer the terminal it is shown on."""

import os
import sys
from typing import TextIO


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


def say(text: object, *, file: TextIO | None = None) -> None:
    """Print one line, escaped."""
    print(plain(text), file=file)


def show_anything() -> None:
    """Escape what the terminal's own character set does not have, where it would fail."""
    for stream in (sys.stdout, sys.stderr):
        reconfigure = getattr(stream, "reconfigure", None)
        if reconfigure is not None:
            reconfigure(errors="backslashreplace")


def reader_is_gone() -> bool:
    """Whether the other end of stdout or stderr was closed; if so, nothing more goes there."""
    gone = False
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except BrokenPipeError:
            gone = True
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
    return gone
