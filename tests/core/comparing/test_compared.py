import json

import krippendorff
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.metrics import cohen_kappa_score

import markermend as mm
from markermend.comparing import adjudication, agreement, cases, table2, taken_over
from markermend.comparing.compared import SPAN_CLASSES
from markermend.comparing.differing import difference
from markermend.comparing.grouping import groups, sayings
from markermend.errors import BadDecisions, BadInput
from markermend.evaluate.matching import overlap, pairs
from markermend.evaluate.scores import CLASSES
from markermend.model import Finding, Kind, Span, Take
from markermend.review import Adopt, Decision, Judgement, Review
from markermend.review.decisions import decisions_on
from markermend.truth import Truth

KINDS: tuple[Kind, ...] = ("peak", "noise", "step", "slow")
N_FRAMES = 300


def made_take() -> Take:
    rng = np.random.default_rng(3)
    t = np.arange(N_FRAMES) / 100
    centre = np.column_stack([200 * np.sin(2 * t), 80 * np.cos(t), 900 + 30 * np.sin(3 * t)])
    positions = (
        centre[:, None] + rng.normal(0, 80, (1, 5, 3)) + rng.normal(0, 0.1, (N_FRAMES, 5, 3))
    )
    return Take(positions, 100, ["A", "B", "C", "D", "E"])


TAKE = made_take()


def judged(
    marker: str, start: int, stop: int, kind: Kind, verdict: str | None = "accepted", **more: object
) -> Judgement:
    decision = Decision(verdict, method="linear", **more)  # type: ignore[arg-type]
    return Judgement(Finding(marker, Span(start, stop), kind), decision)


def review_of(*judgements: Judgement) -> Review:
    return Review({judgement.finding.id: judgement for judgement in judgements})


@st.composite
def reviews(draw: st.DrawFn) -> Review:
    """Reviews whose accepted spans do not overlap on a marker."""
    found = []
    for marker in "ABC":
        edges = sorted(draw(st.sets(st.integers(1, N_FRAMES - 1), max_size=6)))
        for start, stop in zip(edges[::2], edges[1::2], strict=False):
            verdict = draw(st.sampled_from(["accepted", "accepted", "rejected", "deferred", None]))
            found.append(judged(marker, start, stop, draw(st.sampled_from(KINDS)), verdict))
    return review_of(*found)


def labels_of(review: Review) -> np.ndarray:
    """Class of every sample, written out one by one."""
    table = np.zeros((TAKE.n_markers, N_FRAMES), int)
    for judgement in review:
        if judgement.decision.verdict == "accepted":
            for frame in range(judgement.span.start, judgement.span.stop):
                table[TAKE.index(judgement.finding.marker), frame] = CLASSES.index(judgement.kind)
    return table.ravel()


@settings(max_examples=40, deadline=None)
@given(reviews(), reviews())
def test_coefficients_over_samples_are_those_of_others_on_the_same_samples(
    one: Review, other: Review
) -> None:
    result = agreement({"ann": one, "ben": other}, TAKE)
    mine, theirs = labels_of(one), labels_of(other)
    (pair,) = result.pairs
    if len(set(mine) | set(theirs)) == 1:
        assert pair.kappa_samples is None
        assert result.alpha_samples is None
        return
    assert pair.kappa_samples == pytest.approx(cohen_kappa_score(mine, theirs), abs=1e-12)
    alpha = krippendorff.alpha(
        reliability_data=np.array([mine, theirs], float), level_of_measurement="nominal"
    )
    assert result.alpha_samples == pytest.approx(alpha, abs=1e-12)


@settings(max_examples=40, deadline=None)
@given(reviews(), reviews(), reviews())
def test_coefficients_over_spans_are_those_of_others_on_the_same_things(
    one: Review, other: Review, third: Review
) -> None:
    result = agreement([one, other, third], TAKE)
    rows = np.array(
        [[np.nan if s is None else SPAN_CLASSES.index(s) for s in t.said] for t in result.things]
    ).reshape(-1, 3)
    for pair in result.pairs:
        i, j = (int(name) - 1 for name in pair.names)
        known = rows[np.isfinite(rows[:, [i, j]]).all(axis=1)][:, [i, j]].astype(int)
        assert np.sum(pair.spans) == len(known)
        if len(np.unique(known)) > 1:
            assert pair.kappa_spans == pytest.approx(
                cohen_kappa_score(known[:, 0], known[:, 1]), abs=1e-12
            )
        else:
            assert pair.kappa_spans is None
        assert pair.both == sum(np.array(pair.spans)[1:, 1:].ravel())
    twice = rows[np.isfinite(rows).sum(axis=1) >= 2]
    if len(np.unique(twice[np.isfinite(twice)])) > 1:
        alpha = krippendorff.alpha(reliability_data=rows.T, level_of_measurement="nominal")
        assert result.alpha_spans == pytest.approx(alpha, abs=1e-12)
    else:
        assert result.alpha_spans is None


@settings(max_examples=60, deadline=None)
@given(st.lists(reviews(), min_size=1, max_size=4), st.floats(0.1, 1.0))
def test_everything_said_is_in_one_group_and_nobody_twice(
    given_reviews: list[Review], least: float
) -> None:
    people = [sayings(review, KINDS) for review in given_reviews]
    found = groups(people, least, 2)
    for person, said in enumerate(people):
        mine = [group.said[person] for group in found if group.said[person] is not None]
        assert sorted(map(id, mine)) == sorted(map(id, said))
    for group in found:
        assert len({said.marker for said in group.said if said is not None}) == 1


@settings(max_examples=40, deadline=None)
@given(reviews(), reviews())
def test_two_people_are_matched_alike_from_either_side(one: Review, other: Review) -> None:
    (pair,) = agreement([one, other], TAKE).pairs
    (back,) = agreement([other, one], TAKE).pairs
    assert back.accepted == pair.accepted[::-1]
    assert back.kappa_samples == pytest.approx(pair.kappa_samples)
    assert np.array_equal(np.transpose(back.samples), pair.samples)


@settings(max_examples=25, deadline=None)
@given(reviews())
def test_everybody_agrees_with_oneself(review: Review) -> None:
    result = agreement([review, review], TAKE)
    (pair,) = result.pairs
    assert pair.both == pair.same_kind == pair.accepted[0]
    assert pair.kappa_samples in (None, pytest.approx(1.0))
    assert pair.kappa_spans in (None, pytest.approx(1.0))
    assert pair.iou in (None, 1.0)
    assert pair.difference is not None
    assert (pair.difference.differing, pair.difference.only_one) == (0, 0)
    assert all(thing.agreed for thing in result.things)


def test_an_example_by_hand() -> None:
    ann = review_of(
        judged("A", 10, 11, "peak"),
        judged("A", 100, 150, "step"),
        judged("B", 20, 60, "slow"),
        judged("C", 5, 9, "noise", "rejected"),
        judged("D", 50, 70, "slow", "deferred"),
        judged("E", 0, 9, "gap"),
    )
    ben = review_of(
        judged("A", 9, 12, "peak"),  # a peak of one frame with three marked
        judged("A", 105, 160, "slow"),
        judged("B", 70, 90, "slow"),
        judged("C", 5, 9, "noise", "rejected"),
        judged("D", 50, 70, "slow"),
    )
    result = mm.agreement({"ann": ann, "ben": ben}, TAKE)
    (pair,) = result.pairs
    assert (pair.accepted, pair.both, pair.same_kind) == ((3, 4), 2, 1)
    assert pair.found_by_both == 2 / 5
    assert pair.iou == pytest.approx((1 / 3 + 45 / 60) / 2)
    table = np.array(pair.spans)
    expected = np.zeros((5, 5), int)
    expected[1, 1] = expected[3, 4] = expected[4, 0] = expected[0, 4] = expected[0, 0] = 1
    assert np.array_equal(table, expected)  # what ann set aside is no disagreement
    said = {(t.marker, t.span.start): t.said for t in result.things}
    assert said["C", 5] == ("nothing", "nothing")
    assert said["D", 50] == (None, "slow")
    assert said["A", 100] == ("step", "slow")
    assert [(r.human, r.algorithm, r.approved, r.rejected) for r in result.own] == [
        (3, 4, 3, 1),
        (4, 5, 4, 1),
    ]
    assert json.loads(json.dumps(result.to_json(), allow_nan=False))["operators"] == ["ann", "ben"]


def test_differences_are_those_of_the_repaired_trajectories() -> None:
    positions = TAKE.positions
    one, other = positions.copy(), positions.copy()
    one[10:20, 1] += (3.0, 4.0, 0.0)
    other[40:50, 2] = np.nan
    found = difference(TAKE, TAKE.with_positions(one), TAKE.with_positions(other))
    assert (found.samples, found.differing, found.only_one) == (20, 10, 10)
    assert (found.mean_mm, found.rms_mm, found.largest_mm) == pytest.approx((5.0, 5.0, 5.0))
    assert found.where is not None
    assert found.where[0] == "B"
    none = difference(TAKE, TAKE, TAKE)
    assert (none.samples, none.mean_mm, none.where) == (0, None, None)


def test_repairs_by_different_methods_are_apart() -> None:
    ann = review_of(judged("A", 100, 160, "step"))
    rigid = Decision("accepted", method="rigid")
    ben = review_of(Judgement(Finding("A", Span(100, 160), "step"), rigid))
    result = agreement({"ann": ann, "ben": ben}, TAKE)
    line = mm.repair(TAKE, "A", (100, 160), "linear").values
    stiff = mm.repair(TAKE, "A", (100, 160), "rigid").values
    off = np.linalg.norm(line - stiff, axis=1)
    (pair,) = result.pairs
    assert pair.difference is not None
    assert pair.difference.mean_mm == pytest.approx(off.mean())
    assert pair.difference.largest_mm == pytest.approx(off.max())
    assert result.things[0].apart_mm == pytest.approx(off.mean())


def test_decision_files_need_no_take_and_must_be_of_one() -> None:
    ann = review_of(judged("A", 100, 150, "step"), judged("B", 20, 60, "slow"))
    ben = review_of(judged("A", 100, 150, "step"))
    files = [decisions_on(TAKE, review) for review in (ann, ben)]
    without = agreement(files)
    (pair,) = without.pairs
    assert (pair.both, pair.difference) == (1, None)
    assert np.sum(pair.samples) == 2 * N_FRAMES  # A and B alone
    assert np.sum(agreement(files, TAKE).pairs[0].samples) == 5 * N_FRAMES
    other = TAKE.with_positions(TAKE.positions + 1.0)
    with pytest.raises(BadInput, match="different takes"):
        agreement([files[0], decisions_on(other, ben)])
    with pytest.raises(BadDecisions, match="give the take they were made on"):
        agreement(files, other)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (([review_of()],), "needs two or more reviews; got 1"),
        (([review_of(), review_of()],), "how long its take is"),
        (({"a": review_of(), "b": review_of()}, TAKE, 0.0), "iou must be above 0"),
        (({"a": review_of(), "b": review_of()}, TAKE, 0.5, "c"), "got 'c' of a, b"),
        (({"a": review_of(), "b": review_of()}, None, 0.5, "a"), "no take"),
    ],
)
def test_what_cannot_be_compared_is_refused(arguments: tuple, says: str) -> None:  # type: ignore[type-arg]
    names = ("reviews", "take", "iou", "expert")
    with pytest.raises(BadInput, match=says):
        agreement(**dict(zip(names, arguments, strict=False)))


def test_table_2_holds_versions_against_the_experts() -> None:
    dirty = TAKE.positions.copy()
    dirty[100:140, 0] += (0.0, 40.0, 0.0)
    dirty[200, 3] += (60.0, 0.0, 0.0)
    take = TAKE.with_positions(dirty)
    reviews = {
        "expert": review_of(judged("A", 100, 140, "step"), judged("D", 200, 201, "peak")),
        "beginner": review_of(judged("D", 200, 201, "peak")),
    }
    versions = {
        "expert": TAKE,
        "beginner": take.with_positions(
            np.where(np.arange(N_FRAMES)[:, None, None] == 200, TAKE.positions, dirty)
        ),
    }
    none, expert, beginner = table2(take, versions, reviews, "expert", detector="published")
    assert (none.operator, none.human, expert.human, beginner.human) == ("none", 2, 2, 1)
    assert expert.approved == expert.missed == 0
    assert none.approved + none.missed >= 2
    assert beginner.approved + beginner.missed >= 1
    for row in (none, expert, beginner):
        assert row.algorithm == row.approved + row.rejected


def test_an_adjudication_keeps_what_all_decided_alike() -> None:
    same = judged("A", 100, 150, "step")
    ann = review_of(
        same,
        judged("B", 20, 60, "slow"),
        judged("C", 5, 9, "noise", "rejected"),
        judged("D", 5, 9, "peak"),
    )
    ben = review_of(same, judged("B", 22, 60, "step"), judged("C", 5, 9, "noise", "rejected"))
    result = adjudication([ann, ben])
    said = {(j.finding.marker, j.span.start): j.decision for j in result}
    assert said["A", 100] == same.decision
    assert said["C", 5].verdict == "rejected"
    assert said["B", 20].verdict is None
    assert said["B", 20].note == (
        "1: accepted as slow 20-60 with linear; 2: accepted as step 22-60 with linear"
    )
    assert said["D", 5].note == "1: accepted as peak 5-9 with linear; 2: nothing here"
    assert adjudication([ann, ann]).judgements == ann.judgements
    named = adjudication([ann, ben], ("Ann", "Ben"))
    (note,) = [j.decision.note for j in named if j.finding.marker == "D"]
    assert note == "Ann: accepted as peak 5-9 with linear; Ben: nothing here"
    with pytest.raises(BadInput, match="2 reviews need as many names; got 1"):
        adjudication([ann, ben], ("Ann",))


def test_an_adjudicator_may_follow_either_of_them() -> None:
    ann = review_of(judged("A", 20, 60, "slow"), judged("B", 5, 9, "peak"))
    ben = review_of(judged("A", 22, 60, "step", "accepted"), judged("C", 5, 9, "noise", "rejected"))
    found = {case.finding.marker: case for case in cases([ann, ben])}
    assert found["A"].decision(0) == Decision("accepted", method="linear")
    assert found["A"].decision(1) == Decision("accepted", "step", Span(22, 60), "linear")
    assert found["B"].decision(1) == found["C"].decision(0) == Decision("rejected")
    assert not any(case.agreed for case in found.values())
    assert all(case.agreed for case in cases([ann, ann]))

    # Following one of them throughout gives that one's review, as one command each.
    review = taken_over(adjudication([ann, ben])).apply(Review())
    for case in cases([ann, ben]):
        review = Adopt((case.finding,), (case.decision(1),), (False,)).apply(review)
    assert review.accepted() == ben.accepted()
    with pytest.raises(BadInput, match="nothing to take over"):
        taken_over(adjudication([Review(), Review()]))


SPANS = st.builds(lambda a, n: Span(a, a + n), st.integers(0, 60), st.integers(1, 30))


@given(SPANS, SPANS, st.integers(0, 4))
def test_overlap_is_a_share_that_grows_with_slack(one: Span, other: Span, slack: int) -> None:
    value = overlap(one, other, slack)
    assert 0.0 <= value <= 1.0
    assert value == overlap(other, one, slack)
    assert (value == 1.0) == (one == other)
    assert overlap(one, other) == pytest.approx(one.iou(other))
    assert value >= overlap(one, other)


@given(st.lists(SPANS, max_size=8), st.lists(SPANS, max_size=8), st.floats(0.05, 1.0))
def test_pairs_are_one_to_one_and_none_is_left_that_could_be(
    first: list[Span], second: list[Span], least: float
) -> None:
    ones, others = ([Truth("A", span, "step") for span in spans] for spans in (first, second))
    matched = pairs(ones, others, least)
    assert len(set(matched.values())) == len(matched)
    for i, one in enumerate(ones):
        for j, other in enumerate(others):
            if i not in matched and j not in matched.values():
                assert overlap(one.span, other.span) < least
