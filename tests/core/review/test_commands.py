"""What each command does to a review, and what it refuses."""

import json
from dataclasses import replace

import numpy as np
import pytest

from markermend.errors import BadInput, BadParameter, UnknownName
from markermend.model import Evidence, Finding, Span
from markermend.review import (
    COMMANDS,
    Accept,
    AddFinding,
    Adopt,
    Annotate,
    Choose,
    Command,
    Decision,
    Defer,
    Judgement,
    Merge,
    MoveEdges,
    Reclassify,
    Reject,
    RemoveAdded,
    Reopen,
    Review,
    Split,
    command_from_json,
)

PEAK = Finding("A", Span(120, 123), "peak", 0.9, ("z",), 30.0, "published", 2.5)
GAP = Finding("A", Span(40, 60), "gap", detector="gaps")
SWAP = Finding("A", Span(70, 90), "step", partner="B", group="g1")

EVERY = (
    Accept((PEAK, GAP), "savgol", {"window": 21, "order": 0.1 + 0.2, "on": True, "mode": "x"}),
    Reject((PEAK,)),
    Defer((PEAK, GAP)),
    Reopen((PEAK,)),
    Choose((GAP,), "rigid", {"neighbours": 4}),
    Reclassify((PEAK,), "noise"),
    MoveEdges((PEAK,), Span(118, 125)),
    Annotate((GAP,), "hidden by the arm \ud800 ä"),
    AddFinding((SWAP,)),
    RemoveAdded((SWAP,)),
    Split((GAP,), 50),
    Merge((PEAK, GAP)),
    Adopt(
        (PEAK, SWAP),
        (Decision("accepted", "noise", Span(1, 4), "rigid", {"n": 3}, "as A"), Decision()),
        (False, True),
    ),
)


def applied(*commands: Command) -> Review:
    review = Review()
    for command in commands:
        review = command.apply(review)
    return review


def test_every_command_is_tried_here() -> None:
    assert {command.name for command in EVERY} == set(COMMANDS)


@pytest.mark.parametrize("command", EVERY, ids=lambda command: command.name)
def test_a_command_survives_json(command: Command) -> None:
    text = json.dumps(command.to_json(), allow_nan=False)
    assert command_from_json(json.loads(text)) == command


def test_an_unknown_command_is_refused() -> None:
    with pytest.raises(UnknownName, match="no command 'explode'"):
        command_from_json({"command": "explode", "findings": []})


def test_a_command_without_findings_is_refused() -> None:
    with pytest.raises(BadInput, match="Accept needs a finding"):
        Accept(())


def test_a_command_keeps_no_evidence_and_only_what_json_keeps() -> None:
    evidence = Evidence("deviation", 0, np.zeros(3), 1.0, 0.5)
    rough = replace(PEAK, score=0.123456789, evidence=evidence)
    kept = Reject((rough,)).finding
    assert kept.evidence is None
    assert kept.score == 0.123457
    assert kept.id == PEAK.id


@pytest.mark.parametrize("number", [np.nan, np.inf])
def test_a_finding_that_could_not_be_stored_is_refused(number: float) -> None:
    with pytest.raises(BadInput, match="not finite"):
        Reject((replace(PEAK, strength=number),))


@pytest.mark.parametrize("value", [None, [1], float("nan"), float("inf")])
def test_a_parameter_that_could_not_be_stored_is_refused(value: object) -> None:
    with pytest.raises(BadParameter, match="window must be"):
        Accept((PEAK,), "savgol", {"window": value})


def test_a_review_cannot_be_changed_in_place() -> None:
    before = Review()
    after = Accept((PEAK,), "pchip", {"a": 1}).apply(before)
    assert len(before) == 0
    with pytest.raises(TypeError):
        after.judgements[PEAK.id] = Judgement(PEAK)  # type: ignore[index]
    with pytest.raises(TypeError):
        after.decision(PEAK).parameters["a"] = 2  # type: ignore[index]


def test_verdicts_keep_what_else_was_said() -> None:
    review = applied(
        Choose((GAP,), "rigid", {"neighbours": 4}), Annotate((GAP,), "arm"), Accept((GAP,))
    )
    assert review.decision(GAP) == Decision(
        "accepted", None, None, "rigid", {"neighbours": 4}, "arm"
    )
    for command, verdict in ((Reject, "rejected"), (Defer, "deferred"), (Reopen, None)):
        review = command((GAP,)).apply(review)
        assert review.decision(GAP) == Decision(
            verdict, None, None, "rigid", {"neighbours": 4}, "arm"
        )


def test_accepting_with_a_method_replaces_the_one_chosen_with_its_parameters() -> None:
    review = applied(Choose((GAP,), "rigid", {"neighbours": 4}), Accept((GAP,), "pchip"))
    assert review.decision(GAP) == Decision("accepted", method="pchip")


def test_kind_and_edges_that_are_put_back_leave_no_trace() -> None:
    review = applied(Reclassify((PEAK,), "noise"), MoveEdges((PEAK,), Span(100, 130)))
    judged = review.judgement(PEAK)
    assert (judged.kind, judged.span) == ("noise", Span(100, 130))
    assert judged.as_judged == replace(PEAK, kind="noise", span=Span(100, 130))
    assert PEAK in review.live()
    review = MoveEdges((PEAK,), PEAK.span).apply(Reclassify((PEAK,), "peak").apply(review))
    assert review.decision(PEAK) == Decision()


def test_accepted_findings_become_wishes_with_everything_a_repair_needs() -> None:
    review = applied(
        Accept((SWAP, GAP), "pchip", {"k": 1}),
        MoveEdges((GAP,), Span(39, 61)),
        Reclassify((SWAP,), "noise"),
        Reject((PEAK,)),
    )
    gap, swap = review.accepted()
    assert (gap.marker, gap.span, gap.kind, gap.method, gap.parameters) == (
        "A", Span(39, 61), "gap", "pchip", {"k": 1},
    )  # fmt: skip
    assert (swap.span, swap.kind, swap.partner) == (Span(70, 90), "noise", "B")


def test_a_decision_outlives_a_detection_that_finds_it_no_more() -> None:
    review = Accept((PEAK,)).apply(Review())
    assert review.live((GAP,)) == (GAP, PEAK)
    assert review.counts((GAP,)).accepted == 1
    assert review.counts((GAP,)).open == 1
    assert [wish.span for wish in review.accepted()] == [PEAK.span]


def test_the_latest_detection_is_shown_with_its_evidence() -> None:
    review = Reject((PEAK,)).apply(Review())
    fresh = replace(PEAK, evidence=Evidence("deviation", 0, np.zeros(3), 1.0, 0.5))
    (shown,) = review.live((fresh,))
    assert shown.evidence is not None


def test_the_numbers_of_the_detection_decided_on_last_are_kept() -> None:
    surer = replace(PEAK, score=0.95, amplitude=31.0)
    review = applied(Accept((PEAK,)), Annotate((surer,), "clear"))
    assert review.judgement(PEAK).finding == surer
    assert review.decision(PEAK).verdict == "accepted"


def test_adding_and_removing() -> None:
    review = AddFinding((SWAP,)).apply(Review())
    assert review.live() == (SWAP,)
    with pytest.raises(BadInput, match="already a A step 70-90"):
        AddFinding((SWAP,)).apply(review)
    assert RemoveAdded((SWAP,)).apply(review) == Review()
    with pytest.raises(BadInput, match="not added by hand; reject it"):
        RemoveAdded((PEAK,)).apply(review)


def spans(review: Review, *detected: Finding) -> list[tuple[int, int]]:
    return sorted((f.span.start, f.span.stop) for f in review.live(detected))


def test_a_split_finding_is_replaced_by_its_parts() -> None:
    review = applied(Annotate((GAP,), "arm"), Accept((GAP,), "rigid"), Split((GAP,), 50))
    assert spans(review, GAP) == [(40, 50), (50, 60)]
    assert review.accepted() == ()
    assert {review.decision(f) for f in review.live()} == {Decision(note="arm")}
    with pytest.raises(BadInput, match="was split or merged"):
        Accept((GAP,)).apply(review)


@pytest.mark.parametrize("at", [0, 40, 60, 99])
def test_a_split_outside_is_refused(at: int) -> None:
    with pytest.raises(BadInput, match="split at 41 to 59"):
        Split((GAP,), at).apply(Review())


def test_a_split_finding_comes_back_when_its_parts_are_removed() -> None:
    review = applied(Accept((GAP,), "rigid"), Split((GAP,), 50))
    first, second = review.live()
    review = RemoveAdded((first,)).apply(review)
    assert spans(review, GAP) == [(50, 60)]
    review = RemoveAdded((second,)).apply(review)
    assert review == Accept((GAP,), "rigid").apply(Review())


def test_split_and_merged_again_is_the_same_finding() -> None:
    review = Split((GAP,), 50).apply(Review())
    review = Merge(review.live()).apply(review)
    assert [f.id for f in review.live((GAP,))] == [GAP.id]
    review = Split((GAP,), 50).apply(review)
    assert spans(review, GAP) == [(40, 50), (50, 60)]


def test_edges_that_were_moved_are_the_ones_split_and_merged() -> None:
    review = applied(MoveEdges((GAP,), Span(40, 80)), Split((GAP,), 60))
    assert spans(review, GAP) == [(40, 60), (60, 80)]  # the first part is the finding itself
    review = Merge(review.live((GAP,))).apply(review)
    assert spans(review, GAP) == [(40, 80)]


def test_merging_takes_the_longest_kind_and_the_largest_numbers() -> None:
    noise = Finding("A", Span(123, 140), "noise", 0.4, ("x",), 5.0, "published", 9.0)
    review = Merge((PEAK, noise)).apply(Review())
    (merged,) = review.live((PEAK, noise))
    assert merged == Finding("A", Span(120, 140), "noise", 0.9, ("x", "z"), 30.0, "operator", 9.0)


def test_merging_into_one_that_covers_the_others_keeps_it() -> None:
    inside = Finding("A", Span(45, 50), "gap")
    review = applied(Accept((GAP,)), Merge((GAP, inside)))
    assert review.live((GAP, inside)) == (GAP,)
    assert review.decision(GAP) == Decision()


@pytest.mark.parametrize("findings", [(PEAK,), (PEAK, Finding("B", Span(1, 2), "gap"))])
def test_merging_needs_several_of_one_marker(findings: tuple[Finding, ...]) -> None:
    with pytest.raises(BadInput, match="two or more findings of one marker"):
        Merge(findings).apply(Review())


@pytest.mark.parametrize("command", [MoveEdges((PEAK, GAP), Span(1, 9)), Split((PEAK, GAP), 45)])
def test_a_gesture_on_one_finding_refuses_many(command: Command) -> None:
    with pytest.raises(BadInput, match="takes one finding; got 2"):
        command.apply(Review())


def test_clashes_are_accepted_repairs_that_write_the_same_samples() -> None:
    over = Finding("A", Span(50, 75), "noise")
    other = Finding("B", Span(70, 80), "peak")  # inside the swap of A and B
    beside = Finding("A", Span(90, 95), "peak")  # half-open: touches SWAP, shares nothing
    review = Accept((GAP, over, SWAP, other, beside)).apply(Review())
    pairs = {frozenset((a.span, b.span)) for a, b in review.clashes()}
    assert pairs == {
        frozenset((GAP.span, over.span)),
        frozenset((over.span, SWAP.span)),
        frozenset((SWAP.span, other.span)),
    }


@pytest.mark.parametrize(
    ("command", "line"),
    [
        (EVERY[0], "Accept 2 findings with savgol"),
        (Accept((GAP,), "rigid"), "Accept A gap 40-60 with rigid"),
        (Reject((GAP, replace(GAP, marker="B"))), "Reject 2 gap findings"),
        (EVERY[4], "Choose rigid for A gap 40-60"),
        (EVERY[5], "Reclassify A peak 120-123 as noise"),
        (EVERY[6], "Move A peak 120-123 to 118-125"),
        (EVERY[7], "Note on A gap 40-60"),
        (EVERY[10], "Split A gap 40-60 at 50"),
    ],
)
def test_a_command_says_in_a_line_what_it_does(command: Command, line: str) -> None:
    assert command.describe() == line


def test_what_somebody_else_decided_is_taken_over_whole() -> None:
    decision = Decision("accepted", "noise", Span(118, 125), "savgol", {"window": 9}, "agreed")
    before = applied(Annotate((PEAK,), "mine"), Reject((PEAK,)))
    after = Adopt((PEAK, SWAP), (decision, Decision("rejected")), (False, True)).apply(before)
    assert after.judgements[PEAK.id].decision == decision
    assert (after.judgements[PEAK.id].added, after.judgements[SWAP.id].added) == (False, True)
    with pytest.raises(BadInput, match="one decision for each of the 2 findings; got 1"):
        Adopt((PEAK, SWAP), (decision,), (False, True))
