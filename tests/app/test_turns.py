"""Comparisons of many pages take turns among themselves."""

import threading
import time
from concurrent.futures import ThreadPoolExecutor

import pytest

from markermend_app.state.turns import Turns


def test_no_more_compute_at_once_than_have_turns():
    turns, lock = Turns(2), threading.Lock()
    at_once, most = 0, 0

    def compute(n: int) -> int:
        nonlocal at_once, most
        with lock:
            at_once += 1
            most = max(most, at_once)
        time.sleep(0.005)
        with lock:
            at_once -= 1
        return n

    def page(_: int) -> list[int]:
        return list(turns.each(compute(n) for n in range(5)))

    with ThreadPoolExecutor(6) as pages:
        assert list(pages.map(page, range(6))) == [[0, 1, 2, 3, 4]] * 6
    assert most == 2


def test_a_turn_ends_with_whatever_fails_and_whoever_stops_listening():
    turns = Turns(1)
    rows = turns.each(iter((1, 2, 3)))
    assert next(rows) == 1
    rows.close()
    failing = turns.each(1 // n for n in (1, 0))
    assert next(failing) == 1
    with pytest.raises(ZeroDivisionError):
        next(failing)
    assert list(turns.each("ab")) == ["a", "b"]
