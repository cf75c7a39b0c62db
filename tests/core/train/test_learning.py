from collections.abc import Mapping
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from html.parser import HTMLParser

import pytest
from hypothesis import given
from hypothesis import strategies as st

from markermend.model import Kind
from markermend.train import Result, curves, group_table, next_exercise, report, share
from markermend.train.learning import Tally

BEGIN = datetime(2026, 3, 1, 9, tzinfo=UTC)


def result(
    number: int,
    tallies: Mapping[Kind, tuple[int, int]],
    *,
    level: int = 7,
    trainee: str = "ben",
    worse: bool = False,
    pace: float | None = 9.0,
) -> Result:
    """An exercise with ``kind: (right, true)``; everything called was right."""
    return Result(
        trainee,
        number,
        BEGIN + timedelta(days=number),
        level,
        {kind: Tally(true, right, right, 0) for kind, (right, true) in tallies.items()},
        20.0,
        30.0 if worse else 5.0,
        worse,
        pace,
    )


def test_intervals_are_those_of_newcombe() -> None:
    # Newcombe (1998), Statistics in Medicine 17, table I, method 3.
    for right, of, low, high in (
        (81, 263, 0.2553, 0.3662),
        (15, 148, 0.0624, 0.1605),
        (0, 20, 0.0, 0.1611),
        (1, 29, 0.0061, 0.1718),
    ):
        found = share(right, of)
        assert (found.low, found.high) == pytest.approx((low, high), abs=1e-4)
    assert (share(0, 0).value, share(0, 0).low, share(0, 0).high) == (None, 0.0, 1.0)


@pytest.mark.parametrize("n", range(7))
def test_no_line_runs_through_two_points(n: int) -> None:
    done = [result(i, {"peak": (i % 4, 4)}) for i in range(n)]
    found = curves(done)
    assert len(found["peak"].points if found else ()) == n
    line = found["peak"].line if found else ()
    assert len(line) == max(0, n - 2)
    if n >= 3:
        assert (line[0].right, line[0].of) == (0 + 1 + 2, 12)


def test_a_curve_holds_only_exercises_with_its_kind() -> None:
    done = [
        result(1, {"peak": (1, 4)}),
        result(2, {"step": (2, 2), "peak": (0, 0)}),
        result(3, {"peak": (3, 4)}),
    ]
    found = curves(done)
    assert [p.exercise for p in found["peak"].points] == [1, 3]
    assert [p.share.value for p in found["peak"].points] == [0.25, 0.75]
    assert list(found) == ["peak", "step"]
    record = found["peak"].to_json()
    assert record["points"][0]["low"] == share(1, 4).low
    assert record["line"] == []


def test_everybody_begins_with_one_obvious_peak() -> None:
    assert (next_exercise([]).level, next_exercise([]).kinds) == (1, ("peak",))
    only_real = [result(1, {"slow": (0, 5)}, level=0)]
    assert next_exercise(only_real).level == 1


@pytest.mark.parametrize(
    ("right", "worse", "level"),
    [(10, False, 6), (8, False, 6), (10, True, 5), (7, False, 5), (4, False, 4)],
)
def test_who_does_well_goes_up_and_who_does_not_goes_down(
    right: int, worse: bool, level: int
) -> None:
    done = [result(1, {"peak": (right, 10)}, level=5, worse=worse)]
    assert next_exercise(done).level == level


def test_levels_end_at_both_ends() -> None:
    assert next_exercise([result(1, {"peak": (5, 5)}, level=9)]).level == 9
    assert next_exercise([result(1, {"peak": (0, 5)}, level=1)]).level == 1


def test_the_weakest_kind_comes_next() -> None:
    mixed: dict[Kind, tuple[int, int]] = {
        "gap": (4, 4),
        "peak": (4, 4),
        "noise": (3, 4),
        "step": (3, 4),
        "slow": (1, 4),
    }
    chosen = next_exercise([result(1, mixed)])
    assert chosen.kinds == ("slow",)
    assert "slow: 1 of 4" in chosen.why
    never = {kind: pair for kind, pair in mixed.items() if kind != "noise"}
    assert next_exercise([result(1, never)]).kinds == ("noise",)
    # An exercise of one kind is followed by one of all, once there are such.
    assert len(next_exercise([result(1, mixed), result(2, {"slow": (2, 3)})]).kinds) == 5


@given(
    st.lists(
        st.builds(
            result,
            st.integers(0, 99),
            st.dictionaries(
                st.sampled_from(["gap", "peak", "noise", "step", "slow"]),
                st.integers(0, 9).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n))),
            ),
            level=st.integers(0, 9),
            worse=st.booleans(),
        )
    )
)
def test_there_is_always_a_next_exercise_one_level_off_at_most(done: list[Result]) -> None:
    chosen = next_exercise(done)
    graded = [r.level for r in done if r.level]
    assert 1 <= chosen.level <= 9
    assert abs(chosen.level - (graded[-1] if graded else 1)) <= 1
    assert chosen.kinds
    assert chosen.why.endswith((".", "!"))


def test_a_group_at_a_glance() -> None:
    done = [
        result(1, {"peak": (1, 4)}, trainee="zoe", worse=True, pace=None),
        result(2, {"peak": (4, 4)}, trainee="ben"),
        result(3, {"peak": (2, 4)}, trainee="zoe", pace=12.0),
    ]
    ben, zoe = group_table(done)
    assert (ben.trainee, zoe.trainee) == ("ben", "zoe")
    assert (zoe.exercises, zoe.worse.right, zoe.worse.of) == (2, 1, 2)
    assert (zoe.found["peak"].right, zoe.found["peak"].of) == (3, 8)
    assert zoe.seconds_per_finding == 12.0
    assert zoe.to_json()["found"]["peak"]["low"] == share(3, 8).low
    assert group_table([]) == ()


class Page(HTMLParser):
    """Collects what a page would ask for, its text, and whether its tags close."""

    VOID = ("meta", "line", "circle", "polyline", "polygon")
    LOOSE = ("th", "tr", "td")

    def __init__(self, page: str) -> None:
        super().__init__()
        self.asks: list[str] = []
        self.tags: list[str] = []
        self.open: list[str] = []
        self.text = ""
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        asking = ("src", "href", "srcset", "action", "data", "xlink:href", "background")
        self.asks += [str(value) for name, value in attrs if name in asking]
        self.asks += [name for name, _ in attrs if name.startswith("on")]
        if tag not in (*self.VOID, *self.LOOSE):
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        if tag not in (*self.VOID, *self.LOOSE):
            assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data


def test_a_report_is_one_page_that_asks_for_nothing() -> None:
    done = [result(i, {"peak": (i % 4, 4), "slow": (1, 2)}, level=i + 1) for i in range(5)]
    text = report(done)
    page = Page(text)
    assert page.asks == []
    assert page.open == []
    assert not {"script", "link", "img", "iframe", "object"} & set(page.tags)
    assert "url(" not in text
    assert "@import" not in text
    assert "http:" not in text
    assert "https:" not in text
    assert "default-src 'none'" in text
    assert page.tags.count("svg") == 2
    assert page.tags.count("polyline") == page.tags.count("polygon") == 2
    assert page.tags.count("circle") == 10
    assert "left worse than it was in 0 of 5" in page.text
    two = Page(report(done[:2]))
    assert (two.tags.count("circle"), two.tags.count("polyline")) == (4, 0)


def test_names_in_a_report_are_only_names() -> None:
    evil = "<script src=https://x.y/z.js>&\"'</title>"
    done = [replace(result(1, {"peak": (1, 4)}), trainee=evil)]
    page = Page(report(done))
    assert "script" not in page.tags
    assert page.asks == []
    assert page.text.count(evil) == 2  # title and heading


def test_an_expert_take_says_so_in_a_report() -> None:
    text = report([result(1, {"peak": (1, 4)}, level=0)])
    assert "real take" in text
