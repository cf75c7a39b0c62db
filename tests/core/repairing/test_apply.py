"""The one function that writes positions."""

import numpy as np
import pytest

import markermend as mm
from markermend.errors import BadInput
from markermend.repairing import Repair, apply


@pytest.fixture
def take() -> mm.Take:
    """Two markers that stand still."""
    return mm.Take(np.zeros((10, 2, 3)), 100, ["A", "B"])


def write(marker: str, start: int, value: float, **more: object) -> Repair:
    return Repair(marker, mm.Span(start, start + 4), np.full((4, 3), value), "linear", **more)


def test_only_the_spans_change(take: mm.Take):
    done = apply(take, [write("A", 2, 5.0)]).positions
    assert (done[2:6, 0] == 5).all()
    done = done.copy()
    done[2:6, 0] = 0
    assert (done == take.positions).all()


def test_different_values_on_one_sample_are_refused(take: mm.Take):
    with pytest.raises(BadInput, match="Two repairs write A"):
        apply(take, [write("A", 2, 5.0), write("A", 4, 6.0)])


def test_both_halves_of_a_swap_may_be_accepted(take: mm.Take):
    other = np.full((4, 3), 7.0)
    one = write("A", 2, 5.0, also=(("B", other),))
    two = Repair("B", mm.Span(2, 6), other, "swap", also=(("A", np.full((4, 3), 5.0)),))
    both = apply(take, [one, two]).positions
    assert (both == apply(take, [one]).positions).all()


def test_what_is_left_becomes_a_gap(take: mm.Take):
    left = Repair("A", mm.Span(2, 6), np.full((4, 3), np.nan), "leave")
    assert apply(take, [left]).seen[:, 0].tolist() == [True] * 2 + [False] * 4 + [True] * 4
