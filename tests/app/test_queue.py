"""The queue without a screen: filters, edges, spans added, split and merged, similar, history."""

from collections.abc import Callable

import pytest

from markermend.model import Finding, Span
from markermend.review import AddFinding
from markermend_app.state.desk import Desk
from markermend_app.state.intents import perform

from .conftest import Ticks, settle

MakeDesk = Callable[..., tuple[Desk, Ticks]]


def gap_of(desk: Desk) -> Finding:
    return next(f for f in desk.findings if f.kind == "gap")


def test_edges_follow_the_playhead_and_undo_brings_them_back(make_desk: MakeDesk):
    desk, _ = make_desk()
    gap = gap_of(desk)
    desk.select(gap)
    desk.seek(gap.span.start + 5)
    perform(desk, "edge_start")
    assert desk.span == Span(gap.span.start + 5, gap.span.stop)
    assert desk.frame == gap.span.start + 5, "the playhead stays where it was put"
    desk.seek(gap.span.stop + 3)
    perform(desk, "edge_stop")
    assert desk.span == Span(gap.span.start + 5, gap.span.stop + 4)
    perform(desk, "undo")
    perform(desk, "undo")
    assert desk.span == gap.span


def test_edges_that_cross_are_refused_in_a_sentence(make_desk: MakeDesk):
    desk, _ = make_desk()
    gap = gap_of(desk)
    desk.select(gap)
    desk.seek(gap.span.stop + 10)
    perform(desk, "edge_start")
    assert desk.span == gap.span
    assert desk.message.endswith(".")


def test_a_missed_span_is_added_by_two_keys(make_desk: MakeDesk):
    desk, _ = make_desk()
    gap = gap_of(desk)
    desk.select(gap)
    desk.seek(20)
    perform(desk, "add_begin")
    desk.seek(31)
    perform(desk, "add_end")
    assert desk.current is not None
    assert (desk.current.marker, desk.current.span) == (gap.marker, Span(20, 32))
    assert desk.judged(desk.current).added
    perform(desk, "remove")
    assert all(f.span != Span(20, 32) for f in desk.findings)


def test_a_marker_without_findings_can_be_looked_at_and_given_one(make_desk: MakeDesk):
    desk, _ = make_desk()
    silent = next(
        label for label in desk.opened.take.labels if all(f.marker != label for f in desk.findings)
    )
    desk.select_marker(desk.opened.take.index(silent))
    assert (desk.marker, desk.current) == (silent, None)
    perform(desk, "add", [50, 60])
    assert (desk.current.marker, desk.current.span) == (silent, Span(50, 60))


def test_split_and_merge_are_each_other_s_way_back(make_desk: MakeDesk):
    desk, _ = make_desk()
    gap = gap_of(desk)
    desk.select(gap)
    desk.seek(gap.span.start + 10)
    perform(desk, "split")
    spans = sorted(f.span for f in desk.findings if f.marker == gap.marker and f.kind == "gap")
    assert spans == [
        Span(gap.span.start, gap.span.start + 10), Span(gap.span.start + 10, gap.span.stop)
    ]  # fmt: skip
    desk.select(next(f for f in desk.findings if f.span == spans[0]))
    perform(desk, "merge")
    assert desk.span == gap.span


def test_a_note_is_kept_with_the_finding(make_desk: MakeDesk):
    desk, _ = make_desk()
    finding = desk.current
    perform(desk, "note")
    assert desk.dialog == "note"
    perform(desk, "accept")  # a dialog is open: nothing is decided behind it
    assert desk.review.decision(finding).verdict is None
    perform(desk, "note_keep", None, {"note": "  shoe <b>rubs</b> "})
    assert desk.review.decision(finding).note == "shoe <b>rubs</b>"
    assert desk.dialog == ""


def test_filters_hide_rows_and_the_keys_go_on_working(make_desk: MakeDesk):
    desk, ticks = make_desk()
    marker = gap_of(desk).marker
    perform(desk, "filter_text", marker.lower())
    assert {f.marker for f in desk.queue} == {marker}
    perform(desk, "next")
    settle(desk, ticks)
    shown = desk.current
    perform(desk, "reject")
    assert desk.review.decision(shown).verdict == "rejected"
    perform(desk, "filter_verdict", "accepted")
    assert desk.settled == ()
    perform(desk, "filter_clear")
    assert shown in desk.settled
    assert len(desk.queue) + len(desk.settled) == len(desk.findings)


def test_similar_findings_are_decided_as_one_step(make_desk: MakeDesk):
    desk, ticks = make_desk()
    spans = [Span(50, 58), Span(100, 109), Span(300, 310)]
    desk.do(AddFinding(tuple(Finding("M1", span, "noise", amplitude=3.0) for span in spans)))
    first = next(f for f in desk.findings if f.span == spans[0])
    desk.select(first)
    settle(desk, ticks)
    perform(desk, "similar")
    assert desk.dialog == "similar"
    assert {f.span for f in desk.similar} == set(spans)
    assert desk.similar[0] == first
    settle(desk, ticks)
    assert set(desk.expected) == {f.id for f in desk.similar}, "what to expect is measured for each"
    before = desk.review
    perform(desk, "similar_decide", "accept")
    verdicts = {f.span: desk.review.decision(f) for f in desk.findings if f.span in spans}
    assert {d.verdict for d in verdicts.values()} == {"accepted"}
    assert {d.method for d in verdicts.values()} == {desk.review.decision(first).method}
    perform(desk, "undo")
    assert desk.review == before


def test_similar_means_same_kind_and_about_the_same_size(make_desk: MakeDesk):
    desk, _ = make_desk()
    sizes = {Span(20, 30): 3.0, Span(60, 70): 5.9, Span(90, 100): 6.1, Span(120, 130): 1.4}
    added = tuple(Finding("M1", s, "noise", amplitude=a) for s, a in sizes.items())
    desk.do(AddFinding(added))
    assert {f.span for f in desk.alike(added[0])} == {Span(20, 30), Span(60, 70)}


def test_the_history_can_be_walked(make_desk: MakeDesk):
    desk, ticks = make_desk()
    for _ in range(2):
        settle(desk, ticks)
        perform(desk, "reject")
    final = desk.review
    assert len(desk.steps[0]) == 2
    perform(desk, "history")
    perform(desk, "history_go", "1")
    assert desk.review.counts(desk.findings).rejected == 1
    perform(desk, "history_go", "2")
    assert desk.review == final
    perform(desk, "history_go", "99")
    assert desk.review == final, "there is no such place"


def test_thresholds_change_what_is_listed_and_count_what_is_found(make_desk: MakeDesk):
    desk, _ = make_desk()
    peaks = {f.id for f in desk.findings if f.kind == "peak"}
    assert desk.candidates("peak") == len(peaks)
    strongest = max(f.strength for f in desk.opened.findings if f.kind == "peak")
    perform(desk, "threshold_peak", 4.0)
    left = {f.id for f in desk.findings if f.kind == "peak"}
    assert left == {f.id for f in desk.opened.findings if f.kind == "peak" and f.strength >= 4.0}
    assert bool(left) == (strongest >= 4.0)
    perform(desk, "threshold_peak", 1.0)
    assert {f.id for f in desk.findings if f.kind == "peak"} == peaks


def test_what_was_decided_stays_listed_whatever_the_threshold(make_desk: MakeDesk):
    desk, ticks = make_desk()
    peak = next(f for f in desk.findings if f.kind == "peak")
    desk.select(peak)
    settle(desk, ticks)
    perform(desk, "reject")
    perform(desk, "threshold_peak", 4.0)
    assert peak.id in {f.id for f in desk.findings}
    assert desk.precision["peak"] == (0, 1)


@pytest.mark.parametrize("kind", ["peak", "slow"])
def test_reclassifying_leaves_the_detector_s_own_class_in_the_figures(
    make_desk: MakeDesk, kind: str
):
    desk, ticks = make_desk()
    peak = next(f for f in desk.findings if f.kind == "peak")
    desk.select(peak)
    settle(desk, ticks)
    perform(desk, f"kind_{kind}")
    settle(desk, ticks)
    perform(desk, "accept")
    assert desk.precision["peak"] == (1, 1)
    assert desk.review.judgement(peak).kind == kind
