"""Decide how a span is filled by default: by a tested mix where one can be tested."""

import numpy as np

from markermend.errors import CannotRepair
from markermend.repairing.blend.blend import Blend, blend
from markermend.repairing.blend.fixed import between_edges
from markermend.repairing.blend.scene import Scene, survey
from markermend.repairing.blend.short import share_of_tested, short
from markermend.repairing.problem import Outcome, Problem
from markermend.repairing.window import window


def decide(problem: Problem) -> Outcome:
    """Fill the span by the best means that it allows; see `markermend.repairing.methods.auto`."""
    around = survey(window(problem))
    _check(around)
    return outcome(problem, around, tested(around))


def tested(around: Scene) -> Blend | None:
    """Give the mix that does best on pseudo-gaps; None where too little is seen to test any."""
    return blend(around) if _share(around) > 0 or not len(around.order) else None


def _share(around: Scene) -> float:
    cut = around.window
    return share_of_tested(int(np.isfinite(cut.own[:, 0]).sum()), len(cut.span), cut.rate)


def outcome(problem: Problem, around: Scene, found: Blend | None) -> Outcome:
    """Say what was found, or what is done where no mix could be tested well enough."""
    _check(around)
    cut = around.window
    seen = int(np.isfinite(cut.own[:, 0]).sum())
    share = _share(around)
    if found is not None and (share == 1.0 or not len(around.order)):
        return Outcome(found.values, found.band(), found.expected_mm, _note(around, found))
    if not cut.seen[cut.span.frames].any():
        return Outcome(between_edges(around), note="Its own motion carries it across the gap.")
    filled = short(cut)
    values = filled.values
    note = f"Only {seen} frames of it are seen: all gaps near here are filled at once"
    if found is None or share == 0.0:
        return Outcome(values, note=f"{note}.")
    values = share * found.values + (1 - share) * values
    return Outcome(values, note=f"{note}, which counts {1 - share:.0%} beside a tested mix.")


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
        return f"No neighbour is seen here; its own motion before and after carries it ({tested})."
    share, first = max(found.members)
    more = len(found.members) - 1
    others = f" and {more} more" if more else ""
    return f"{share:.0%} {first}{others}: the best mix {tested}."
