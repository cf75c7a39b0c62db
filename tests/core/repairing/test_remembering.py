"""What several methods ask of one problem is computed once, and goes with it."""

import gc
import weakref
from dataclasses import dataclass, replace

import numpy as np
import pytest

from markermend.errors import CannotRepair
from markermend.model import Span
from markermend.repairing.compare import compare
from markermend.repairing.remembering import remembered


@dataclass(frozen=True, eq=False)
class Thing:
    size: float


class Counting:
    def __init__(self) -> None:
        self.calls = []

        @remembered
        def scaled(thing: Thing, factor: float, shift: float = 0.0) -> tuple[Thing, float]:
            self.calls.append((thing.size, factor, shift))
            if factor < 0:
                raise CannotRepair("Too small; choose another.")
            return thing, thing.size * factor + shift

        self.scaled = scaled


def test_each_question_is_answered_once_for_each_object():
    count, one = Counting(), Thing(2.0)
    assert count.scaled(one, 3.0) is count.scaled(one, 3.0)
    assert count.scaled(one, 3.0, shift=1.0)[1] == 7.0
    assert count.scaled(replace(one, size=5.0), 3.0)[1] == 15.0
    assert count.calls == [(2.0, 3.0, 0.0), (2.0, 3.0, 1.0), (5.0, 3.0, 0.0)]


def test_a_refusal_is_not_remembered():
    count, one = Counting(), Thing(2.0)
    for _ in range(2):
        with pytest.raises(CannotRepair):
            count.scaled(one, -1.0)
    assert len(count.calls) == 2


def test_what_is_remembered_goes_with_its_object():
    count, one = Counting(), Thing(2.0)
    count.scaled(one, 3.0)
    gone = weakref.ref(one)
    del one
    gc.collect()
    assert gone() is None


def test_a_method_gives_the_same_alone_and_after_others(lab):
    given = lab.case(truth=lab.walker(400), span=Span(180, 200))
    for row in compare(given.take, given.marker, given.span, ("lpr", "pma", "wpca")).rows:
        alone = given.solve(row.method)
        np.testing.assert_allclose(row.repair.values, alone, rtol=0, atol=1e-9)
