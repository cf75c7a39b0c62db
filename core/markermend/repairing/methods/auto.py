"""Choose among many regressions and ways into the gap, and mix the best."""

from markermend.model import KINDS
from markermend.registry import method
from markermend.repairing.blend.decide import decide
from markermend.repairing.problem import Outcome, Problem


@method(
    title="Best mix here (AUTO)",
    kinds=KINDS,
    source="MarkerMend: regressions in moving frames and kriging, mixed by pseudo-gaps",
)
def auto(problem: Problem) -> Outcome:
    """Hide stretches of the same length elsewhere, see what fills them best, and do that here.

    The candidates are ridge regressions on the marker's neighbours in several frames of
    reference, each followed by one of many ways to carry into the gap what the regression leaves
    over at its edges.  The few that mend pseudo-gaps of this length on this marker best are mixed
    so that their errors cancel.  The errors that the mix makes there are the expected error, and
    by position in the gap their 90 % quantile is the band.

    A turned room gives the turned fill, but under a peak, a step or a slow change where some axes
    of the room are off the fill and others are as usual: these stay as recorded.

    Where every neighbour is gone, the marker's own motion before and after carries the gap.
    Where no pseudo-gap of this length fits into what is seen, settings known to be good are used,
    and neither band nor expected error is given.

    Parameters
    ----------
    problem
        The span.

    Returns
    -------
    The values with band, expected error and a note.

    Raises
    ------
    CannotRepair
        If neither the marker's edges nor its neighbours say enough.
    """
    return decide(problem)
