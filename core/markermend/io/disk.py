"""Put bytes on the disk whole or not at all."""

import contextlib
import errno
import os
import secrets
import shutil
from collections.abc import Callable
from pathlib import Path

from markermend.errors import CannotWrite
from markermend.io.folder import is_packed, pack_folder, unpack

_NO_SUCH_SERVICE = (errno.EINVAL, errno.ENOTSUP)
"""What file systems answer that cannot confirm a name; there is nothing to wait for."""


def write_whole(
    path: Path,
    data: bytes | bytearray,
    *,
    overwrite: bool,
    check: Callable[[Path], None] = lambda written: None,
) -> None:
    """Write a file, or a packed folder, under a temporary name, check it, then rename it.

    Whatever interrupts this leaves the old file or the new one, whole.

    Parameters
    ----------
    path, data
        The target and its bytes.
    overwrite
        Whether an existing target is replaced.
    check
        Called with the file as it is on the disk, before it gets its name; raises to refuse.

    Raises
    ------
    CannotWrite
        If the target exists and must not be replaced, or the disk refuses.
    """
    refuse_existing(path, overwrite=overwrite)
    temporary = path.with_name(f".{secrets.token_hex(8)}.part")
    try:
        if is_packed(data):
            temporary.mkdir()
            for name, content in unpack(data):
                _write_synced(temporary / name, content)
        else:
            _write_synced(temporary, data)
        check(temporary)
        if path.exists():
            temporary.chmod(path.stat().st_mode)
        temporary.replace(path)
    except OSError as error:
        raise CannotWrite(
            f"{path} cannot be written: {error.strerror or error}; choose another place."
        ) from None
    finally:
        with contextlib.suppress(OSError):
            if temporary.is_dir():
                shutil.rmtree(temporary)
            temporary.unlink(missing_ok=True)
    try:
        _sync_folder(path.parent)
    except OSError as error:
        raise CannotWrite(
            f"{path} is written, but the disk does not confirm its name "
            f"({error.strerror or error}); look after the disk, then write it once more."
        ) from None


def _write_synced(path: Path, data: bytes | bytearray) -> None:
    with path.open("xb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())


def load(path: Path) -> bytes:
    """Read all bytes of a file, or pack a folder of files."""
    return pack_folder(path) if path.is_dir() else path.read_bytes()


def refuse_existing(path: Path, *, overwrite: bool) -> None:
    """Refuse a target that is no ordinary file, or that exists and must not be replaced."""
    try:
        exists = path.exists()
    except OSError as error:  # a name that is too long
        raise CannotWrite(
            f"{path} cannot be written: {error.strerror or error}; choose another name."
        ) from None
    if path.is_dir():
        raise CannotWrite(f"{path} is an existing folder; choose another name.")
    if exists and not path.is_file():  # a device would be replaced by a file
        raise CannotWrite(f"{path} is no ordinary file; choose another name.")
    if exists and not overwrite:
        raise CannotWrite(f"{path} exists; choose another name or allow to overwrite it.")


def _sync_folder(folder: Path) -> None:
    if os.name != "posix":
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    except OSError as error:
        if error.errno not in _NO_SUCH_SERVICE:
            raise
    finally:
        os.close(handle)
