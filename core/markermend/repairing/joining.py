"""Two takes of the same markers in one, with the time between them filled."""

import numpy as np

from markermend.errors import BadInput
from markermend.model import Span, Take
from markermend.repairing.problem import Repair
from markermend.repairing.run import Refusal, Wish, apply, repair_all


def joined(
    first: Take, second: Take, gap_s: float, method: str = "auto"
) -> tuple[Take, tuple[Repair, ...], tuple[Refusal, ...]]:
    """Put one take after another, and fill the time between as a blackout.

    Nothing is moved or turned: the two should lie as the movement is to go on.

    Parameters
    ----------
    first, second
        Takes of one rate and unit; measured markers that only one of them has are left out.
    gap_s
        Time between the last frame of the first and the first frame of the second, s.
    method
        Name of a registered repair that needs no neighbour in the span.

    Returns
    -------
    The whole take, what was filled, and what could not be.

    Raises
    ------
    BadInput
        If rates, units or dimensions differ, no marker is common, or the time is not positive.

    Notes
    -----
    Z. Li et al., IEEE Access 8:76980, 2020, section IV: motion editing by a filled blackout.
    """
    if not np.isclose(first.rate, second.rate):
        raise BadInput(
            f"The takes have rates of {first.rate:g} and {second.rate:g} Hz; give two of one rate."
        )
    if first.units != second.units or first.n_dims != second.n_dims:
        raise BadInput("The takes have different units or dimensions; give two of one kind.")
    measured = {second.labels[m] for m in second.measured}
    labels = [first.labels[m] for m in first.measured if first.labels[m] in measured]
    if not labels:
        raise BadInput("The takes have no measured marker in common; give two of one marker set.")
    n_gap = round(gap_s * first.rate)
    if n_gap < 1:
        raise BadInput(f"{gap_s:g} s is less than a frame of {first.rate:g} Hz; give a longer gap.")
    parts = [take.positions[:, [take.index(label) for label in labels]] for take in (first, second)]
    between = np.full((n_gap, len(labels), first.n_dims), np.nan)
    whole = Take(
        np.concatenate([parts[0], between, parts[1]]), first.rate, labels, units=first.units
    )
    span = Span(first.n_frames, first.n_frames + n_gap)
    repairs, refusals = repair_all(whole, [Wish(label, span, method=method) for label in labels])
    return apply(whole, repairs), repairs, refusals
