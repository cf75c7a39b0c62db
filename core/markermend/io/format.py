"""What a file format is to the rest of the project, and how one is found."""

import importlib
import pkgutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from importlib.metadata import entry_points
from pathlib import Path

from markermend.errors import MarkerMendError, UnreadableTake
from markermend.io import formats
from markermend.io.contents import Contents
from markermend.model import BoolArray, FloatArray, Take

_HEAD = 65536
GROUP = "markermend.formats"
"""Entry-point group by which other distributions add a format."""


@dataclass(frozen=True)
class Reading:
    """How a file is to be read.

    Attributes
    ----------
    ignore_residuals
        In C3D files, take every sample as seen whatever its residual says.
    second_opinion
        Let ezc3d read a C3D file as well; an export that only compares does without.
    """

    ignore_residuals: bool = False
    second_opinion: bool = True


@dataclass(frozen=True, eq=False)
class Patch:
    """What a format makes of wanted positions.

    Attributes
    ----------
    data
        The new file.
    resolution
        Largest step between two numbers that the file can hold there, in the file's own unit.
    """

    data: bytes | bytearray
    resolution: float


Patcher = Callable[[bytes, Reading, FloatArray, BoolArray], Patch]
"""``(data, reading, positions, changed)``: changes samples in bytes and nothing else.

``positions`` are (n_frames, n_points, n_dims) in the file's own unit, ``changed`` is
(n_frames, n_points); raises CannotWrite where the format cannot hold them.
"""


@dataclass(frozen=True)
class Patching:
    """How the bytes of a file are changed sample by sample, and how that is checked.

    Attributes
    ----------
    positions
        ``(data, reading)``: the samples in the bytes, (n_frames, n_points, n_dims) in the file's
        own unit, NaN = not seen; the same as `Format.open` gives.
    patch
        Changes samples and nothing else.
    compare
        ``(old, new, reading)``: (n_frames, n_points), where two files differ bit for bit; None
        where they differ in anything that is no sample.
    """

    positions: Callable[[bytes, Reading], FloatArray]
    patch: Patcher
    compare: Callable[[bytes, bytes, Reading], BoolArray | None]


@dataclass(frozen=True)
class Format:
    """One file format.

    Attributes
    ----------
    name, title
        In records, and for people.
    extensions
        Lower case, with the dot.
    recognises
        ``(path, head)``: whether the content is of this format; head are the first bytes, none
        for a folder.
    open
        Read a file.
    patching
        Or None where files are always written anew.
    write
        The bytes of a take written anew, or None where the format cannot be.
    generic
        Whether it is only tried where nothing more special recognises a file.
    """

    name: str
    title: str
    extensions: tuple[str, ...]
    recognises: Callable[[Path, bytes], bool]
    open: Callable[[Path, Reading], Contents]
    patching: Patching | None = None
    write: Callable[[Take], bytes] | None = None
    generic: bool = False


@cache
def all_formats() -> tuple[Format, ...]:
    """Import and return every format, our own and those of other distributions."""
    return tuple(sorted(_found(), key=lambda format_: format_.generic))


def _found() -> Iterator[Format]:
    own = sorted(module.name for module in pkgutil.iter_modules(formats.__path__))
    for name in own:
        found = importlib.import_module(f"{formats.__name__}.{name}").FORMAT
        yield _checked(found, name)
    for entry in entry_points(group=GROUP):
        if entry.name not in own:
            yield _checked(entry.load(), entry.name)


def _checked(found: object, name: str) -> Format:
    if not isinstance(found, Format) or found.name != name:
        raise MarkerMendError(f"The format {name!r} is no Format of that name.")
    return found


def format_of(path: Path) -> Format:
    """Choose the format of a file by its content, else by its extension.

    Raises
    ------
    UnreadableTake
        If there is no such file, or nothing knows it.
    """
    try:
        head = b""
        if path.exists() and not (path.is_file() or path.is_dir()):
            raise UnreadableTake(f"{path} is no ordinary file; copy the recording into one.")
        if not path.is_dir():
            with path.open("rb") as file:
                head = file.read(_HEAD)
    except OSError as error:
        raise UnreadableTake(f"{path} cannot be read: {error.strerror or error}.") from None
    known = all_formats()
    extension = path.suffix.lower()
    by_name = [format_ for format_ in known if extension in format_.extensions]
    by_content = [format_ for format_ in known if format_.recognises(path, head)]
    by_name.sort(key=lambda format_: not format_.generic)  # a special one would have known it
    for format_ in (*(f for f in by_content if f in by_name), *by_content, *by_name):
        return format_
    raise UnreadableTake(
        f"{path.name} is in no format that is known; known are "
        f"{', '.join(format_.title for format_ in known)}."
    )


def format_for(path: Path) -> Format | None:
    """Choose the format to write anew by the extension of the target."""
    extension = path.suffix.lower()
    return next((f for f in all_formats() if extension in f.extensions and f.write), None)
