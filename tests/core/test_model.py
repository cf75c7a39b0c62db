"""Takes, spans and findings: frozen, checked at the door, and recognised by content."""

import dataclasses
import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import markermend as mm
from markermend.errors import BadInput, UnknownName
from markermend.model import runs, short

FRAMES = st.integers(0, 200)


def spans() -> st.SearchStrategy[mm.Span]:
    return st.tuples(FRAMES, st.integers(1, 50)).map(lambda p: mm.Span(p[0], p[0] + p[1]))


@given(spans(), spans())
def test_overlap_and_iou_agree_with_sets_of_frames(a: mm.Span, b: mm.Span):
    one, two = set(range(a.start, a.stop)), set(range(b.start, b.stop))
    assert a.overlaps(b) == bool(one & two)
    assert a.iou(b) == pytest.approx(len(one & two) / len(one | two))
    assert len(a) == len(one)


@given(st.lists(st.booleans(), max_size=60))
def test_runs_rebuild_the_mask(mask: list[bool]):
    again = np.zeros(len(mask), bool)
    found = runs(np.array(mask, bool))
    for span in found:
        again[span.frames] = True
    assert again.tolist() == mask
    assert all(a.stop < b.start for a, b in itertools.pairwise(found)), "none touch"


@pytest.mark.parametrize(("start", "stop"), [(3, 3), (4, 2), (-1, 5)])
def test_no_span_is_empty_or_negative(start: int, stop: int):
    with pytest.raises(BadInput):
        mm.Span(start, stop)


def test_a_take_is_frozen_and_its_own_copy():
    given_positions = np.zeros((4, 2, 3))
    take = mm.Take(given_positions, 100, ["A", "B"])
    given_positions[0] = 7
    assert take.positions[0].max() == 0
    with pytest.raises(ValueError, match="read-only"):
        take.positions[0] = 1
    with pytest.raises(dataclasses.FrozenInstanceError):
        take.rate = 5


@pytest.mark.parametrize(("units", "factor"), [("mm", 1), ("cm", 10), ("m", 1000)])
def test_positions_are_mm_in_memory(units: str, factor: float):
    take = mm.Take(np.ones((2, 1, 3)), 50, ["A"], units)
    assert take.units == "mm"
    assert take.positions.max() == factor
    assert take.with_positions(take.positions).positions.max() == factor


def test_one_unknown_coordinate_makes_the_marker_unseen():
    positions = np.ones((3, 1, 3))
    positions[1, 0, 2] = np.inf
    take = mm.Take(positions, 100, ["A"])
    assert take.seen[:, 0].tolist() == [True, False, True]
    assert np.isnan(take.positions[1]).all()
    assert list(take.gaps("A")) == [(mm.Span(1, 2), True)]


@pytest.mark.parametrize(
    "bad",
    [
        {"positions": np.zeros((3, 2))},
        {"positions": np.zeros((3, 2, 4))},
        {"labels": ["A"]},
        {"labels": ["A", "A"]},
        {"rate": 0},
        {"rate": float("nan")},
        {"units": "inch"},
        {"units": "px"},
        {"positions": np.zeros((3, 2, 2))},
        {"roles": ["measured"]},
    ],
)
def test_what_does_not_fit_is_refused_in_a_sentence(bad: dict[str, object]):
    good = {"positions": np.zeros((3, 2, 3)), "rate": 100, "labels": ["A", "B"], "units": "mm"}
    with pytest.raises(BadInput, match=r"\.$"):
        mm.Take(**{**good, **bad})


def test_roles_are_told_apart_by_labels():
    take = mm.Take(np.zeros((2, 3, 3)), 100, ["A", "*12", "Bob:*3"])
    assert take.roles == ("measured", "unlabelled", "unlabelled")
    assert take.measured.tolist() == [0]
    assert short("Bob:LASI") == "LASI"


def test_unknown_markers_are_named_with_those_known():
    take = mm.Take(np.zeros((2, 1, 3)), 100, ["A"])
    with pytest.raises(UnknownName, match="'B'; known are A"):
        take.index("B")


def test_content_makes_the_identity_of_a_take():
    one = mm.Take(np.zeros((2, 1, 3)), 100, ["A"])
    assert one.content_hash == mm.Take(np.zeros((2, 1, 3)), 100, ["A"]).content_hash
    assert one.content_hash != mm.Take(np.ones((2, 1, 3)), 100, ["A"]).content_hash
    assert one.content_hash != mm.Take(np.zeros((2, 1, 3)), 50, ["A"]).content_hash


def test_a_finding_keeps_its_id_whatever_is_measured_of_it():
    finding = mm.Finding("A", mm.Span(3, 9), "peak", 0.7, ("x",), 12.5, "one")
    again = mm.Finding("A", mm.Span(3, 9), "peak", 0.9, ("x", "y"), 13.0, "two")
    assert finding.id == again.id
    assert finding.id != mm.Finding("A", mm.Span(3, 10), "peak").id
    assert mm.Finding.from_json(finding.to_json()) == finding


def test_a_finding_of_no_known_kind_is_refused():
    with pytest.raises(UnknownName):
        mm.Finding("A", mm.Span(0, 1), "wobble")
