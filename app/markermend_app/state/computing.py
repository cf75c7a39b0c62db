"""What the process that computes is asked for; a take is named by the file that it was lent as."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import joblib
import numpy as np

from markermend import detection
from markermend.errors import CannotRepair, MarkerMendError
from markermend.model import Finding, Span, Take
from markermend.repairing import Repair, Wish, repair
from markermend.repairing.compare import Row, compare_iter
from markermend.repairing.run import pose
from markermend.repairing.trust import expected_error

FOLDERS: set[Path] = set()
"""Where takes were lent; they go with the server."""
Masked = Sequence[tuple[str, Span]]


@lru_cache(maxsize=2)
def taken(path: Path) -> Take:
    """Give a take that was lent; its positions stay in the file and are read as they are needed."""
    FOLDERS.add(path.parent)
    take = joblib.load(path, mmap_mode="r")
    assert isinstance(take, Take)
    return take


def rows(path: Path, wish: Wish, masked: Masked, names: Sequence[str]) -> Iterator[Row]:
    """Try methods on pseudo-gaps, one after another; see `compare_iter`."""
    for row in compare_iter(
        taken(path),
        wish.marker,
        wish.span,
        names,
        kind=wish.kind,
        partner=wish.partner,
        masked=masked,
    ):
        yield _light(row)


def _light(row: Row) -> Row:
    """Leave out what explains each new artefact: the table says how many there are."""
    if row.checks is None:
        return row
    found = tuple(replace(f, evidence=None) for f in row.checks.artefacts)
    return replace(row, checks=replace(row.checks, artefacts=found))


def mended(path: Path, wish: Wish, masked: Masked) -> Repair | None:
    """Compute one accepted repair; None where it cannot be, as the export will say."""
    try:
        return repair(
            taken(path),
            wish.marker,
            wish.span,
            wish.method,
            kind=wish.kind,
            partner=wish.partner,
            masked=masked,
            **wish.parameters,
        )
    except CannotRepair:
        return None


def expected(path: Path, wish: Wish, masked: Masked, method: str) -> float:
    """Measure the error to be expected of a method on one wish; NaN where it does not apply."""
    try:
        found = expected_error(pose(taken(path), wish, masked), [method])
    except MarkerMendError:
        return float(np.nan)
    return found[method].expected_mm if method in found else float(np.nan)


def slow_reach(path: Path) -> tuple[detection.Reach, ...]:
    """Tabulate how small a slow change may be and still be found."""
    return detection.smallest_slow_changes(taken(path))


def found(path: Path, detector: str) -> tuple[Finding, ...]:
    """Run a detector on the whole take."""
    return detection.scan(taken(path), detector)
