"""What is offered for a finding: compared, recommended, explained, and shown in the lanes."""

from collections.abc import Callable

import numpy as np
import pytest

from markermend.model import Finding, Span
from markermend.repairing.checks import Checks
from markermend.repairing.compare import compare
from markermend.review import AddFinding
from markermend_app.state import curves, previews
from markermend_app.state.desk import SIGNALS, Desk
from markermend_app.state.intents import perform
from markermend_app.views import repairs as table

from .conftest import METHODS, Ticks, settle

MakeDesk = Callable[..., tuple[Desk, Ticks]]


def test_the_table_is_the_library_s_comparison(make_desk: MakeDesk):
    desk, _ = make_desk()
    finding = desk.current
    wanted = compare(desk.opened.take, finding.marker, finding.span, METHODS, kind=finding.kind)
    shown = {p.name: p for p in desk.previews}
    assert (desk.best, desk.why) == (wanted.recommended, wanted.why)
    for row in wanted.rows:
        assert shown[row.method].reason == row.refusal
        assert shown[row.method].row.expected_mm == pytest.approx(row.expected_mm)
    known = [p.row.expected_mm for p in desk.previews if p.trust]
    assert known == sorted(known)
    assert desk.previews[-1].reason or desk.previews[-1].name == "leave"


def test_the_first_preview_needs_no_comparison(make_desk: MakeDesk):
    desk, _ = make_desk()
    judged = desk.judged(desk.current)
    rows = previews.at_hand(desk.opened.take, judged, (), METHODS)
    offer = previews.recommended(rows, judged, complete=False)
    assert offer.best == "rigid"
    assert not offer.complete
    assert next(r for r in offer.rows if r.name == "rigid").trust is None


def test_a_choice_made_by_hand_is_not_overruled_by_the_comparison(make_desk: MakeDesk):
    desk, ticks = make_desk()
    desk._known.clear()
    desk.select(desk.queue[1])
    desk.jobs.wait()
    ticks.run()  # the first preview is there, the comparison runs
    perform(desk, "choose", "rigid")
    settle(desk, ticks)
    assert desk.best != "rigid"
    assert desk.chosen == "rigid"


def test_methods_that_do_not_apply_are_behind_one_line(make_desk: MakeDesk):
    desk, _ = make_desk()
    refused = [p for p in desk.previews if p.reason]
    assert refused
    assert f"{len(refused)} do" in table.render(desk)
    assert refused[0].reason[:20] not in table.render(desk)
    perform(desk, "refused")
    assert refused[0].reason[:20] in table.render(desk)


def test_the_next_findings_are_compared_beforehand(make_desk: MakeDesk):
    desk, ticks = make_desk(ahead=1)
    settle(desk, ticks)
    perform(desk, "accept")
    assert all(p.compared or p.slow or p.name == "leave" for p in desk.previews), "at once"
    assert desk.best


def test_relative_is_chosen_where_the_artefact_is_small(make_desk: MakeDesk):
    desk, _ = make_desk()
    marker = desk.opened.take.labels[6]  # travels half a metre
    small, large = (
        Finding(marker, Span(at, at + 9), "noise", amplitude=size)
        for at, size in ((100, 5.0), (300, 90.0))
    )
    desk.do(AddFinding((small, large)))
    peak = small
    for finding in (large, small):
        desk.select(finding)
        perform(desk, "zoom")
        perform(desk, "zoom")  # the whole take
        assert curves.is_relative(desk) == (finding is small)
    values = curves.lanes(desk)
    known = values.raw.values[np.isfinite(values.raw.values[:, 0])]
    assert np.ptp(known, axis=0).max() < 45, "the neighbours' motion is gone"
    perform(desk, "relative")
    position = curves.lanes(desk)
    recorded = desk.opened.take.positions[:, desk.opened.take.index(peak.marker)]
    low, high = np.nanmin(position.raw.values, axis=0), np.nanmax(position.raw.values, axis=0)
    np.testing.assert_allclose(np.nanmin(recorded, axis=0), low, atol=40)
    np.testing.assert_allclose(np.nanmax(recorded, axis=0), high, atol=40)
    desk.select(next(f for f in desk.findings if f.kind == "gap"))
    assert desk.relative is None, "the choice falls back with the next finding"


@pytest.mark.parametrize("signal", SIGNALS)
def test_every_signal_is_shown_before_and_after_the_repair(make_desk: MakeDesk, signal: str):
    desk, ticks = make_desk()
    peak = max((f for f in desk.findings if f.amplitude), key=lambda f: f.amplitude)
    desk.select(peak)
    settle(desk, ticks)
    perform(desk, "signal", signal)
    before = curves.lanes(desk).evidence
    after = curves.repairs(desk).after
    span = desk.span
    inside = (before.time * 100 > span.start - 1.5) & (before.time * 100 < span.stop + 0.5)
    assert len(after.values)
    assert np.nanmax(after.values) < 0.6 * np.nanmax(before.signal[inside]), "the repair helps"


def test_accepted_repairs_are_shown_and_undone(make_desk: MakeDesk):
    desk, ticks = make_desk()
    gap = next(f for f in desk.findings if f.kind == "gap")
    desk.select(gap)
    settle(desk, ticks)
    values = desk.repair.values
    perform(desk, "accept")
    settle(desk, ticks)
    (done,) = desk.mended.values()
    np.testing.assert_array_equal(done.values, values)
    again, more = make_desk()
    settle(again, more)
    assert [d.span for d in again.mended.values()] == [gap.span], "also on another page"
    perform(again, "undo")
    assert again.mended == {}


def test_what_the_detector_did_not_look_at_is_never_called_clean():
    def checks(*found: Finding, detected: bool) -> Checks:
        return Checks(0.1, 0.1, 0.1, 0.1, 0.5, 0.5, found, detected)

    peak = Finding("A", Span(3, 4), "peak")
    assert table.artefacts(checks(detected=False)) == "–"
    assert table.artefacts(checks(detected=True)) == "0"
    assert ">1<" in table.artefacts(checks(peak, detected=True))
