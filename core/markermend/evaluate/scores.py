"""How findings compare with the truth: per sample as the paper counts, and per span."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from markermend.evaluate.matching import IOU, Placed, pairs
from markermend.model import Finding, FloatArray, Kind, Span, Take
from markermend.truth import Truth

CLASSES = ("clear", "peak", "noise", "step", "slow")
"""Rows (truth) and columns (findings) of a confusion matrix."""


def confusion(
    take: Take, truths: "Iterable[Called]", findings: "Iterable[Called]"
) -> NDArray[np.int64]:
    """Count the samples of the measured markers by what they are and what they were called.

    A sample is a marker in a frame, of all axes together.  Where findings overlap, the one of the
    earlier stage counts: peak before noise before step before slow.  Gaps count as clear.

    Returns
    -------
    (5, 5): truth by finding, in the order of `CLASSES`.
    """
    true, called = (classes_of(take, items) for items in (truths, findings))
    return cross_table(true, called)


class Called(Placed, Protocol):
    """A span that is said to be of a kind: a finding, a truth."""

    @property
    def kind(self) -> Kind:
        """What it is."""


def classes_of(take: Take, items: Iterable[Called]) -> NDArray[np.intp]:
    """Give the class of every sample of the measured markers, by the rules of `confusion`.

    Returns
    -------
    (n_frames, n_measured) indices into `CLASSES`.
    """
    place = {take.labels[m]: i for i, m in enumerate(take.measured)}
    table = np.zeros((take.n_frames, len(place)), np.intp)
    known = [item for item in items if item.kind in CLASSES]
    for item in sorted(known, key=lambda item: -CLASSES.index(item.kind)):
        table[item.span.frames, place[item.marker]] = CLASSES.index(item.kind)
    return table


def cross_table(one: NDArray[np.intp], other: NDArray[np.intp]) -> NDArray[np.int64]:
    """Count the samples by class in one table and class in another of the same shape."""
    n = len(CLASSES)
    return np.bincount((one * n + other).ravel(), minlength=n * n).reshape(n, n)


@dataclass(frozen=True)
class Rates:
    """Measures of one class, in the paper's words and units (Eq. 31 to 37).

    Attributes
    ----------
    tpr, fnr, fpr, ppv
        Per cent.  ``fpr`` is fp / (tp + fp) as printed in Eq. 33, the false discovery rate.
    f, mcc
        F-score (Eq. 36) and Matthews correlation coefficient (Eq. 37).

    A measure that would be 0 / 0 is None.
    """

    tpr: float | None
    fnr: float | None
    fpr: float | None
    ppv: float | None
    f: float | None
    mcc: float | None

    def to_json(self) -> dict[str, Any]:
        """Give it as a record."""
        return dict(vars(self))


def rates(matrix: FloatArray | NDArray[np.int64], index: int) -> Rates:
    """Measure one class of a confusion matrix against all others."""
    matrix = np.asarray(matrix, np.float64)
    tp = float(matrix[index, index])
    fn = float(matrix[index].sum()) - tp
    fp = float(matrix[:, index].sum()) - tp
    tn = float(matrix.sum()) - tp - fn - fp
    root = float(np.sqrt((tp + fp) * (tp + fn) * (tn + fp) * (tn + fn)))
    return Rates(
        tpr=_ratio(100.0 * tp, tp + fn),
        fnr=_ratio(100.0 * fn, tp + fn),
        fpr=_ratio(100.0 * fp, tp + fp),
        ppv=_ratio(100.0 * tp, tp + fp),
        f=_ratio(tp, tp + 0.5 * (fp + fn)),
        mcc=_ratio(tp * tn - fp * fn, root),
    )


def _ratio(above: float, below: float) -> float | None:
    return above / below if below > 0.0 else None


def standard_errors(
    matrices: Sequence[NDArray[np.int64]], index: int
) -> tuple[float | None, float | None]:
    """Give the standard errors of ``tpr`` and ``fpr`` of one class, in per cent.

    By leaving out one simulation at a time (the jackknife), since samples of one artefact are not
    independent; None for a single simulation, or where a measure is 0 / 0 without one of them.
    """
    n = len(matrices)
    whole = np.sum(matrices, axis=0)
    left = [rates(whole - one, index) for one in matrices] if n > 1 else []
    errors: list[float | None] = []
    for values in ([r.tpr for r in left], [r.fpr for r in left]):
        known = [value for value in values if value is not None]
        complete = n > 1 and len(known) == n
        errors.append(float(np.std(known) * np.sqrt(n - 1)) if complete else None)
    return errors[0], errors[1]


def overall_f(matrix: FloatArray | NDArray[np.int64]) -> float | None:
    """Give the micro-averaged F over all classes, which clear samples dominate: the accuracy."""
    matrix = np.asarray(matrix, np.float64)
    return _ratio(float(np.trace(matrix)), float(matrix.sum()))


def overall_mcc(matrix: FloatArray | NDArray[np.int64]) -> float | None:
    """Give the correlation coefficient of the whole matrix (Gorodkin 2004)."""
    matrix = np.asarray(matrix, np.float64)
    true, called, total = matrix.sum(axis=1), matrix.sum(axis=0), float(matrix.sum())
    above = np.trace(matrix) * total - true @ called
    below = np.sqrt((total**2 - called @ called) * (total**2 - true @ true))
    return _ratio(float(above), float(below))


@dataclass(frozen=True)
class Matches:
    """Spans of one kind.

    Attributes
    ----------
    true, found
        Artefacts put in, and those of them found: marker and kind right, IoU of at least 0.5.
    called, false
        Findings of this kind, and those of them that overlap no artefact on their marker at all.
    """

    true: int
    found: int
    called: int
    false: int


def match(truths: Sequence[Truth], findings: Sequence[Finding]) -> Mapping[str, Matches]:
    """Match findings with truths, one to one, the best overlap first."""
    result = {}
    places: dict[str, list[Span]] = {}
    for truth in truths:
        places.setdefault(truth.marker, []).append(truth.span)
    for kind in CLASSES[1:]:
        wanted = [truth for truth in truths if truth.kind == kind]
        called = [finding for finding in findings if finding.kind == kind]
        hits = pairs(wanted, called, IOU)
        false = sum(
            not any(finding.span.overlaps(span) for span in places.get(finding.marker, ()))
            for finding in called
        )
        result[kind] = Matches(len(wanted), len(hits), len(called), false)
    return result
