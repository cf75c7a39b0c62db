"""A policy repairs what it names, within its limits, and nothing else."""

import json
from pathlib import Path

import numpy as np
import pytest

import markermend as mm
from markermend.batch.policy import Policy, Rule, mend_by, read_policy
from markermend.detection import gaps
from markermend.errors import BadDecisions, BadInput, BadParameter, UnknownName
from markermend.review.decisions import decisions_on
from markermend.review.mending import mend

from .conftest import small_take


@pytest.mark.parametrize(
    ("said", "kinds"),
    [("gap", ("gap",)), ("gaps", ("gap",)), ("peak, gap", ("gap", "peak")), ("slow", ("slow",))],
)
def test_words_name_kinds(said: str, kinds: tuple[str, ...]):
    policy = read_policy(said)
    assert policy.kinds == kinds
    assert all(rule == Rule() for rule in policy.rules.values())


@pytest.mark.parametrize("said", ["", "all", "gap,hole", "gap peak"])
def test_other_words_are_refused(said: str):
    with pytest.raises(BadInput, match="--repair takes some of gap"):
        read_policy(said)


def policy_file(folder: Path, repair: object, **more: object) -> str:
    path = folder / "policy.json"
    content = {"schema": "markermend/policy", "version": 1, "repair": repair, **more}
    path.write_text(json.dumps(content))
    return str(path)


def test_a_file_says_methods_and_limits_and_reads_back(tmp_path: Path):
    rule = {"method": "linear", "most_mm": 4, "most_s": 0.5}
    policy = read_policy(policy_file(tmp_path, {"gap": rule, "peak": {}}), most_mm=2.0)
    assert policy.rules == {
        "gap": Rule("linear", {}, 4.0, 0.5),
        "peak": Rule("", {}, 2.0, None),
    }
    (tmp_path / "again.json").write_text(json.dumps(policy.to_json()))
    assert read_policy(str(tmp_path / "again.json")) == policy


@pytest.mark.parametrize(
    ("repair", "error", "says"),
    [
        ({}, BadDecisions, "an object with a rule"),
        ({"hole": {}}, UnknownName, "no kind 'hole'"),
        ({"gap": {"method": "magic"}}, UnknownName, "no repair method 'magic'"),
        ({"gap": {"most": 3}}, UnknownName, "no field of a rule"),
        ({"gap": {"most_mm": -1}}, BadDecisions, "most_mm must be"),
        ({"gap": {"parameters": {"window": 3}}}, BadDecisions, "beside the method"),
        (
            {"gap": {"method": "savgol", "parameters": {"window": 1}}},
            BadParameter,
            "window must be",
        ),
    ],
)
def test_what_a_file_gets_wrong_is_named(
    tmp_path: Path, repair: object, error: type[Exception], says: str
):
    with pytest.raises(error, match=says):
        read_policy(policy_file(tmp_path, repair))


def test_a_file_of_a_newer_version_is_refused(tmp_path: Path):
    with pytest.raises(BadInput, match="newer version"):
        read_policy(policy_file(tmp_path, {"gap": {}}, version=2))


def inner(take: mm.Take) -> list[tuple[str, mm.Span]]:
    return [
        (f.marker, f.span) for f in gaps(take) if f.span.start > 0 and f.span.stop < take.n_frames
    ]


def test_inner_gaps_are_repaired_and_nothing_else_changes():
    take = small_take(3)
    review, mended, stays = mend_by(read_policy("gap"), take, gaps(take))
    assert [(r.marker, r.span) for r in mended.repairs] == inner(take)
    assert stays == ()
    same = np.ones((take.n_frames, take.n_markers), bool)
    for marker, span in inner(take):
        same[span.frames, take.index(marker)] = False
    np.testing.assert_array_equal(mended.repaired.positions[same], take.positions[same])
    assert np.isfinite(mended.repaired.positions[~same]).all()
    assert review.counts().accepted == len(mended.repairs)


@pytest.mark.parametrize("most", [0.0, 1e-3, 5.0, 1e3])
def test_no_repair_expects_to_be_further_off_than_allowed(most: float):
    take = small_take(5)
    policy = Policy({"gap": Rule("auto", most_mm=most)})
    review, mended, stays = mend_by(policy, take, gaps(take))
    assert all(r.expected_mm is not None and r.expected_mm <= most for r in mended.repairs)
    assert len(mended.repairs) + len(stays) == len(inner(take))
    assert review.counts().deferred == len(stays)
    for stay in stays:
        there = take.positions[stay.wish.span.frames, take.index(stay.wish.marker)]
        kept = mended.repaired.positions[stay.wish.span.frames, take.index(stay.wish.marker)]
        np.testing.assert_array_equal(kept, there)


def test_a_method_that_cannot_say_how_far_off_it_is_repairs_nothing_under_a_limit():
    take = small_take(5)
    _, mended, stays = mend_by(Policy({"gap": Rule("linear", most_mm=1e6)}), take, gaps(take))
    assert mended.repairs == ()
    assert "cannot say" in stays[0].reason


def test_long_spans_stay():
    take = small_take(5)
    ((_, span),) = inner(take)
    seconds = len(span) / take.rate
    for most, n in ((seconds, 1), (seconds - 0.01, 0)):
        _, mended, stays = mend_by(Policy({"gap": Rule(most_s=most)}), take, gaps(take))
        assert (len(mended.repairs), len(stays)) == (n, 1 - n)


def test_its_decisions_make_the_same_take_again():
    take = small_take(7)
    review, mended, _ = mend_by(Policy({"gap": Rule("auto", most_mm=1e3)}), take, gaps(take))
    decisions = decisions_on(take, review, repairs=mended.repairs)
    again = mend(take, decisions.wishes(take))
    np.testing.assert_array_equal(again.repaired.positions, mended.repaired.positions)
