"""What a trainee's repairs are worth: their true errors beside those of other methods."""

from collections.abc import Mapping, Sequence

import numpy as np

from markermend.errors import CannotRepair
from markermend.model import FloatArray, Kind, Span, Take
from markermend.repairing import REPAIRS, Wish
from markermend.repairing.checks import Inspector
from markermend.repairing.compare import compare_iter, concluded
from markermend.repairing.problem import Repair
from markermend.repairing.run import pose
from markermend.train.exercise import Answer, Exercise
from markermend.train.marks import Repaired

FAST: tuple[str, ...] = ("auto", "linear", "pchip", "rigid", "swap", "unslow", "unstep")
"""The methods that a trainee's repair is compared with: the quick ones that win somewhere."""


def distance(one: Take, other: Take, marker: str, span: Span) -> FloatArray:
    """Give the distance in mm of a marker in two versions; NaN where one does not have it."""
    m, frames = one.index(marker), span.frames
    off: FloatArray = np.linalg.norm(one.positions[frames, m] - other.positions[frames, m], axis=1)
    return off


def mean_or_none(values: FloatArray) -> float | None:
    """Give the mean of what is known, or None where nothing is, or data was given up."""
    return float(values.mean()) if len(values) and np.isfinite(values).all() else None


def worth(
    exercise: Exercise,
    repaired: Take,
    done: Repair,
    marker: str,
    answer: Answer | None,
    methods: Sequence[str],
) -> Repaired:
    """Judge one repair of one marker.

    Parameters
    ----------
    exercise, repaired
        The exercise, and the take as the trainee gives it back.
    done, marker
        The repair, and which of its markers is judged.
    answer
        The artefact that was meant, or None where nothing was wrong.
    methods
        Names of the repairs to compare with on the true span; with none, no detector runs either.
    """
    span = done.span if answer is None else _hull(done.span, answer.span)
    known = np.isfinite(exercise.clean.positions[span.frames, exercise.take.index(marker), 0])
    error = mean_or_none(distance(repaired, exercise.clean, marker, span)[known])
    if not methods:
        return Repaired(done.method, error)
    new = _new_artefacts(exercise, repaired, marker, done.span)
    if answer is None or not np.isfinite(answer.values).all():
        return Repaired(done.method, error, new_artefacts=new)
    errors, recommended = _others(exercise, answer, len(span), methods)
    best = min(errors, key=errors.__getitem__, default="")
    return Repaired(
        done.method,
        error,
        best,
        errors.get(best),
        recommended,
        errors.get(recommended),
        new,
    )


def _hull(one: Span, other: Span) -> Span:
    return Span(min(one.start, other.start), max(one.stop, other.stop))


def _others(
    exercise: Exercise, answer: Answer, n_frames: int, methods: Sequence[str]
) -> tuple[Mapping[str, float], str]:
    """Give the errors of other methods, placed perfectly, over the same frames."""
    truth = answer.truth
    able = [name for name in methods if _meant(name, truth.kind, truth.partner)]
    masked = [(other.marker, other.span) for other in exercise.answers if other is not answer]
    rows = list(
        compare_iter(
            exercise.take,
            truth.marker,
            truth.span,
            able,
            kind=truth.kind,
            partner=truth.partner,
            masked=masked,
        )
    )
    errors = {
        row.method: float(np.linalg.norm(row.repair.values - answer.values, axis=1).sum())
        / n_frames
        for row in rows
        if row.repair is not None and np.isfinite(row.repair.values).all()
    }
    if not errors:
        return errors, ""
    found = concluded(truth.marker, truth.span, truth.kind, rows, truth.partner)
    return errors, found.recommended


def _meant(name: str, kind: Kind, partner: str | None) -> bool:
    return kind in REPAIRS.get(name).kinds and (name != "swap" or partner is not None)


def _new_artefacts(exercise: Exercise, repaired: Take, marker: str, span: Span) -> tuple[Kind, ...]:
    """Run the default detector around a repair, and leave out what it finds in the truth."""
    m = exercise.take.index(marker)
    after = repaired.positions[span.frames, m]
    true = exercise.clean.positions[span.frames, m]
    if not np.isfinite(after).all() or not np.isfinite(true).all():
        return ()
    masked = [(other.marker, other.span) for other in exercise.answers]
    try:
        inspector = Inspector(pose(exercise.take, Wish(marker, span), masked))
    except CannotRepair:  # nothing around it to look at
        return ()
    usual = inspector.check(true).artefacts
    return tuple(
        found.kind
        for found in inspector.check(after).artefacts
        if not any(found.span.overlaps(other.span) for other in usual)
    )
