"""What a lab's own decisions teach: which findings it tends to accept, so that they come first.

Nothing is hidden by it; it is a factor on the order of a queue, and can be left out.
"""

import math
import re
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from markermend.model import Finding, short
from markermend.review.state import Review

PRIOR = 4.0
"""Decisions that a feature without any counts for: it takes this many to believe in one."""
LEAST = 0.02
"""No finding is taken to be less likely real than this, however often its like was rejected."""
_BINS_MM = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0)

Counts = tuple[int, int]


@dataclass(frozen=True)
class Triage:
    """How often findings with a feature were accepted and rejected.

    Attributes
    ----------
    accepted, rejected
        Feature -> number of decisions.
    n_accepted, n_rejected
        Of all decisions.
    """

    accepted: Counter[str] = field(default_factory=Counter)
    rejected: Counter[str] = field(default_factory=Counter)
    n_accepted: int = 0
    n_rejected: int = 0

    @property
    def n_decisions(self) -> int:
        """Decisions that it rests on."""
        return self.n_accepted + self.n_rejected

    def real(self, finding: Finding) -> float:
        """Give the probability, 0 to 1, that the operator would accept a finding.

        The rate of the finest group that it belongs to (kind, marker and size), drawn towards that
        of the next coarser one (kind and body part; kind; all) by as many decisions as `PRIOR`: a
        chain of Beta-binomial estimates, each the prior of the next.
        """
        rate = (self.n_accepted + PRIOR) / (self.n_decisions + PRIOR)
        for feature in features(finding):
            good, bad = self.accepted[feature], self.rejected[feature]
            rate = (good + PRIOR * rate) / (good + bad + PRIOR)
        return max(rate, LEAST)


NOTHING_LEARNT = Triage()


def learn(reviews: Iterable[Review]) -> Triage:
    """Count what was accepted and rejected of what detectors found; gaps are no matter of taste.

    Parameters
    ----------
    reviews
        Of any number of takes.
    """
    accepted: Counter[str] = Counter()
    rejected: Counter[str] = Counter()
    totals = {"accepted": 0, "rejected": 0}
    for finding, verdict in _decided(reviews):
        totals[verdict] += 1
        (accepted if verdict == "accepted" else rejected).update(features(finding))
    return Triage(accepted, rejected, totals["accepted"], totals["rejected"])


def _decided(reviews: Iterable[Review]) -> Iterator[tuple[Finding, str]]:
    for review in reviews:
        for judgement in review:
            verdict = judgement.decision.verdict
            if verdict in ("accepted", "rejected") and not judgement.added:
                yield judgement.finding, str(verdict)


def features(finding: Finding) -> tuple[str, ...]:
    """Name the groups that a finding belongs to, from the coarsest to the finest."""
    name = short(finding.marker).upper()
    place = part(name)
    size = _bin(finding.amplitude)
    kind = finding.kind
    return (
        kind,
        place,
        f"{kind} {place}",
        f"{kind} {name}",
        f"{kind} {name} {size}",
    )


def part(name: str) -> str:
    """Give the name of a marker without its side and number: left and right are one place."""
    plain = re.sub(r"[\d_.\-]+$", "", name.upper())
    return plain[1:] if len(plain) > 2 and plain[0] in "LR" else plain


def _bin(amplitude: float | None) -> str:
    if amplitude is None or not math.isfinite(amplitude):
        return "unknown"
    return str(sum(abs(amplitude) >= edge for edge in _BINS_MM))
