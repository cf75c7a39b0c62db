"""A clean take of a few stiff groups that swing, and reviews by trainees of known skill."""

from collections.abc import Callable, Iterable

import numpy as np
import pytest

from markermend.model import Finding, Kind, Span, Take
from markermend.review import Decision, Judgement, Review
from markermend.truth import Truth


def swinging(n_groups: int = 3, n_frames: int = 1500, rate: float = 100.0) -> Take:
    rng = np.random.default_rng(11)
    t = np.arange(n_frames) / rate
    parts = []
    for g in range(n_groups):
        centre = np.column_stack(
            [
                300 * np.sin(1.7 * t + g),
                120 * np.cos(1.1 * t + 2 * g),
                900 + 60 * np.sin(2.3 * t + g),
            ]
        )
        parts += [centre + offset for offset in rng.normal(0, 90, (4, 3))]
    positions = np.stack(parts, axis=1) + rng.normal(0, 0.1, (n_frames, 4 * n_groups, 3))
    return Take(positions, rate, [f"M{i}" for i in range(4 * n_groups)])


@pytest.fixture(scope="session")
def clean() -> Take:
    return swinging()


def judged(
    marker: str, span: Span, kind: Kind, verdict: str | None = "accepted", method: str = "linear"
) -> Judgement:
    """A finding that was added by hand and decided on."""
    return Judgement(Finding(marker, span, kind), Decision(verdict, method=method), added=True)  # type: ignore[arg-type]


def review_of(judgements: Iterable[Judgement]) -> Review:
    return Review({judgement.finding.id: judgement for judgement in judgements})


def accepting(
    truths: Iterable[Truth],
    method: str = "linear",
    which: Callable[[Truth], bool] = lambda truth: True,
) -> Review:
    """The review of somebody who names and places everything right that is noticed."""
    return review_of(judged(t.marker, t.span, t.kind, method=method) for t in truths if which(t))
