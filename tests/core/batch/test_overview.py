"""Sums over an archive: nothing is lost between takes, markers, kinds and the picture."""

from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from markermend.batch.overview import MOST_COLUMNS, Overview
from markermend.batch.records import Line
from markermend.batch.work import summarise
from markermend.model import KINDS, Finding, Span, Take

MARKERS = ("A", "B", "C")
CELLS = st.dictionaries(
    st.sampled_from(KINDS),
    st.tuples(st.integers(1, 9), st.floats(0, 100)).map(list),
    min_size=1,
    max_size=3,
)
BY = st.dictionaries(st.sampled_from(MARKERS), CELLS, max_size=3)


def line(name: str, by: dict, duration_s: float = 5.0) -> Line:
    cells = [cell for row in by.values() for cell in row.values()]
    summary = {
        "duration_s": duration_s,
        "markers": list(MARKERS),
        "n_findings": sum(n for n, _ in cells),
        "damage": sum(size for _, size in cells),
        "by": by,
    }
    return Line(name, "done", "", summary)


def seen(lines: list[Line]) -> Overview:
    return Overview(
        Path("/archive"), tuple(lines), {"detector": "x"}, datetime(2026, 1, 1, tzinfo=UTC)
    )


@settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.lists(BY, min_size=1, max_size=6))
def test_takes_markers_kinds_and_picture_have_the_same_damage(everything: list[dict]):
    lines = [line(f"{i:02}.c3d", by) for i, by in enumerate(everything)]
    archive = seen(lines)
    damage = sum(one.summary["damage"] for one in lines)
    n = sum(one.summary["n_findings"] for one in lines)
    for sums in (archive.kinds.values(), [marker.total for marker in archive.markers]):
        assert sum(one.damage for one in sums) == pytest.approx(damage)
        assert sum(one.n_findings for one in sums) == n
    assert 5.0 * np.nansum(archive.picture.mm) == pytest.approx(damage)
    sizes = [one.summary["damage"] for one in archive.worst_first]
    assert sizes == sorted(sizes, reverse=True)
    assert list(archive.picture.takes) == [(one.name,) for one in lines]


def test_many_takes_share_columns_and_none_is_left_out():
    n = 2 * MOST_COLUMNS + 7
    lines = [line(f"{i:05}.c3d", {"A": {"gap": [1, 1.0]}}) for i in range(n)]
    picture = seen(lines).picture
    assert len(picture.takes) == MOST_COLUMNS
    assert [name for names in picture.takes for name in names] == [one.name for one in lines]
    row = picture.mm[picture.markers.index("A")]
    np.testing.assert_allclose(row, 1.0 / 5.0)  # the mean, however many share a column


def test_a_marker_that_is_not_in_a_take_is_blank_there():
    there, absent = line("1.c3d", {"A": {"peak": [1, 2.0]}}), line("2.c3d", {})
    absent.summary["markers"].remove("A")
    picture = seen([there, absent]).picture
    row = picture.mm[picture.markers.index("A")]
    assert row[0] == pytest.approx(0.4)
    assert np.isnan(row[1])
    (first, *_) = seen([there, absent]).markers
    assert (first.marker, first.n_takes, first.total.n_takes) == ("A", 1, 1)


def test_failures_come_before_refusals_and_neither_has_damage():
    archive = seen(
        [Line("a", "refused", "no unit", {}), line("b", {}), Line("c", "failed", "died", {})]
    )
    assert [one.name for one in archive.not_done] == ["c", "a"]
    assert [one.name for one in archive.worst_first] == ["b"]


def test_a_take_is_summed_up_by_the_damage_that_orders_a_queue():
    take = Take(np.zeros((100, 3, 3)), 50, ["S:A", "S:B", "*3"])
    found = [
        Finding("S:A", Span(10, 11), "peak", score=0.5, amplitude=30.0),
        Finding("S:A", Span(0, 20), "gap"),
        Finding("S:B", Span(20, 45), "gap"),
    ]
    summary = summarise(take, found)
    assert summary["markers"] == ["A", "B"]
    # 30 mm over 1 frame of 20 ms, half sure; a gap at the end does no damage; a gap of half a
    # second is sized by its duration, 20 mm at most.
    assert summary["by"] == {
        "A": {"peak": [1, pytest.approx(0.3)], "gap": [1, 0.0]},
        "B": {"gap": [1, pytest.approx(10.0)]},
    }
    assert (summary["n_findings"], summary["damage"]) == (3, pytest.approx(10.3))
    assert summary["duration_s"] == 2.0
