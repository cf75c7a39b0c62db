"""What a subject is given, and what it gives back."""

import os
import time
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


@dataclass(frozen=True)
class Budget:
    """How much a subject may do.

    Attributes
    ----------
    short
        Whether this is the version that runs with the fast tests.
    seconds
        Wall-clock seconds after which a subject stops drawing further cases; what it has drawn
        by then is what its row reports.
    seed
        Of everything random.
    """

    short: bool = False
    seconds: float = float("inf")
    seed: int = 20
    began: float = field(default_factory=time.monotonic)

    def of(self, long: int, short: int) -> int:
        """Give the number of cases of this version."""
        return short if self.short else long

    @property
    def left(self) -> float:
        """Seconds left, never negative."""
        return max(0.0, self.began + self.seconds - time.monotonic())

    @property
    def spent(self) -> bool:
        """Whether the time is over."""
        return self.left <= 0.0

    def share(self, part: float) -> "Budget":
        """Give a budget of a part of the time that is left, beginning now."""
        return Budget(self.short, self.left * part, self.seed)


@dataclass(frozen=True)
class Outcome:
    """One row of the table.

    Attributes
    ----------
    subject
        The promise in a few words.
    tried, failed, lost
        Cases; how many of them broke the promise; and how many of those destroyed or lost what
        somebody had recorded or decided.
    seconds
        Wall-clock seconds.
    note
        What else to know: the first fault, or how far a version stopped by its time came.
    """

    subject: str
    tried: int
    failed: int = 0
    lost: int = 0
    seconds: float = 0.0
    note: str = ""


class Tally:
    """Counts cases while they run, and keeps what is said of the first few that fail."""

    def __init__(self, subject: str, planned: int | None = None) -> None:
        self.subject, self.planned = subject, planned
        self.tried = self.failed = self.lost = 0
        self.faults: list[str] = []
        self.remarks: list[str] = []
        self._began = time.monotonic()

    def case(self, fault: str = "", *, lost: bool = False) -> None:
        """Count a case; a `fault` says how it failed."""
        self.tried += 1
        if fault:
            self.failed += 1
            self.lost += lost
            self.faults.append(fault)

    def outcome(self, note: str = "") -> Outcome:
        """Give the row; a subject that tried nothing has failed."""
        notes = [note, *self.remarks] if note else list(self.remarks)
        if self.planned is not None and self.tried < self.planned:
            notes.append(f"time was over before the {self.planned} planned")
        elif self.tried == 0:  # and nothing says why: it is no proof of anything
            self.case("nothing was tried")
        notes += [f"FAULT {fault}" for fault in self.faults[:3]]
        seconds = time.monotonic() - self._began
        return Outcome(self.subject, self.tried, self.failed, self.lost, seconds, "; ".join(notes))


def recordings() -> list[Path]:
    """Give the real takes beside the checkout, public and odd; none where they are not at hand."""
    folder = ROOT.parent / "shared" / "data"
    found = [p for part in ("public", "odd") for p in (folder / part).glob("*") if p.is_file()]
    return sorted(p for p in found if p.suffix.lower() != ".md")


def public() -> list[Path]:
    """Give the public takes alone."""
    return [path for path in recordings() if path.parent.name == "public"]


def child_environment() -> dict[str, str]:
    """Give the environment of a child: one thread in every numerical library."""
    names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
    return os.environ | dict.fromkeys(names, "1")
