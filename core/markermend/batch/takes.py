"""Which takes lie in a folder, and where what is made of them goes."""

import hashlib
import os
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path, PurePosixPath

from markermend.errors import BadInput
from markermend.io.disk import load
from markermend.io.format import all_formats

FINDINGS = ".findings.json"
_HEAD = 65536
_HOLD_ANYTHING = (".json", ".txt")


def takes_below(folder: Path, without: Path | None = None) -> tuple[str, ...]:
    """Give the takes in a folder and the folders in it, as paths relative to it with ``/``.

    A file counts by its ending; JSON and plain text, which may hold anything, only by their
    content.  A folder that is itself a take (keypoints, one file a frame) is one.  What begins with
    a dot is passed over, and links to folders are not followed.

    Parameters
    ----------
    folder
        The archive.
    without
        A folder that is not entered, such as the one that results go to.

    Raises
    ------
    BadInput
        If the folder cannot be read, or there is nothing in it that could be a take.
    """
    if not folder.is_dir():
        raise BadInput(f"There is no folder {folder}; give the folder of an archive of takes.")
    found = sorted(_walk(folder, folder, without), key=lambda name: (name.casefold(), name))
    if not found:
        endings = ", ".join(dict.fromkeys(e for f in all_formats() for e in f.extensions))
        raise BadInput(f"There are no takes in {folder}; known endings are {endings}.")
    return tuple(found)


def _walk(top: Path, folder: Path, without: Path | None) -> Iterator[str]:
    try:
        entries = sorted(os.scandir(folder), key=lambda entry: entry.name)
    except OSError as error:
        if folder == top:
            raise BadInput(f"{folder} cannot be read: {error.strerror or error}.") from None
        return  # a folder that is closed to us hides its takes, as from every other program
    for entry in entries:
        path = Path(entry.path)
        if entry.name.startswith(".") or (without is not None and path == without):
            continue
        if entry.is_dir(follow_symlinks=False):
            if any(format_.recognises(path, b"") for format_ in all_formats()):
                yield path.relative_to(top).as_posix()
            else:
                yield from _walk(top, path, without)
        elif entry.is_file() and _may_be_take(path):
            yield path.relative_to(top).as_posix()


def _may_be_take(path: Path) -> bool:
    ending = path.suffix.lower()
    if not any(ending in format_.extensions for format_ in all_formats()):
        return False
    if ending not in _HOLD_ANYTHING:
        return True
    try:
        with path.open("rb") as file:
            head = file.read(_HEAD)
    except OSError:
        return True  # it is refused later, with the reason
    return any(format_.recognises(path, head) for format_ in all_formats())


def content_hash(path: Path) -> str | None:
    """Hash what a take is known by, or None where it cannot be read."""
    try:
        if path.is_dir():
            return hashlib.sha256(load(path)).hexdigest()
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except (OSError, BadInput):
        return None


def findings_names(names: Iterable[str]) -> Mapping[str, str]:
    """Give each take the name of its findings file: ``a/walk.c3d`` -> ``a/walk.findings.json``.

    Takes of one folder that differ in nothing but their ending (or in upper and lower case, which
    some disks do not tell apart) keep the ending: ``walk.c3d.findings.json``.
    """
    stems = {name: str(PurePosixPath(name).with_suffix("")) for name in names}
    taken = Counter(stem.casefold() for stem in stems.values())
    taken.update({name.casefold() for name, stem in stems.items() if name != stem})
    return {
        name: f"{stem if taken[stem.casefold()] == 1 else name}{FINDINGS}"
        for name, stem in stems.items()
    }
