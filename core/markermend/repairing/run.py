"""Run repair methods on takes: one span, many spans, every gap."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from markermend.errors import BadInput, CannotRepair, MarkerMendError
from markermend.model import FloatArray, Kind, Span, Take
from markermend.registry import Method, Registry
from markermend.repairing.problem import Outcome, Problem, Repair

REACH = 4000
"""Frames around a span, or three spans and 1000 if that is more, beyond which no method looks."""

REPAIRS = Registry("repair method", "markermend.repairing.methods", "markermend.repairs")

# What is tried, in this order, where no method is named. By evidence (assets/docs/benchmarks.md):
# a step or a hill that can be subtracted is, since the motion under it is kept; everything else is
# filled by the mix, which had the smaller mean and the smaller median error on single frames too
# once the axes that are as usual stay as recorded; what follows needs less around the span.
DEFAULTS: Mapping[Kind, tuple[str, ...]] = {
    "gap": ("auto", "rigid", "pchip"),
    "peak": ("auto", "pchip", "rigid"),
    "noise": ("auto", "butterworth", "rigid", "pchip"),
    "step": ("unstep", "auto", "rigid", "pchip"),
    "slow": ("unslow", "auto", "rigid", "pchip"),
}


@dataclass(frozen=True)
class Wish:
    """A span that somebody wants repaired; an empty method means the default of the kind."""

    marker: str
    span: Span
    kind: Kind = "gap"
    partner: str | None = None
    method: str = ""
    parameters: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Refusal:
    """A wish that no method could meet, and why."""

    wish: Wish
    reason: str


def repair(
    take: Take,
    marker: str,
    span: Span | tuple[int, int],
    method: str = "",
    *,
    kind: Kind = "gap",
    partner: str | None = None,
    masked: Iterable[tuple[str, Span]] = (),
    training: Sequence[Take] = (),
    **parameters: Any,
) -> Repair:
    """Compute the repair of one span; the take stays as it is.

    Parameters
    ----------
    take
        The take as recorded.
    marker
        Label of a measured marker.
    span
        Frames to repair, or ``(start, stop)``.
    method
        Name of a registered repair; by default the first of the kind's defaults that applies.
    kind, partner
        What was found there; some methods use it.
    masked
        Further spans ``(label, span)`` that are being repaired too and must not be trusted.
    training
        Takes to learn from, for the methods that do.
    **parameters
        Parameters of the method.

    Raises
    ------
    UnknownName, BadParameter
        If marker, method or a parameter is unknown or out of bounds.
    CannotRepair
        If the method does not apply here.
    """
    span = span if isinstance(span, Span) else Span(*span)
    wish = Wish(marker, span, kind, partner, method, parameters)
    near, first, hidden = nearby(take, span, [(marker, span), *masked])
    done = _grant(_Poser(near, hidden, training), replace(wish, span=moved(span, -first)))
    return replace(done, span=span)


def repair_all(
    take: Take,
    wishes: Sequence[Wish],
    training: Sequence[Take] = (),
    progress: Callable[[int], None] = lambda done: None,
) -> tuple[tuple[Repair, ...], tuple[Refusal, ...]]:
    """Compute many repairs, each from the take as recorded with *all* these spans masked.

    The order of the wishes does not matter.  `progress` is called with the number done.
    """
    poser = _Poser(take, [(wish.marker, wish.span) for wish in wishes], training)
    repairs, refusals = [], []
    for done, wish in enumerate(wishes, 1):
        try:
            repairs.append(_grant(poser, wish))
        except CannotRepair as refusal:
            refusals.append(Refusal(wish, str(refusal)))
        progress(done)
    return tuple(repairs), tuple(refusals)


def fill(
    take: Take,
    method: str = "",
    *,
    training: Sequence[Take] = (),
    **parameters: Any,
) -> Take:
    """Fill every gap of every measured marker, also at the ends where its neighbours allow.

    What cannot be filled stays NaN.

    Parameters
    ----------
    take
        A take with gaps.
    method
        Name of a registered repair; by default ``auto``, else ``rigid`` or ``pchip``.
    training, **parameters
        As in `repair`.
    """
    wishes = [
        Wish(take.labels[m], span, method=method, parameters=parameters)
        for m in take.measured
        for span, _ in take.gaps(int(m))
        if len(span) < take.n_frames
    ]
    if method:
        REPAIRS.get(method)  # an unknown name is said even where there is nothing to fill
    repairs, _ = repair_all(take, wishes, training)
    return apply(take, repairs)


def apply(take: Take, repairs: Iterable[Repair]) -> Take:
    """Write repairs into a copy of the take; nothing outside their spans changes.

    A span that is left as a gap becomes one: what was recorded there is no longer seen.

    Raises
    ------
    BadInput
        If a repair's span lies outside the take, or two repairs write different values to the same
        sample. The two halves of a swap write the same and are no conflict.
    """
    positions = take.positions.copy()
    written = np.zeros((take.n_frames, take.n_markers), bool)
    for done in repairs:
        for label, values in ((done.marker, done.values), *done.also):
            marker = take.index(label)
            before = written[done.span.frames, marker]
            there = positions[done.span.frames, marker]
            if done.span.stop > take.n_frames or not np.array_equal(
                there[before], values[before], equal_nan=True
            ):
                raise BadInput(
                    f"Two repairs write {label} in frames {done.span.start} to {done.span.stop}; "
                    "merge the spans or give one of them up."
                )
            written[done.span.frames, marker] = True
            positions[done.span.frames, marker] = values
    return take.with_positions(positions)


class _Poser:
    """Poses problems on one take with one set of masked spans."""

    def __init__(
        self, take: Take, masked: Iterable[tuple[str, Span]], training: Sequence[Take]
    ) -> None:
        self.take, self.training = take, tuple(training)
        self.place = {take.labels[m]: i for i, m in enumerate(take.measured)}
        positions = take.positions[:, take.measured]
        for label, span in masked:
            take.index(label)
            if span.stop > take.n_frames:
                raise BadInput(
                    f"The span ends at frame {span.stop}, and the take has {take.n_frames} frames."
                )
            if label not in self.place:
                role = take.roles[take.index(label)]
                what = "is computed by a model" if role == "model" else "has no label of its own"
                raise BadInput(f"{label} {what} and is not repaired; choose a measured marker.")
            positions[span.frames, self.place[label]] = np.nan
        positions.flags.writeable = False
        self.positions = positions
        self.labels = tuple(self.place)

    def pose(self, wish: Wish) -> Problem:
        return Problem(
            positions=self.positions,
            marker=self.place[wish.marker],
            span=wish.span,
            rate=self.take.rate,
            labels=self.labels,
            recorded=self.take.positions[:, self.take.index(wish.marker)],
            take=self.take,
            kind=wish.kind,
            partner=wish.partner,
            training=self.training,
        )


def nearby(
    take: Take, span: Span, masked: Iterable[tuple[str, Span]]
) -> tuple[Take, int, list[tuple[str, Span]]]:
    """Cut out of a long take what methods look at, so that one span costs the same in any take.

    Returns
    -------
    The part of the take, its first frame in the take, and the masked spans in frames of it.
    """
    size = min(max(REACH, 3 * len(span) + 1000), take.n_frames)
    start = span.start - (size - len(span)) // 2
    start = min(max(start, 0), take.n_frames - size)
    part = Span(start, start + size)
    if len(part) == take.n_frames or span.stop > take.n_frames:
        return take, 0, list(masked)
    inside = [
        (label, Span(max(hidden.start, part.start), min(hidden.stop, part.stop)))
        for label, hidden in masked
        if hidden.overlaps(part)
    ]
    cut = take.with_positions(take.positions[part.frames])
    return cut, part.start, [(label, moved(hidden, -part.start)) for label, hidden in inside]


def moved(span: Span, frames: int) -> Span:
    """Shift a span in time."""
    return Span(span.start + frames, span.stop + frames)


def pose(
    take: Take,
    wish: Wish,
    masked: Iterable[tuple[str, Span]] = (),
    training: Sequence[Take] = (),
) -> Problem:
    """Pose one wish as the problem that its method would be given; see `repair`.

    Raises
    ------
    BadInput
        If the span lies outside the take or the marker is not repaired.
    """
    return _Poser(take, [(wish.marker, wish.span), *masked], training).pose(wish)


def _grant(poser: _Poser, wish: Wish) -> Repair:
    problem = poser.pose(wish)
    if wish.method:
        return solve(problem, REPAIRS.get(wish.method), wish.parameters)
    reasons = []
    for name in DEFAULTS[wish.kind]:
        try:
            return solve(problem, REPAIRS.get(name), {})
        except CannotRepair as refusal:
            reasons.append(str(refusal))
    raise CannotRepair(reasons[-1])


def solve(problem: Problem, method: Method, parameters: Mapping[str, Any]) -> Repair:
    """Run one method on one problem and check what it gives back.

    Raises
    ------
    CannotRepair
        If the method refuses, or its answer is not finite.
    MarkerMendError
        If the answer has the wrong shape: a fault of the method.
    """
    given: Outcome | FloatArray = method(problem, **parameters)
    outcome = given if isinstance(given, Outcome) else Outcome(given)
    return accept(problem, method, outcome, parameters)


def accept(
    problem: Problem, method: Method, outcome: Outcome, parameters: Mapping[str, Any]
) -> Repair:
    """Check what a method gave back, and make a repair of it; raises as `solve` does."""
    values = np.asarray(outcome.values, np.float64)
    wanted = (len(problem.span), problem.n_dims)
    if values.shape != wanted:
        raise MarkerMendError(f"{method.name} returned shape {values.shape}, not {wanted}.")
    if method.name != "leave" and not np.isfinite(values).all():
        raise CannotRepair(
            f"{method.title} found no finite values for {problem.labels[problem.marker]} here; "
            "choose another method."
        )
    values.flags.writeable = False
    return Repair(
        marker=problem.labels[problem.marker],
        span=problem.span,
        values=values,
        method=method.name,
        parameters={p.name: parameters.get(p.name, p.default) for p in method.parameters},
        band=outcome.band,
        expected_mm=outcome.expected_mm,
        note=outcome.note,
        also=outcome.also,
    )
