"""What all pages of one server share: takes that were opened, and the store of reviews."""

import threading
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from markermend import body, detection, io
from markermend.model import Finding, Take
from markermend.review.session import ReviewSession
from markermend.review.store import Store

Progress = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class Opened:
    """A take that is ready for review: what was found in it, and its body."""

    take: Take
    findings: tuple[Finding, ...]
    mesh: body.Body

    @property
    def name(self) -> str:
        """File name, or the label of a take made from arrays."""
        return self.take.source.path.name if self.take.source else "take"


class Workspace:
    """Opens takes once per process and keeps the latest few.

    Parameters
    ----------
    store
        Where reviews are kept.
    paths
        The files to be reviewed, the first one first.
    units, rate
        What the files lack, or None.
    ignore_residuals
        Take every sample of a C3D file as seen, whatever its residual says.
    detector
        Name of the detector.
    """

    KEPT = 3

    def __init__(
        self,
        store: Store,
        paths: tuple[Path, ...],
        *,
        units: str | None = None,
        rate: float | None = None,
        ignore_residuals: bool = False,
        detector: str = detection.DEFAULT,
    ) -> None:
        self.store, self.paths, self.detector = store, paths, detector
        self.units, self.rate, self.ignore_residuals = units, rate, ignore_residuals
        self._lock = threading.Lock()
        self._kept: OrderedDict[tuple[object, ...], Opened] = OrderedDict()

    def open(
        self,
        path: Path,
        units: str | None = None,
        rate: float | None = None,
        progress: Progress = lambda _: None,
    ) -> Opened:
        """Read a take and find what is in it; a second time it is there at once.

        Raises
        ------
        Lacking
            If the file does not say its unit or rate and they were not given.
        MarkerMendError
            If it cannot be read.
        """
        given = (units or self.units, rate or self.rate)
        with self._lock:
            progress("Reading")
            stamp = path.stat() if path.exists() else None
            key = (path, *given, stamp and (stamp.st_mtime_ns, stamp.st_size))
            if key not in self._kept:
                take = io.read(
                    path, units=given[0], rate=given[1], ignore_residuals=self.ignore_residuals
                )
                progress("Looking for artefacts")
                found = detection.scan(take, self.detector)
                progress("Finding the body")
                self._kept[key] = Opened(take, found, body.infer(take))
                while len(self._kept) > self.KEPT:
                    self._kept.popitem(last=False)
            self._kept.move_to_end(key)
            return self._kept[key]

    def begin(self, opened: Opened) -> tuple[ReviewSession, tuple[str, ...]]:
        """Go on with the operator's review of a take, or begin it.

        Returns
        -------
        session
            The review.
        told
            What the operator should know: the file is another than when it was last opened.
        """
        take, told = opened.take, []
        if take.source is not None:
            earlier = self.store.changed_since(take.source.path, take.content_hash)
            if earlier is not None:
                told.append(
                    f"{opened.name} has changed since {earlier.last_seen:%Y-%m-%d}; "
                    "this is a new review, and the earlier one is kept with the earlier content."
                )
        return ReviewSession.open(self.store, take), tuple(told)
