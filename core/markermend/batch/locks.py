"""One batch at a time on an archive and on a folder of results.

The operating system holds the locks and lets go of them when the process ends, however it ends.
"""

import getpass
import hashlib
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from filelock import FileLock, Timeout

from markermend.errors import BadInput, CannotWrite

MARK = ".markermend-batch.lock"
"""Stands in a folder of results; what else is in there is a batch's own."""


@contextmanager
def alone(folder: Path, out: Path | None) -> Iterator[None]:
    """Be the only batch on an archive, and in a folder of results, while the block runs.

    Raises
    ------
    BadInput
        If another batch is at work there.
    CannotWrite
        If the lock cannot be made.
    """
    with ExitStack() as held:
        _take(held, _lock_of(folder), folder)
        if out is not None:
            _take(held, out / MARK, out)
        yield


def _lock_of(folder: Path) -> Path:
    # Archives may be read-only, so their locks lie in the machine's own temporary folder.
    digest = hashlib.sha256(str(folder).encode("utf-8", "surrogateescape")).hexdigest()[:16]
    return Path(tempfile.gettempdir()) / f"markermend-{_user()}-{digest}.lock"


def _user() -> str:
    try:
        return "".join(c for c in getpass.getuser() if c.isalnum())
    except (OSError, KeyError, ImportError):  # an account without a name
        return ""


def _take(held: ExitStack, path: Path, what: Path) -> None:
    try:
        held.enter_context(FileLock(path, timeout=0))
    except Timeout:
        raise BadInput(
            f"Another batch is at work on {what}; wait until it has ended, or stop it."
        ) from None
    except OSError as error:
        raise CannotWrite(
            f"The lock {path} cannot be made: {error.strerror or error}; choose another place."
        ) from None
