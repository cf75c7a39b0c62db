"""The archive that a server was started on, where a batch has looked at it: the work list."""

from collections.abc import Sequence
from pathlib import Path

from markermend.batch.overview import Overview, overview
from markermend.review.store import Store


class Archive:
    """A folder with what a batch found in its takes.

    Parameters
    ----------
    store
        Where that is kept.
    seen
        The archive as it is kept now.
    """

    def __init__(self, store: Store, seen: Overview) -> None:
        self.store, self.seen = store, seen

    def look(self) -> None:
        """See what another batch has found since."""
        self.seen = overview(self.store, self.seen.folder) or self.seen

    def path(self, name: str) -> Path:
        """Give the file of a take."""
        return self.seen.folder / name

    @property
    def paths(self) -> tuple[Path, ...]:
        """The takes that are still there, those with most expected damage first."""
        found = (self.path(line.name) for line in self.seen.worst_first)
        return tuple(path for path in found if path.exists())

    @property
    def units(self) -> str | None:
        """The unit that was given for files that say none."""
        return self.seen.settings.get("units")

    @property
    def rate(self) -> float | None:
        """The rate that was given for files that say none."""
        return self.seen.settings.get("rate")


def find_archive(store: Store, paths: Sequence[Path]) -> Archive | None:
    """Give the archive, if it is one folder that is named and a batch has looked at it."""
    if len(paths) != 1 or not paths[0].is_dir():
        return None
    seen = overview(store, paths[0])
    if seen is None or not seen.worst_first:
        return None
    archive = Archive(store, seen)
    return archive if archive.paths else None
