from hypothesis import given, settings
from hypothesis import strategies as st

from markermend.model import Finding, Span
from markermend.review import Accept, Defer, MoveEdges, Review
from markermend.review.queue import damage, next_open, worst_first

PEAK = Finding("A", Span(10, 13), "peak", 0.9, amplitude=30.0)
STEP = Finding("A", Span(20, 70), "step", 0.9, amplitude=26.0)
SHORT = Finding("B", Span(10, 12), "gap")
LONG = Finding("B", Span(40, 140), "gap")
ALL = (PEAK, STEP, SHORT, LONG)


def test_damage_is_size_times_duration_times_confidence() -> None:
    assert damage(STEP, 100.0) == 26.0 * 0.5 * 0.9
    assert damage(LONG, 100.0, expected_mm=7.0) == 7.0
    assert damage(LONG, 200.0, expected_mm=7.0) == 3.5


@settings(deadline=None)
@given(st.integers(1, 3000), st.integers(1, 3000))
def test_a_longer_gap_is_never_less_harm(one: int, other: int) -> None:
    short, long = sorted((one, other))
    harm = [damage(Finding("A", Span(0, n), "gap"), 100.0) for n in (short, long)]
    assert harm[0] <= harm[1]
    assert harm[0] > 0


def test_worst_comes_first_and_a_verdict_moves_nothing() -> None:
    order = worst_first(Review(), ALL, 100.0)
    assert order == (LONG, STEP, PEAK, SHORT)
    assert worst_first(Accept((STEP,)).apply(Review()), reversed(ALL), 100.0) == order


def test_a_known_error_and_moved_edges_count() -> None:
    assert worst_first(Review(), ALL, 100.0, {LONG.id: 0.01})[0] == STEP
    wide = MoveEdges((PEAK,), Span(0, 1000)).apply(Review())
    assert worst_first(wide, ALL, 100.0)[0] == PEAK


def test_gaps_at_the_ends_of_the_take_come_last() -> None:
    outside = Finding("B", Span(0, 1000), "gap")
    drift = Finding("A", Span(0, 500), "slow", amplitude=9.0)
    assert worst_first(Review(), (*ALL, outside, drift), 100.0)[0] == outside
    ordered = worst_first(Review(), (*ALL, outside, drift), 100.0, n_frames=2000)
    assert ordered == (drift, LONG, STEP, PEAK, SHORT, outside)
    assert worst_first(Review(), ALL, 100.0, n_frames=140)[-1] == LONG


def test_the_next_open_one_is_sought_around_the_end() -> None:
    order = worst_first(Review(), ALL, 100.0)
    review = Defer((STEP,)).apply(Accept((LONG,)).apply(Review()))
    assert next_open(order, review) == PEAK
    assert next_open(order, review, PEAK.id) == SHORT
    assert next_open(order, review, SHORT.id) == PEAK
    assert next_open(order, review, PEAK.id, step=-1) == SHORT
    assert next_open(order, review, step=-1) == SHORT
    done = Accept(ALL).apply(review)
    assert next_open(order, done, PEAK.id) is None
    assert next_open((), done) is None
