"""Hold a trainee's review against the truth of an exercise.

A finding and an artefact are matched one to one, the best overlap first, where they are on the
same marker and their spans agree to at least `LEAST_IOU`, each first widened by `SLACK_S` on both
sides, so that three frames marked around a peak of one are that peak.  The kind plays no part in
it.  What was accepted and matches nothing is an invention if it touches no artefact.
"""

from collections.abc import Callable, Mapping, Sequence
from datetime import datetime
from itertools import pairwise
from statistics import median

import numpy as np

from markermend.evaluate.matching import Placed, pairs
from markermend.evaluate.scores import CLASSES, confusion, rates
from markermend.model import KINDS, Kind, Span, Take
from markermend.repairing import Refusal, Repair
from markermend.review import Review
from markermend.review.decisions import Attribution
from markermend.review.mending import mend
from markermend.train import sentences
from markermend.train.claims import Claim, claims, rejected
from markermend.train.exercise import Exercise
from markermend.train.marks import COLUMNS, ROWS, Grade, KindScore, Mark, is_worse
from markermend.train.worth import FAST, worth

LEAST_IOU = 0.5
SLACK_S = 0.02
PAUSE_S = 300.0
"""A longer time between two decisions is a pause."""


def grade(
    exercise: Exercise,
    review: Review,
    *,
    decided: Mapping[str, Attribution] | None = None,
    methods: Sequence[str] = FAST,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Grade:
    """Grade a trainee's review.

    Parameters
    ----------
    exercise
        The exercise, with its truth.
    review
        What the trainee decided on ``exercise.take``.
    decided
        Finding id -> when it was decided on: `ReviewSession.decided` or `Decisions.decided`.
    methods
        Names of the repairs that the trainee's are compared with; with none this is quick, and
        no detector looks for what the repairs brought in.
    progress
        Called with the repairs judged and their total.

    Raises
    ------
    BadInput
        If two accepted repairs overlap, or a finding lies outside the take.
    UnknownName, BadParameter
        If a marker, a method or a parameter is unknown.
    """
    made = _counted(exercise, claims(review))
    mended = mend(exercise.take, review.accepted())
    repairs = {
        (label, done.span): done
        for done in mended.repairs
        for label in (done.marker, *(label for label, _ in done.also))
    }
    slack = round(SLACK_S * exercise.take.rate)
    matched = pairs(exercise.answers, made, LEAST_IOU, slack)
    marker = _Marker(exercise, mended.repaired, repairs, methods, made, progress)
    marks = [marker.answered(i, j) for i, j in sorted(matched.items())]
    alarms = rejected(review)
    marks += [marker.missed(i, alarms) for i in range(len(exercise.answers)) if i not in matched]
    taken = {matched[i]: i for i in matched}
    marks += [marker.unmatched(j, matched) for j in range(len(made)) if j not in taken]
    marks += [
        Mark("dismissed", c.marker, c.span, c.kind, finding=c.finding, why="It is a false alarm.")
        for c in _counted(exercise, alarms)
        if not any(c.marker == a.marker and c.span.overlaps(a.span) for a in exercise.answers)
    ]
    marks.sort(key=lambda mark: (mark.span, mark.marker, mark.outcome))
    return _summed(exercise, mended.repaired, marks, made, decided, mended.refusals)


def _counted(exercise: Exercise, made: Sequence[Claim]) -> tuple[Claim, ...]:
    """Leave out what lies where nothing is graded and touches no artefact."""

    def on(claim: Claim, items: Sequence[Placed]) -> bool:
        return any(claim.marker == item.marker and claim.span.overlaps(item.span) for item in items)

    return tuple(c for c in made if on(c, exercise.answers) or not on(c, exercise.neutral))


class _Marker:
    """Gives marks; what all of them need is kept here once."""

    def __init__(
        self,
        exercise: Exercise,
        repaired: Take,
        repairs: Mapping[tuple[str, Span], Repair],
        methods: Sequence[str],
        made: Sequence[Claim],
        progress: Callable[[int, int], None],
    ) -> None:
        self.exercise, self.repaired, self.repairs = exercise, repaired, repairs
        self.methods, self.made, self.progress = methods, made, progress
        self._judged = 0

    def answered(self, i: int, j: int) -> Mark:
        """Mark an artefact that was found."""
        answer, claim = self.exercise.answers[i], self.made[j]
        rate, truth = self.exercise.take.rate, answer.truth
        iou = claim.span.iou(truth.span)
        done = self.repairs.get((claim.marker, claim.span))
        worthy = None
        if done is not None:
            worthy = worth(self.exercise, self.repaired, done, claim.marker, answer, self.methods)
        self._moved()
        said = "No repair was possible." if worthy is None else sentences.repair(worthy)
        same = claim.kind == truth.kind
        why = (
            sentences.found(truth, rate, iou, said)
            if same
            else sentences.misnamed(truth, rate, claim.kind, said)
        )
        return Mark(
            "right" if same else "misclassified",
            truth.marker,
            truth.span,
            truth.kind,
            claim.kind,
            claim.span,
            claim.finding,
            iou,
            worthy,
            why,
        )

    def missed(self, i: int, alarms: Sequence[Claim]) -> Mark:
        """Mark an artefact that was not found."""
        answer = self.exercise.answers[i]
        touching = [c for c in self.made if self._on(c, i)]
        alarm = next((c for c in alarms if self._on(c, i)), None)
        why = sentences.missed(
            answer.truth,
            self.exercise.take.rate,
            alarm is not None and not touching,
            touching[0].span if touching else None,
        )
        finding = "" if alarm is None else alarm.finding
        return Mark("missed", answer.marker, answer.span, answer.kind, finding=finding, why=why)

    def unmatched(self, j: int, matched: Mapping[int, int]) -> Mark:
        """Mark a decision that is not the best one on any artefact."""
        claim = self.made[j]
        touched = [i for i in range(len(self.exercise.answers)) if self._on(claim, i)]
        done = self.repairs.get((claim.marker, claim.span))
        worthy = None
        if done is not None:
            worthy = worth(self.exercise, self.repaired, done, claim.marker, None, self.methods)
        self._moved()
        if touched:
            why = sentences.partial(any(i in matched for i in touched))
        else:
            why = sentences.invented(claim.kind, None if worthy is None else worthy.error_mm)
        return Mark(
            "partial" if touched else "invented",
            claim.marker,
            claim.span,
            claim.kind,
            claim.kind,
            claim.span,
            claim.finding,
            None,
            worthy,
            why,
        )

    def _on(self, claim: Claim, i: int) -> bool:
        answer = self.exercise.answers[i]
        return claim.marker == answer.marker and claim.span.overlaps(answer.span)

    def _moved(self) -> None:
        self._judged += 1
        self.progress(self._judged, len(self.made))


def _summed(
    exercise: Exercise,
    repaired: Take,
    marks: Sequence[Mark],
    made: Sequence[Claim],
    decided: Mapping[str, Attribution] | None,
    refusals: Sequence[Refusal],
) -> Grade:
    samples = confusion(exercise.take, exercise.truths, made)
    mccs = {kind: rates(samples, i).mcc for i, kind in enumerate(CLASSES) if kind in KINDS}
    scores = {kind: _score(kind, marks, mccs.get(kind)) for kind in KINDS}
    before, after = _left(exercise, repaired, made)
    right = sum(mark.outcome == "right" for mark in marks)
    inventions = sum(mark.outcome == "invented" for mark in marks)
    worse = is_worse(before, after)
    return Grade(
        level=exercise.level,
        hidden=exercise.hidden,
        marks=tuple(marks),
        kinds={kind: score for kind, score in scores.items() if score.true or score.called},
        matrix=_matrix(marks),
        rmse_before_mm=before,
        rmse_after_mm=after,
        refused=tuple(refusal.reason for refusal in refusals),
        seconds_per_finding=_pace([step.at for step in (decided or {}).values()]),
        verdict=sentences.verdict(right, len(exercise.answers), inventions, before, after, worse),
    )


def _score(kind: Kind, marks: Sequence[Mark], mcc: float | None) -> KindScore:
    of_kind = [m for m in marks if m.kind == kind and m.outcome in _TRUE]
    hits = [m for m in of_kind if m.outcome != "missed"]
    called = [m for m in marks if m.called == kind and m.outcome != "partial"]
    repaired = [m.repaired for m in hits if m.repaired is not None]
    full = [
        (r.error_mm, r.best_mm, r.recommended_mm)
        for r in repaired
        if None not in (r.error_mm, r.best_mm, r.recommended_mm)
    ]
    errors = [r.error_mm for r in repaired if r.error_mm is not None]
    ious = [m.iou for m in hits if m.iou is not None]
    return KindScore(
        true=len(of_kind),
        found=len(hits),
        right=sum(m.outcome == "right" for m in of_kind),
        called=len(called),
        wrong=sum(m.outcome != "right" for m in called),
        mcc=mcc,
        iou=_mean(ious),
        error_mm=_mean([f[0] for f in full] if full else errors),
        best_mm=_mean([f[1] for f in full]),
        recommended_mm=_mean([f[2] for f in full]),
    )


_TRUE = ("right", "misclassified", "missed")


def _mean(values: Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return float(np.mean(known)) if known else None


def _matrix(marks: Sequence[Mark]) -> tuple[tuple[int, ...], ...]:
    counts = np.zeros((len(ROWS), len(COLUMNS)), int)
    for mark in marks:
        if mark.outcome == "partial":
            continue
        row = mark.kind if mark.outcome in _TRUE else "nothing"
        counts[ROWS.index(row), COLUMNS.index(mark.called or "missed")] += 1
    return tuple(tuple(int(n) for n in row) for row in counts)


def _left(
    exercise: Exercise, repaired: Take, made: Sequence[Claim]
) -> tuple[float | None, float | None]:
    """Give the root mean square error before and after; see `Grade`."""
    take, clean = exercise.take, exercise.clean
    looked = np.zeros((take.n_frames, take.n_markers), bool)
    items: Sequence[Placed] = (*exercise.answers, *made)
    for item in items:
        looked[item.span.frames, take.index(item.marker)] = True
    looked |= take.seen & (repaired.positions != take.positions).any(axis=2)
    looked &= take.seen & clean.seen
    if not looked.any():
        return None, None
    given, back, true = (t.positions[looked] for t in (take, repaired, clean))
    back = np.where(np.isfinite(back), back, given)
    before, after = (
        float(np.sqrt(np.square(one - true).sum(axis=1).mean())) for one in (given, back)
    )
    return before, after


def _pace(moments: Sequence[datetime | None]) -> float | None:
    known = sorted({moment for moment in moments if moment is not None})
    steps = [(b - a).total_seconds() for a, b in pairwise(known)]
    working = [step for step in steps if step <= PAUSE_S]
    return float(median(working)) if working else None
