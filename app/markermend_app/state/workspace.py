"""What all pages of one server share: takes that were opened, and the store of reviews."""

import logging
import threading
from collections import OrderedDict
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, wait
from dataclasses import dataclass, field, replace
from functools import cached_property
from hashlib import sha256
from pathlib import Path
from typing import TypeVar

from markermend import body, detection, io
from markermend.errors import BadInput, StoreError
from markermend.model import Finding, Take
from markermend.repairing import REPAIRS
from markermend.review.session import ReviewSession
from markermend.review.store import Store
from markermend.review.triage import Triage, learn
from markermend_app.state import computing, keeping
from markermend_app.state.archive import Archive
from markermend_app.state.memory import give_back
from markermend_app.state.places import Takes, extensions, within_reach
from markermend_app.state.reach import Reach
from markermend_app.state.skeletons import Bone, by_labels
from markermend_app.state.worker import Worker

T = TypeVar("T")
Progress = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class Opened:
    """A take that is ready for review: what was found in it, and its body.

    ``complete`` is false while only its gaps are known; see `Workspace.search`.
    """

    take: Take
    findings: tuple[Finding, ...]
    mesh: body.Body
    complete: bool = field(default=True, kw_only=True)

    @cached_property
    def skeleton(self) -> tuple[str, tuple[Bone, ...]] | None:
        """The set of markers that the labels name, and its bones."""
        return by_labels(self.take)

    @property
    def name(self) -> str:
        """File name, or the label of a take made from arrays."""
        return self.take.source.path.name if self.take.source else "take"


LOG = logging.getLogger(__name__)

PATIENCE_S = 0.1
"""How often a search asks whether it is still wanted."""
MOST_LEARNT = 200
MOST_DROPPED_BYTES = 512_000_000


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
    methods
        Names of the repairs that are offered; by default all.
    ahead
        How many findings are compared while the operator looks at another.
    patience_s
        How long a finding waits for the first of its repairs, so that both are drawn at once.
    reach
        The folder that can be reached from a page; by default all of the disk.
    most_upload
        How large a file may be that is dropped on a page, bytes.
    worker
        Computes for the pages; by default a process that is started with the first take.
    archive
        What a batch found in the folder that the files lie in, or None.
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
        methods: tuple[str, ...] | None = None,
        ahead: int = 3,
        patience_s: float = 0.05,
        reach: Reach | None = None,
        most_upload: int = MOST_DROPPED_BYTES,
        worker: Worker | None = None,
        archive: Archive | None = None,
    ) -> None:
        self.store, self.paths, self.detector = store, paths, detector
        self.methods, self.ahead = REPAIRS.names() if methods is None else methods, ahead
        self.patience_s = patience_s
        self.units, self.rate, self.ignore_residuals = units, rate, ignore_residuals
        self.reach, self.most_upload, self.archive = reach, most_upload, archive
        self.worker = Worker() if worker is None else worker
        self._lock, self._searching = threading.Lock(), threading.Lock()
        self._kept: OrderedDict[tuple[object, ...], Opened] = OrderedDict()

    def find(self, given: str | Path) -> Path:
        """Give the file that a path from a page means.

        Raises
        ------
        BadInput
            If it may not be reached from there.
        """
        if self.reach is not None:
            return self.reach.inside(given)
        try:
            return Path(given).expanduser()
        except RuntimeError:
            raise BadInput(f"{given} names nobody's folder; give the path in full.") from None

    def open(
        self,
        path: Path,
        units: str | None = None,
        rate: float | None = None,
        progress: Progress = lambda _: None,
    ) -> Opened:
        """Read a take; a second time it is there at once.

        Of what is in it, the gaps are known, and everything if it was looked for before.

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
            key = (path, *given, _stamp(path))
            if key not in self._kept:
                take = io.read(
                    path, units=given[0], rate=given[1], ignore_residuals=self.ignore_residuals
                )
                found = self._found_before(take)
                gaps = detection.gaps(take) if found is None else found
                progress("Finding the body")
                mesh = body.infer(take)
                self._kept[key] = Opened(take, gaps, mesh, complete=found is not None)
                while len(self._kept) > self.KEPT:
                    self._kept.popitem(last=False)
                give_back()
            self._kept.move_to_end(key)
            return self._kept[key]

    def search(self, opened: Opened, wanted: Callable[[], bool] = lambda: True) -> Opened:
        """Find everything that is in a take, in a process that ends with it.

        Parameters
        ----------
        opened
            A take as it was opened.
        wanted
            Asked now and then; once it says no, the search is given up and nothing more is known.

        Raises
        ------
        MarkerMendError
            If the detector fails, or its process ends.
        """
        with self._searching:
            opened = self._latest(opened)
            if opened.complete or not wanted():
                return opened
            path = self.worker.lend(opened.take)
            found = _apart(wanted, lambda apart: apart.call(computing.found, path, self.detector))
            if found is None:
                return opened
            done = replace(opened, findings=found, complete=True)
            for key, known in list(self._kept.items()):
                if known is opened:
                    self._kept[key] = done
            place = self._place(opened.take)
            if place is not None:
                try:
                    keeping.keep(place, found)
                except OSError as error:
                    LOG.warning("What was found is not kept in %s: %s", place, error)
            return done

    def slow_reach(
        self, take: Take, wanted: Callable[[], bool] = lambda: True
    ) -> tuple[detection.Reach, ...] | None:
        """Tabulate how small a slow change may be and still be found; None once it is not wanted.

        Raises
        ------
        MarkerMendError
            If another detector is used, which cannot say so, or the process that computes ends.
        """
        if self.detector != detection.DEFAULT:
            raise BadInput(
                f"How small a slow change may be is known of the detector {detection.DEFAULT}, not "
                f"of {self.detector}; start without --detector."
            )
        with self._searching:
            path = self.worker.lend(take)
            return _apart(wanted, lambda apart: apart.call(computing.slow_reach, path))

    def _latest(self, opened: Opened) -> Opened:
        """Give what is known of a take by now, if another page has looked meanwhile."""
        known = (o for o in self._kept.values() if o.take is opened.take)
        return opened if opened.complete else next(known, opened)

    def _found_before(self, take: Take) -> tuple[Finding, ...] | None:
        place = self._place(take)
        return None if place is None else keeping.kept(place)

    def _place(self, take: Take) -> Path | None:
        """Give where the findings of a take are kept; nowhere beside a store that is no file."""
        folder = Path(self.store.where).parent
        if take.source is None or not folder.is_dir():
            return None
        settings = (take.units, take.rate, take.source.units, self.ignore_residuals)
        return keeping.place(
            folder / "findings", take.content_hash, detector=self.detector, settings=settings
        )

    def begin(
        self, opened: Opened, operator: str | None = None
    ) -> tuple[ReviewSession, tuple[str, ...]]:
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
        return ReviewSession.open(self.store, take, operator), tuple(told)

    def learnt(self, opened: Opened, operator: str | None = None) -> Triage:
        """Learn from the operator's reviews of other takes; of this one, nothing.

        So the order of a queue does not change while somebody works in it.
        """
        reviews = []
        for record in self.store.reviews()[-MOST_LEARNT:]:
            if record.take == opened.take.content_hash or record.purpose != "review":
                continue
            if operator is not None and record.operator != operator:
                continue
            try:
                reviews.append(ReviewSession(self.store, record).review)
            except StoreError:
                continue  # a newer version wrote it: nothing can be learnt from what is not read
        return learn(reviews)

    def takes(self, here: Path | None, operator: str) -> Takes:
        """List what an operator can open, seen from the folder of `here`."""
        shows = (lambda _: True) if self.reach is None else self.reach.holds
        return within_reach(self.store, self.paths, shows, here, operator)

    def too_large(self, name: str, n_bytes: int) -> BadInput:
        """Say that a dropped file is too large."""
        way = (
            "name it when starting: markermend review PATH"
            if self.reach is None
            else "let it be copied into the archive"
        )
        most = f"{self.most_upload / 1e6:.3g} MB"
        return BadInput(
            f"{name[:120]} has {n_bytes / 1e6:.3g} MB, and at most {most} can be dropped; {way}."
        )

    def keep(self, name: str, data: bytes) -> Path:
        """Keep a file that came from the browser: beside the store, or in the archive.

        Raises
        ------
        BadInput
            If it cannot be a take by its name or size, or there is nowhere to keep it.
        """
        plain = Path(name.replace("\\", "/")).name
        known = extensions()
        if Path(plain).suffix.lower() not in known or not plain.isprintable():
            raise BadInput(f"{plain!r} is no take; drop a file that ends in {', '.join(known)}.")
        if len(data) > self.most_upload:
            raise self.too_large(plain, len(data))
        around = self.store.folder if self.reach is None else self.reach.root
        folder = around / "dropped" / sha256(data).hexdigest()[:12]
        try:
            if self.reach is not None:
                self.reach.inside(folder / plain)  # a link may stand there
            folder.mkdir(parents=True, exist_ok=True)
            (folder / plain).write_bytes(data)
        except OSError as error:
            raise BadInput(
                f"{plain} cannot be kept in {folder} ({error.strerror}); name it when starting: "
                "markermend review PATH."
            ) from None
        return folder / plain


def _apart(wanted: Callable[[], bool], ask: Callable[[Worker], T]) -> T | None:
    """Ask it of a process of its own: what a detector needs of memory ends with it."""
    worker = Worker()
    with ThreadPoolExecutor(1) as waits:
        try:
            result = waits.submit(ask, worker)
            while wait([result], timeout=PATIENCE_S).not_done:
                if not wanted():
                    return None
            return result.result()
        finally:
            worker.end()


def _stamp(path: Path) -> tuple[int, int] | None:
    try:
        found = path.stat()
    except (OSError, ValueError):  # there is none, or there cannot be one of that name
        return None
    return found.st_mtime_ns, found.st_size
