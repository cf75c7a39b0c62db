"""What a store gives back: takes, reviews, and the lines of their journals."""

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any, Literal

Action = Literal["do", "undo", "redo"]


@dataclass(frozen=True)
class TakeRecord:
    """A take that the store has seen; ``given_units`` and ``given_rate`` are what it lacked."""

    sha256: str
    name: str
    path: Path | None
    n_frames: int
    rate: float
    given_units: str | None
    given_rate: float | None
    first_seen: datetime
    last_seen: datetime


@dataclass(frozen=True)
class ReviewRecord:
    """One operator's review of one take, without its journal."""

    id: int
    take: str
    operator: str
    purpose: str
    status: str
    created: datetime


@dataclass(frozen=True)
class Entry:
    """A line of a journal: ``command`` belongs to ``"do"`` alone, ``token`` to the call."""

    seq: int
    action: Action
    command: Mapping[str, Any] | None
    operator: str
    at: datetime
    token: str | None = None
