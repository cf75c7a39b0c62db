"""Morphology and pairs of jumps, worked out by hand (Eq. 13 to 17, Fig. 10)."""

import numpy as np

from markermend.detection.published.morphology import (
    closing,
    derivative_pairs,
    dilation,
    erosion,
    opening,
    top_hat,
)
from markermend.model import Span

X = np.array([0, 0, 5, 0, 0, 3, 3, 3, 3, 0, 1, 0], float)[:, None]


def row(y):
    return y.ravel().tolist()


def test_erosion_is_the_least_and_dilation_the_largest():
    assert row(erosion(X, 3)) == [0, 0, 0, 0, 0, 0, 3, 3, 0, 0, 0, 0]
    assert row(dilation(X, 3)) == [0, 5, 5, 5, 3, 3, 3, 3, 3, 3, 1, 1]


def test_opening_takes_narrow_hills_away_and_top_hat_keeps_them():
    assert row(opening(X, 3)) == [0, 0, 0, 0, 0, 3, 3, 3, 3, 0, 0, 0]
    assert row(top_hat(X, 3)) == [0, 0, 5, 0, 0, 0, 0, 0, 0, 0, 1, 0]


def test_closing_fills_narrow_valleys():
    assert row(closing(X, 3)) == [0, 0, 5, 3, 3, 3, 3, 3, 3, 1, 1, 1]


def test_as_printed_exchanges_the_two():
    assert row(erosion(X, 3, as_printed=True)) == row(dilation(X, 3))
    assert row(opening(X, 3, as_printed=True)) == row(closing(X, 3))
    assert (top_hat(X, 3, as_printed=True) <= 0).all()


def jumps_at(*events, n=200):
    jumps = np.zeros(n)
    for frame, size in events:
        jumps[frame] = size
    return jumps


def test_a_jump_and_the_jump_back():
    jumps = jumps_at((40, 5.0), (90, -4.0))
    assert derivative_pairs(jumps, 3.0, 20, 100, 6) == [(Span(40, 90), 4.0)]
    assert derivative_pairs(jumps, 4.5, 20, 100, 6) == []
    assert derivative_pairs(jumps, 3.0, 60, 100, 6) == []
    assert derivative_pairs(jumps, 3.0, 20, 40, 6) == []


def test_same_direction_is_no_pair():
    assert derivative_pairs(jumps_at((40, 5.0), (90, 4.0)), 3.0, 20, 100, 6) == []


def test_a_pair_used_is_used_up():
    jumps = jumps_at((20, 5.0), (60, -5.0), (100, 5.0), (140, -5.0))
    spans = [span for span, _ in derivative_pairs(jumps, 3.0, 20, 100, 6)]
    assert spans == [Span(20, 60), Span(100, 140)]


def test_echoes_of_the_filter_do_not_count():
    jumps = jumps_at((40, 9.0), (42, -4.0), (90, -9.0), (88, 4.0))
    assert derivative_pairs(jumps, 3.0, 20, 100, 6) == [(Span(40, 90), 9.0)]
