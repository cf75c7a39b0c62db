"""The option ``--picture FILE.html``: the figures of a command drawn, in one file."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from markermend.errors import BadInput, CannotWrite, MarkerMendError
from markermend_app.cli.review import installed

if TYPE_CHECKING:
    from markermend_app.plots.picture import Picture

NEEDED = ("bokeh", "holoviews", "panel", "pyvista")
"""What pictures import of the extra."""
NEEDS_APP = "--picture needs more packages: install them with pip install 'markermend[app]'."


def picture_argument(parser: argparse.ArgumentParser) -> None:
    """Add the option."""
    parser.add_argument(
        "--picture", type=Path, metavar="FILE.html", help="draw the figures into one HTML file"
    )


def refuse_picture(path: Path | None) -> None:
    """Say what stands in the way of a picture before anything is computed for it.

    Raises
    ------
    MarkerMendError
        If the packages that draw are not installed.
    BadInput, CannotWrite
        If the file is no HTML file, or cannot be made where it is wanted.
    """
    if path is None:
        return
    if not all(map(installed, NEEDED)):
        raise MarkerMendError(NEEDS_APP)
    if path.suffix.lower() not in (".html", ".htm"):
        raise BadInput(f"--picture makes an HTML file; got {path.name!r}, name it FILE.html.")
    if path.is_dir():
        raise CannotWrite(f"{path} is an existing folder; choose another name.")
    if not path.parent.is_dir():
        raise CannotWrite(f"There is no folder {path.parent}; make it, or choose another one.")


def write_picture(path: Path, picture: "Picture") -> None:
    """Write a picture, replacing the file.

    Raises
    ------
    CannotWrite
        If the system does not let it.
    """
    from markermend_app.plots.picture import html

    try:
        # A name may hold half a character, which no UTF-8 can.
        path.write_bytes(html(picture).encode("utf-8", "replace"))
    except OSError as error:
        raise CannotWrite(f"{path} cannot be written: {error.strerror}.") from None
