"""Where takes lie that can be opened: the work list, the folder, what was open before."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from markermend.io.format import all_formats
from markermend.review.requests import requests
from markermend.review.store import Store

MOST_RECENT = 12


@dataclass(frozen=True)
class Place:
    """A take that can be opened: where it lies, and why it is listed, such as when it was open."""

    path: Path
    why: str = ""


@dataclass(frozen=True)
class Takes:
    """What the dialog for opening lists.

    Attributes
    ----------
    given
        What was named on the command line, folders resolved: the work list.
    asked
        Those of which somebody asks this operator for a second review, the oldest request first.
    beside
        Other takes in the folder of the one at hand.
    recent
        Those opened before, the last first.
    """

    given: tuple[Place, ...]
    asked: tuple[Place, ...]
    beside: tuple[Place, ...]
    recent: tuple[Place, ...]


def within_reach(
    store: Store,
    work: Sequence[Path],
    shows: Callable[[Path], bool],
    here: Path | None,
    operator: str,
) -> Takes:
    """List what an operator can open.

    Parameters
    ----------
    store
        What is known of takes.
    work
        The work list.
    shows
        Whether a file may be shown at all.
    here
        The take at hand, whose folder is listed.
    operator
        Who asks.
    """

    def there(path: Path | None) -> bool:
        return path is not None and shows(path) and path.exists()

    beside = () if here is None else takes_in(here.parent)
    recent = [record for record in store.takes(4 * MOST_RECENT) if there(record.path)]
    asked: dict[Path, str] = {}
    for request in requests(store, operator=operator):
        record = store.take(request.take)
        if record is not None and record.path is not None and there(record.path):
            why = f"{request.asked_by} asks: {request.note}".removesuffix(": ")
            asked.setdefault(record.path, why)
    return Takes(
        given=tuple(Place(path) for path in work),
        asked=tuple(Place(path, why) for path, why in asked.items()),
        beside=tuple(Place(path) for path in beside if path not in set(work) and shows(path)),
        recent=tuple(
            Place(record.path, f"{record.last_seen.astimezone():%Y-%m-%d %H:%M}")
            for record in recent[:MOST_RECENT]
            if record.path is not None
        ),
    )


def extensions() -> tuple[str, ...]:
    """Give the endings of the files that can be read."""
    return tuple(dict.fromkeys(ext.lower() for f in all_formats() for ext in f.extensions))


def takes_in(folder: Path) -> tuple[Path, ...]:
    """Give the takes in a folder, by name; folders in it are not entered."""
    known = extensions()
    try:
        found = [p for p in folder.iterdir() if p.suffix.lower() in known and p.is_file()]
    except OSError:
        return ()
    return tuple(sorted(found, key=lambda p: p.name.lower()))


def work_list(paths: Iterable[Path]) -> tuple[Path, ...]:
    """Put the takes of each folder in its place; a folder that is itself a take stays.

    The takes of a folder stand in the order of their names; folders in it are not entered.
    """
    found: list[Path] = []
    for path in paths:
        found += (takes_in(path) if path.is_dir() else ()) or (path,)
    return tuple(dict.fromkeys(found))
