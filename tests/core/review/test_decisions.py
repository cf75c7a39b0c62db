"""The decision file: nothing is lost in it, nothing in it is believed."""

import contextlib
import copy
import errno
import json
import os
import stat
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from markermend.errors import BadDecisions, BadParameter, CannotWrite, UnknownName
from markermend.model import AXES, KINDS, Finding, Source, Span, Take
from markermend.repairing.run import apply, repair_all
from markermend.review import VERDICTS, Accept, Annotate, Decision, Judgement, Reject, Review, Split
from markermend.review.decisions import (
    Decisions,
    decisions_on,
    parse_decisions,
    read_decisions,
)
from markermend.review.session import ReviewSession
from markermend.review.state import plain
from markermend.review.store import Store

GAP = Finding("A", Span(40, 60), "gap", detector="gaps")
PEAK = Finding("A", Span(120, 123), "peak", 0.9, ("z",), 30.0, "published", 2.5)

finite = st.floats(allow_nan=False, allow_infinity=False)
spans = st.integers(0, 300).flatmap(lambda a: st.integers(a + 1, 400).map(lambda b: Span(a, b)))
values = st.one_of(st.integers(), finite, st.booleans(), st.text(max_size=9))
decisions = st.builds(
    Decision,
    st.sampled_from([*VERDICTS, None]),
    st.sampled_from([*KINDS, None]),
    st.none() | spans,
    st.text(max_size=9),
    st.dictionaries(st.text(max_size=9), values, max_size=3),
    st.text(max_size=20),
)
findings = st.builds(
    Finding,
    st.text(max_size=9),
    spans,
    st.sampled_from(KINDS),
    st.floats(0, 1),
    st.lists(st.sampled_from(AXES), unique=True).map(tuple),
    st.none() | st.floats(-1e6, 1e6),
    st.text(max_size=9),
    st.floats(0, 1e6),
    st.none() | st.text(max_size=9),
    st.none() | st.text(max_size=9),
).map(plain)
judgements = st.builds(Judgement, findings, decisions, st.booleans())
reviews = st.lists(judgements, max_size=5, unique_by=lambda j: j.finding.id).map(
    lambda some: Review({j.finding.id: j for j in some})
)
junk = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=9),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=9), inner),
    max_leaves=5,
)


def flat(n_frames: int = 400) -> Take:
    return Take(np.zeros((n_frames, 1, 3)), 100.0, ("A",))


def document(review: Review | None = None) -> dict[str, Any]:
    made = Accept((GAP, PEAK), "pchip", {"k": 1}).apply(Review()) if review is None else review
    return decisions_on(flat(), made).to_json()


@settings(deadline=None)
@given(reviews)
def test_a_review_survives_the_file(review: Review) -> None:
    content = json.dumps(document(review), allow_nan=False).encode()
    read = parse_decisions(content)
    assert read.review == review
    assert list(read.review.judgements) == list(review.judgements)
    assert parse_decisions(json.dumps(read.to_json()).encode()) == read


@settings(deadline=None)
@given(st.binary(max_size=60) | junk.map(lambda value: json.dumps(value).encode()))
def test_anything_else_is_refused(content: bytes) -> None:
    with pytest.raises(BadDecisions):
        parse_decisions(content)


@settings(max_examples=200, deadline=None)
@given(st.data())
def test_a_damaged_file_is_refused_or_harmless(data: st.DataObject) -> None:
    """One value anywhere is exchanged for anything: a sentence or a whole review, nothing else."""
    content = copy.deepcopy(document())
    places = list(_places(content))
    holder, key = data.draw(st.sampled_from(places))
    if data.draw(st.booleans()):
        holder[key] = data.draw(junk)
    else:
        del holder[key]
    try:
        read = parse_decisions(json.dumps(content).encode())
    except BadDecisions as error:
        said = str(error)
    else:
        said = "nothing"
        assert parse_decisions(json.dumps(read.to_json()).encode()) == read
        assert all(wish.span.stop <= read.n_frames for wish in read.review.accepted())
    assert said.isprintable()
    assert len(said) < 1000


def _places(value: Any) -> Any:
    keys = range(len(value)) if isinstance(value, list) else list(value)
    for key in keys:
        yield value, key
        if isinstance(value[key], list | dict):
            yield from _places(value[key])


@pytest.mark.parametrize(
    ("path", "value", "match"),
    [
        (("schema",), "other", "no file of decisions"),
        (("version",), 2, "newer markermend .version 2, this one reads 1.; update"),
        (("version",), True, "whole number"),
        (("take",), [], "must be an object; got a list"),
        (("take", "n_frames"), 100, "Finding 1 ends at frame 123, and the take has 100"),
        (("take", "rate"), 0, "rate must be a number"),
        (("findings",), {}, "must be a list"),
        (("findings", 0, "kind"), "jump", "Finding 0: kind must be one of gap, peak"),
        (("findings", 0, "stop"), 40, "stop must be a whole number in 41"),
        (("findings", 0, "stop"), 10**400, "a number beyond all bounds"),
        (("findings", 0, "score"), 1.5, "score must be a number in 0 to 1"),
        (("findings", 0, "score"), float("nan"), "no JSON"),
        (("findings", 0, "axes"), ["x", "w"], "among x, y, z"),
        (("findings", 0, "id"), "0" * 12, "has the id '000000000000', but"),
        (("findings", 0, "marker"), "M" * 10_001, "text of at most 10000 characters"),
        (("findings", 0, "replaced_by"), ["0" * 12], "not in the file"),
        (("findings", 0, "decided"), "2024-02-30", "a date and time"),
        (("findings", 0, "decided"), "2024-02-03T10:00:00", "with its zone"),
        (("findings", 0, "decision", "verdict"), "maybe", "verdict must be one of accepted"),
        (("findings", 0, "decision", "span"), [40], "start, stop. or null"),
        (("findings", 0, "decision", "span"), [50, 45], "whole number in 51"),
        (("findings", 0, "decision", "parameters"), {"k": [[[]]]}, "texts and numbers by name"),
        (("findings", 0, "decision", "parameters"), {"k": 10**5000}, "no JSON"),
        (("findings", 0, "decision"), "accepted", "decision of Finding 0 must be an object"),
    ],
)
def test_the_refusal_names_the_field(path: tuple[Any, ...], value: Any, match: str) -> None:
    content = document()
    holder: Any = content
    for key in path[:-1]:
        holder = holder[key]
    holder[path[-1]] = "TO BE REPLACED"
    # 10**5000 is beyond what Python writes, and a file may hold it all the same.
    text = json.dumps(content).replace('"TO BE REPLACED"', _written(value))
    with pytest.raises(BadDecisions, match=match):
        parse_decisions(text.encode())


def _written(value: Any) -> str:
    if value == {"k": 10**5000}:
        return '{"k": 1' + "0" * 5000 + "}"
    return json.dumps(value)


def test_deep_and_huge_files_are_refused(tmp_path: Path) -> None:
    with pytest.raises(BadDecisions, match="no JSON"):
        parse_decisions(b"[" * 200_000)
    path = tmp_path / "huge.json"
    with path.open("wb") as file:
        file.truncate(65 * 2**20)
    with pytest.raises(BadDecisions, match="larger than 64 MB"):
        read_decisions(path)


def test_a_finding_twice_is_refused() -> None:
    content = document()
    content["findings"].append(content["findings"][0])
    with pytest.raises(BadDecisions, match="stands twice"):
        parse_decisions(json.dumps(content).encode())


def test_unknown_fields_are_passed_over() -> None:
    content = document()
    content["colour"] = content["findings"][0]["mood"] = {"blue": [1]}
    assert (
        parse_decisions(json.dumps(content).encode()).review
        == parse_decisions(json.dumps(document()).encode()).review
    )


def test_the_export_can_be_made_again_to_the_byte(take: Take, tmp_path: Path) -> None:
    """Defaults are written down as what they became, so that later defaults change nothing."""
    review = Accept((GAP,)).apply(Review())
    review = Reject((replace(PEAK, span=Span(10, 12)),)).apply(review)
    review = Accept((PEAK,), "linear").apply(review)
    repairs, refusals = repair_all(take, review.accepted())
    assert len(repairs) == 2
    assert refusals == ()
    path = tmp_path / "walk.decisions.json"
    decisions_on(take, review, repairs=repairs).write(path)

    wishes = read_decisions(path).wishes(take)
    assert all(wish.method for wish in wishes)
    again, _ = repair_all(take, wishes)
    first, second = apply(take, repairs), apply(take, again)
    assert first.positions.tobytes() == second.positions.tobytes()
    assert not np.array_equal(first.positions, take.positions, equal_nan=True)


def test_the_file_says_who_decided_when_and_what_error_to_expect(
    store: Store, take: Take, tmp_path: Path
) -> None:
    session = ReviewSession.open(store, take, "anna")
    session.do(Accept((GAP,), "linear"))
    session.do(Split((PEAK,), 121))
    session.do(Annotate((GAP,), "hidden by the arm, ä"))
    repairs, _ = repair_all(take, session.review.accepted())
    repairs = tuple(replace(repair, expected_mm=1.25) for repair in repairs)
    written = datetime(2024, 2, 3, 4, 5, 6, tzinfo=UTC)
    path = tmp_path / "d.json"
    decisions_on(
        take, session.review, repairs=repairs, decided=session.decided, written=written
    ).write(path)
    read = read_decisions(path)
    assert read.written == written
    gap, *rest = read.findings
    assert (gap.operator, gap.at) == ("anna", session.history.steps[-1].at)
    assert gap.expected_mm == 1.25
    assert gap.judgement.decision.note == "hidden by the arm, ä"
    assert [d.judgement.added for d in rest] == [False, True, True]
    assert rest[0].judgement.replaced_by == tuple(d.judgement.finding.id for d in rest[1:])


def made_on(take: Take) -> Decisions:
    return decisions_on(take, Accept((GAP,), "linear").apply(Review()))


def test_decisions_on_another_take_are_refused(take: Take) -> None:
    with pytest.raises(BadDecisions, match="give the take they were made on"):
        made_on(take).wishes(take.with_positions(take.positions + 1))


def test_decisions_on_a_take_read_otherwise_are_refused(take: Take) -> None:
    source = Source(Path("walk.c3d"), "c3d", "a" * 64, "mm", 100.0)
    made = made_on(replace(take, source=source))
    with pytest.raises(BadDecisions, match="in mm, and the take was read at 100 Hz in m;"):
        made.wishes(replace(take, source=replace(source, units="m")))
    with pytest.raises(BadDecisions, match="read at 120 Hz"):
        made.wishes(replace(take, source=source, rate=120.0))
    with pytest.raises(BadDecisions, match="for 200 frames, and the take has 199"):
        made.wishes(replace(take, source=source, positions=take.positions[:-1]))


@pytest.mark.parametrize(
    ("finding", "method", "parameters", "error"),
    [
        (replace(GAP, marker="Z"), "linear", {}, UnknownName),
        (GAP, "teleport", {}, UnknownName),
        (GAP, "linear", {"speed": 1}, UnknownName),
        (GAP, "savgol", {"window": -5}, BadParameter),
    ],
)
def test_what_cannot_be_repaired_here_is_said_before_anything_is_computed(
    take: Take, finding: Finding, method: str, parameters: dict[str, Any], error: type[Exception]
) -> None:
    review = Accept((finding,), method, parameters).apply(Review())
    with pytest.raises(error):
        decisions_on(take, review).wishes(take)


def test_a_file_that_cannot_be_written_or_read_is_refused(take: Take, tmp_path: Path) -> None:
    with pytest.raises(CannotWrite, match="choose another place"):
        made_on(take).write(tmp_path / "absent" / "d.json")
    with pytest.raises(BadDecisions, match="cannot be read"):
        read_decisions(tmp_path / "d.json")


def test_a_write_that_fails_leaves_the_old_file(
    take: Take, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "d.json"
    path.write_text("the old one")

    def full(_: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    with pytest.raises(CannotWrite, match="No space left"):
        made_on(take).write(path)
    assert path.read_text() == "the old one"
    assert [p.name for p in tmp_path.iterdir()] == ["d.json"]


@pytest.mark.skipif(os.name != "posix", reason="only POSIX systems confirm names by the folder")
@pytest.mark.parametrize("code", [errno.EIO, errno.EINVAL])
def test_a_name_that_the_disk_does_not_confirm_is_said_as_it_is(
    take: Take, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, code: int
) -> None:
    path, real = tmp_path / "d.json", os.fsync

    def odd(handle: int) -> None:
        if stat.S_ISDIR(os.fstat(handle).st_mode):
            raise OSError(code, os.strerror(code))
        real(handle)

    monkeypatch.setattr("os.fsync", odd)
    refused = pytest.raises(CannotWrite, match="is written, but the disk does not confirm its name")
    with refused if code == errno.EIO else contextlib.nullcontext():
        made_on(take).write(path)
    assert read_decisions(path).review == made_on(take).review
