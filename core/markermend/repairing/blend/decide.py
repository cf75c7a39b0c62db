"""Decide how a span is filled by default: by a tested mix where one can be tested."""

from collections.abc import Sequence

import numpy as np

from markermend.errors import CannotRepair
from markermend.model import Take
from markermend.repairing.blend.blend import Blend, blend
from markermend.repairing.blend.bridge import bridge
from markermend.repairing.blend.fixed import between_edges
from markermend.repairing.blend.recorded import with_recorded
from markermend.repairing.blend.scene import Scene, survey
from markermend.repairing.blend.short import share_of_tested, short, with_filled_neighbours
from markermend.repairing.problem import Outcome, Problem
from markermend.repairing.window import window

TESTED_SHARE = 0.6
"""Weight of a mix that was tested, beside SHORT where little is seen."""


def decide(problem: Problem) -> Outcome:
    """Fill the span by the best means that it allows; see `markermend.repairing.methods.auto`."""
    around = survey(window(problem))
    _check(around)
    return outcome(problem, around, tested(around, problem.training))


def tested(around: Scene, training: Sequence[Take]) -> Blend | None:
    """Give the mix that does best on pseudo-gaps; None where none can be hidden.

    Where little is seen, the gaps of the neighbours are filled first, so that they count. Takes to
    learn from help where no neighbour is seen.
    """
    if _blacked_out(around) or _share(around) == 1.0:
        across = None if len(around.order) else bridge(around.window, training)
        return blend(around) if across is None else across
    return blend(with_filled_neighbours(around.window))


def _share(around: Scene) -> float:
    cut = around.window
    return share_of_tested(int(np.isfinite(cut.own[:, 0]).sum()), len(cut.span), cut.rate)


def _blacked_out(around: Scene) -> bool:
    cut = around.window
    return not cut.seen[cut.span.frames].any()


def outcome(problem: Problem, around: Scene, found: Blend | None) -> Outcome:
    """Say what was found, or what is done where no mix could be tested well enough.

    Raises
    ------
    CannotRepair
        If neither the marker's edges nor its neighbours say enough.
    """
    return with_recorded(problem, _as_gap(around, found), found)


def _as_gap(around: Scene, found: Blend | None) -> Outcome:
    """Fill the span as if nothing had been recorded in it.

    Raises
    ------
    CannotRepair
        If neither the marker's edges nor its neighbours say enough.
    """
    _check(around)
    cut = around.window
    share = _share(around)
    if found is not None and (share == 1.0 or _blacked_out(around)):
        return Outcome(found.values, found.band(), found.expected_mm, _note(around, found))
    if _blacked_out(around):
        return Outcome(between_edges(around), note="Its own motion carries it across the gap.")
    at_once, tried = short(cut)
    seen = int(np.isfinite(cut.own[:, 0]).sum())
    note = f"Only {seen} frames of it are seen: all gaps near here are filled at once"
    if found is None:
        if tried is None:
            return Outcome(at_once, note=f"{note}.")
        more = f"tried on {len(tried.likely)} gaps of this length on other markers"
        return Outcome(at_once, tried.band(), tried.expected_mm, f"{note}, {more}.")
    weight = share + (1 - share) * TESTED_SHARE
    band, expected = found.band(), found.expected_mm
    if band is None and tried is not None:
        band, expected = tried.band(), tried.expected_mm
    return Outcome(
        weight * found.values + (1 - weight) * at_once,
        band,
        expected,
        f"{note} ({1 - weight:.0%}), beside {_note(around, found)}",
    )


def _check(around: Scene) -> None:
    """Refuse where nothing carries the marker into the gap."""
    cut = around.window
    alone = len(around.order) < cut.n_dims
    if alone and None in cut.edges:
        raise CannotRepair(
            f"{cut.label} is seen on one side of the span only, and {len(around.order)} of its "
            "neighbours are seen throughout it; fill its neighbours first, or leave the gap."
        )


def _note(around: Scene, found: Blend) -> str:
    tested = f"of {len(found.pseudo)} pseudo-gaps of {found.pseudo.length} frames on this marker"
    if len(around.order) == 0:
        if not len(found.pseudo):
            tested = f"of {len(found.errors)} places in the takes to learn from"
        share, first = max(found.members)
        return f"No neighbour is seen here. {share:.0%} {first}: the best mix {tested}."
    share, first = max(found.members)
    more = len(found.members) - 1
    others = f" and {more} more" if more else ""
    return f"{share:.0%} {first}{others}: the best mix {tested}."
