"""Decide how a span is filled by default: by a tested mix where one can be tested."""

from markermend.errors import CannotRepair
from markermend.repairing.blend.blend import Blend, blend
from markermend.repairing.blend.fixed import between_edges, regress_and_krige
from markermend.repairing.blend.scene import Scene, survey
from markermend.repairing.problem import Outcome, Problem
from markermend.repairing.window import window

LEAST_ROWS = 10


def decide(problem: Problem) -> Outcome:
    """Fill the span by the best means that it allows; see `markermend.repairing.methods.auto`."""
    around = survey(window(problem))
    _check(around)
    return outcome(problem, around, blend(around))


def outcome(problem: Problem, around: Scene, found: Blend | None) -> Outcome:
    """Say what was found, or what is done where no mix could be tested."""
    _check(around)
    if found is not None:
        return Outcome(found.values, found.band(), found.expected_mm, _note(around, found))
    reason = f"no other stretch of {len(problem.span)} frames is whole, so nothing could be tested"
    if len(around.order) >= problem.n_dims and around.rows.sum() >= LEAST_ROWS:
        return Outcome(regress_and_krige(around), note=f"Settings known to be good: {reason}.")
    return Outcome(between_edges(around), note=f"Its own motion carries it across: {reason}.")


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
