"""How far to trust each method on one span of one marker, in mm."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from markermend.errors import CannotRepair
from markermend.model import FloatArray
from markermend.registry import Method
from markermend.repairing.blend.band import band_by_position
from markermend.repairing.blend.blend import Blend
from markermend.repairing.blend.decide import outcome, tested
from markermend.repairing.blend.scene import Scene
from markermend.repairing.problem import Outcome, Problem
from markermend.repairing.run import REPAIRS, solve
from markermend.repairing.trials import Trial, cut_out, places, spread_out, trials

REFERENCE = "auto"
"""The method whose own pseudo-gaps serve all others as reference."""
MOST = 6
"""Pseudo-gaps that a method is tried on."""
MOST_SLOW = 2
"""The same for the methods that take long."""
LEAST_FOR_BAND = 5
SLOW = ("ffnn", "gslr", "kalman", "li_eq16", "polynomial", "slr", "svt", "tnn")
"""Methods that take so long that they are tried on few pseudo-gaps only."""


@dataclass(frozen=True, eq=False)
class Trust:
    """What a method's errors were on pseudo-gaps of the same length on the same marker.

    Attributes
    ----------
    method
        Name.
    expected_mm
        Mean error to be expected.
    nine_in_ten_mm
        Nine gaps in ten are expected to have a smaller mean error.
    band
        (length of the span,) mm: 90 % of errors are expected to be smaller at that position; None
        from too few pseudo-gaps.
    n_pseudo_gaps
        On how many pseudo-gaps this rests.
    """

    method: str
    expected_mm: float
    nine_in_ten_mm: float
    band: FloatArray | None
    n_pseudo_gaps: int


def expected_error(
    problem: Problem,
    methods: Iterable[str] | None = None,
    parameters: Mapping[str, Mapping[str, Any]] | None = None,
) -> dict[str, Trust]:
    """Measure what each method's error is to be expected to be on this span.

    Stretches of the same length are hidden elsewhere on the same marker, each on its own and with
    the span itself hidden too, and every method fills them from what else is seen: none learns
    from the frames that it is tried on.  All methods get the same stretches.

    Parameters
    ----------
    problem
        The span; `markermend.repairing.run.pose` makes it.
    methods
        Names; by default all that are registered.
    parameters
        Parameters of some of them.

    Returns
    -------
    Trust by method; methods that refuse, or that nothing can be hidden for, are missing.

    Raises
    ------
    UnknownName, BadParameter
        If there is no such method or parameter.
    """
    chosen = [REPAIRS.get(name) for name in (REPAIRS.names() if methods is None else methods)]
    given = parameters or {}
    bench = Bench(problem)
    measured = (bench.trust(method, given.get(method.name, {})) for method in chosen)
    return {found.method: found for found in measured if found is not None}


class Bench:
    """The pseudo-gaps of one problem, posed once for all methods.

    Parameters
    ----------
    problem
        The span.

    Attributes
    ----------
    problem
        The same problem, cut down to the window that methods look at.
    """

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self._around: Scene | None = None
        self._window_start = 0
        try:
            self.problem, self._around = cut_out(problem)
            self._window_start = self._around.window.start
        except CannotRepair as refusal:
            self._refusal = str(refusal)

    @cached_property
    def reference(self) -> Blend | None:
        """The mix by which the best known fill is made, with its errors on its own pseudo-gaps."""
        if self._around is None:
            return None
        return tested(self._around, self.problem.training)

    def reference_outcome(self) -> Outcome:
        """Give what the reference method fills in.

        Raises
        ------
        CannotRepair
            If it does not apply.
        """
        if self._around is None:
            raise CannotRepair(self._refusal)
        return outcome(self.problem, self._around, self.reference)

    @cached_property
    def _starts(self) -> np.ndarray[Any, np.dtype[np.intp]]:
        if self._around is None:
            return np.empty(0, np.intp)
        known = self.reference
        if known is None:
            return spread_out(places(self._around), MOST)
        moved = known.first - self._around.window.start
        return spread_out(known.pseudo.starts + moved, MOST)

    @cached_property
    def trials(self) -> list[Trial]:
        """The pseudo-gaps, as problems."""
        if not len(self._starts):
            return []
        values = None
        if self.problem.kind != "gap":
            try:
                values = self.reference_outcome().values
            except CannotRepair:
                values = None
        return trials(self.problem, self._starts, values)

    def trust(self, method: Method, parameters: Mapping[str, Any]) -> Trust | None:
        """Try one method; None where it refuses everywhere or nothing can be hidden."""
        if method.name == "leave":
            return None
        if method.name == REFERENCE and self.reference is not None:
            return _of_reference(self.reference, self.reference_outcome())
        every = MOST // MOST_SLOW if method.name in SLOW else 1
        errors, tried = [], []
        for i in range(0, len(self.trials), every):
            trial = self.trials[i] if every == 1 else self.trials[i].near
            try:
                done = solve(trial.problem, method, parameters)
            except CannotRepair:
                continue
            errors.append(np.linalg.norm(done.values - trial.truth, axis=1))
            tried.append(i)
        if not errors:
            return None
        return self._judged(method.name, np.array(errors) * self._hardship(tried))

    def _hardship(self, tried: list[int]) -> float:
        """Say how much harder the gap is than these few pseudo-gaps, by the reference's errors."""
        if self.reference is None:
            return 1.0
        errors = self.reference.errors.mean(axis=1)
        starts = self.reference.pseudo.starts + self.reference.first
        at = np.searchsorted(starts, self._starts[tried] + self._window_start)
        return self.reference.expected_mm / float(max(errors[at].mean(), 1e-9))

    def _judged(self, name: str, errors: FloatArray) -> Trust:
        each = errors.mean(axis=1)
        length = len(self.problem.span)
        band = None
        if len(errors) >= LEAST_FOR_BAND:
            seen = int(np.isfinite(self.problem.own[:, 0]).sum())
            band = band_by_position(errors, np.arange(length), length, seen)
        return Trust(name, float(each.mean()), float(np.quantile(each, 0.9)), band, len(errors))


def _of_reference(found: Blend, done: Outcome) -> Trust:
    """Read off the fill how far it is to be trusted, and off the pseudo-gaps what is not in it."""
    expected = found.expected_mm if done.expected_mm is None else done.expected_mm
    each = found.likely.mean(axis=1) * (expected / max(found.expected_mm, 1e-12))
    return Trust(REFERENCE, expected, float(np.quantile(each, 0.9)), done.band, len(each))
