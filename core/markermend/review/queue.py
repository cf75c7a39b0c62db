"""Which finding comes next: the worst first, by the damage that is to be expected."""

from collections.abc import Callable, Iterable, Mapping, Sequence

from markermend.model import Finding
from markermend.review.state import Review

# How far off an unseen marker may be assumed to be, before anything has been computed: a straight
# line over T seconds under an acceleration a is off by a T^2 / 12 on average (a as on a walking
# body), and neighbours on the same segment bound it to soft tissue's couple of centimetres.
# Only an order is made from it; errors that are shown come from the repairs.
_ACCELERATION = 5000.0  # mm/s^2
_BOUND = 20.0  # mm


def damage(finding: Finding, rate: float, expected_mm: float | None = None) -> float:
    """Give the expected damage of a finding: size times duration times confidence, in mm s.

    Parameters
    ----------
    finding
        As the operator sees it now: with its edges and class as judged.
    rate
        Hz.
    expected_mm
        The error to be expected of its best repair, where that is known already: for a gap its
        size. Without it, a gap (and an artefact of unknown size) is sized by its duration.
    """
    duration_s = len(finding.span) / rate
    if finding.kind != "gap" and finding.amplitude is not None:
        size = abs(finding.amplitude)
    elif expected_mm is not None:
        size = expected_mm
    else:
        size = min(_ACCELERATION * duration_s**2 / 12, _BOUND)
    return size * duration_s * finding.score


def worst_first(
    review: Review,
    detected: Iterable[Finding],
    rate: float,
    expected_mm: Mapping[str, float] | None = None,
    n_frames: int | None = None,
    weight: Callable[[Finding], float] = lambda _: 1.0,
) -> tuple[Finding, ...]:
    """Order all live findings of a review by expected damage; the order is total and repeatable.

    Verdicts do not matter: deciding moves nothing. Gaps that reach the beginning or the end of the
    take come last: there the marker was outside the volume, and few of them are ever filled.

    Parameters
    ----------
    review, detected
        The decisions, and what the detector found.
    rate
        Hz.
    expected_mm
        Finding id -> error of its best repair, as far as known.
    n_frames
        Length of the take, if gaps at its ends are to come last.
    weight
        Factor on the damage, such as how likely the operator is to accept it.
    """
    known = expected_mm or {}

    def rank(finding: Finding) -> tuple[bool, float, str, int, str]:
        touched = review.judgements.get(finding.id)
        judged = finding if touched is None else touched.as_judged
        size = weight(finding) * damage(judged, rate, known.get(finding.id))
        outside = judged.span.start == 0 or judged.span.stop == n_frames
        at_end = n_frames is not None and judged.kind == "gap" and outside
        return at_end, -size, finding.marker, judged.span.start, finding.id

    return tuple(sorted(review.live(detected), key=rank))


def next_open(
    order: Sequence[Finding], review: Review, current: str | None = None, step: int = 1
) -> Finding | None:
    """Give the next finding without a verdict after `current`, around the end; None if all have.

    Parameters
    ----------
    order
        The queue, possibly filtered.
    review
        The decisions.
    current
        Id of the finding to start from; by default before the first.
    step
        1 forwards, -1 backwards.
    """
    ids = [finding.id for finding in order]
    start = ids.index(current) if current in ids else (-1 if step > 0 else 0)
    for i in range(1, len(ids) + 1):
        finding = order[(start + i * step) % len(ids)]
        if finding.id != current and review.decision(finding).verdict is None:
            return finding
    return None
