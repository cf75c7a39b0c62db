"""What earlier decisions teach: laws, and an operator who rejects everything at the feet."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from markermend.model import Finding, Span
from markermend.review import Accept, Reject, Review
from markermend.review.queue import worst_first
from markermend.review.triage import LEAST, NOTHING_LEARNT, learn, part

FEET = ("LHEE", "RHEE", "LTOE", "RTOE", "LMT5", "RMT5", "LANK", "RANK")
REST = (
    "LFHD", "RFHD", "C7", "T10", "CLAV", "STRN", "LSHO", "RSHO", "LELB", "RELB", "LWRA", "RWRA",
    "LFIN", "RFIN", "LASI", "RASI", "LPSI", "RPSI", "LTHI", "RTHI", "LKNE", "RKNE", "LTIB", "RTIB",
)  # fmt: skip
RATE = 100.0


def findings_of(seed: int, n: int = 220) -> list[Finding]:
    """Findings of one take: a third of them at the feet, where impacts look like artefacts."""
    rng = np.random.default_rng(seed)
    found = {}
    while len(found) < n:
        at_feet = rng.random() < 0.35
        kind = str(rng.choice(["peak", "noise", "step", "slow"]))
        length = int(rng.integers(1, 4) if kind == "peak" else rng.integers(10, 120))
        start = int(rng.integers(0, 5000))
        finding = Finding(
            str(rng.choice(FEET if at_feet else REST)),
            Span(start, start + length),
            kind,  # type: ignore[arg-type]
            score=float(rng.uniform(0.5, 1.0)),
            amplitude=float(rng.lognormal(2.0, 0.8)),
            detector="likelihood",
        )
        found[finding.id] = finding
    return list(found.values())


def decided(findings: list[Finding]) -> Review:
    """Decide as the operator does who takes nothing at the feet for an artefact."""
    review = Review()
    for finding in findings:
        command = Reject if finding.marker in FEET else Accept
        review = command((finding,)).apply(review)
    return review


def precision_of_first(findings: list[Finding], review: Review, n: int = 50) -> float:
    triage = learn([review])
    first = worst_first(Review(), findings, RATE, weight=triage.real)[:n]
    return float(np.mean([f.marker not in FEET for f in first]))


@pytest.mark.parametrize("seed", range(5))
def test_after_200_decisions_the_next_take_begins_with_what_is_real(seed: int):
    before, after = findings_of(seed), findings_of(1000 + seed)
    by_damage = worst_first(Review(), before, RATE)[:200]
    review = decided(list(by_damage))
    assert len(review) == 200
    without = precision_of_first(after, Review())
    learnt = precision_of_first(after, review)
    assert learnt - without >= 0.20, (without, learnt)


@given(st.integers(0, 10_000), st.integers(0, 60))
def test_nothing_is_hidden_whatever_was_decided(seed: int, n: int):
    findings = findings_of(seed, 60)
    triage = learn([decided(findings[:n])])
    order = worst_first(Review(), findings, RATE, weight=triage.real)
    assert {f.id for f in order} == {f.id for f in findings}
    assert all(LEAST <= triage.real(f) <= 1 for f in findings)


def test_without_decisions_the_order_is_by_damage_alone():
    findings = findings_of(3)
    plain = worst_first(Review(), findings, RATE)
    assert worst_first(Review(), findings, RATE, weight=NOTHING_LEARNT.real) == plain


@given(st.integers(0, 10_000))
def test_one_more_rejection_never_raises_its_like(seed: int):
    findings = findings_of(seed, 30)
    one, *rest = findings
    some = learn([decided(rest)])
    more = learn([Reject((one,)).apply(decided(rest))])
    assert more.real(one) <= some.real(one)


def test_spans_added_by_hand_say_nothing_about_the_detector():
    from markermend.review import AddFinding

    finding = findings_of(1)[0]
    review = Accept((finding,)).apply(AddFinding((finding,)).apply(Review()))
    assert learn([review]).n_decisions == 0


@pytest.mark.parametrize(
    ("name", "place"),
    [("LHEE", "HEE"), ("RHEE", "HEE"), ("R_SHANK_3", "_SHANK"), ("C7", "C"), ("LMT5", "MT")],
)
def test_left_and_right_are_one_place(name: str, place: str):
    assert part(name) == place
