"""The desk without a screen: open, walk, decide, undo, come back, export."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import markermend as mm
from markermend_app.state.desk import Desk
from markermend_app.state.intents import INTENTIONS, perform

from .conftest import Ticks, settle

MakeDesk = Callable[..., tuple[Desk, Ticks]]


def test_opens_on_the_worst_finding_with_a_repair_chosen(make_desk: MakeDesk):
    desk, _ = make_desk()
    assert desk.current is desk.queue[0]
    assert {f.kind for f in desk.findings} >= {"gap", "peak"}
    assert desk.repair is not None
    assert desk.chosen == desk.best
    start, stop = desk.window
    assert start * 100 <= desk.span.start < desk.span.stop <= stop * 100


def test_a_decision_goes_on_to_the_next_open_finding(make_desk: MakeDesk):
    desk, ticks = make_desk()
    first, second = desk.queue[:2]
    perform(desk, "accept")
    assert desk.review.decision(first).verdict == "accepted"
    assert desk.review.decision(first).method == "rigid"
    assert desk.current is second
    settle(desk, ticks)
    perform(desk, "reject")
    assert desk.review.decision(second).verdict == "rejected"
    assert second not in desk.queue


def test_accepting_before_the_repair_is_there_waits_for_it(make_desk: MakeDesk):
    desk, ticks = make_desk()
    first, second = desk.queue[:2]
    desk._known.clear()  # as if nothing had been compared yet
    desk.select(second)
    desk.select(first)
    assert desk.repair is None
    perform(desk, "accept")
    assert desk.review.decision(first).verdict is None
    settle(desk, ticks)
    assert desk.review.decision(first).verdict == "accepted"
    assert desk.review.decision(second).verdict is None, "one key accepts one finding"


def test_undo_selects_what_it_changed_and_redo_brings_it_back(make_desk: MakeDesk):
    desk, _ = make_desk()
    first = desk.current
    perform(desk, "reject")
    after = desk.review
    perform(desk, "undo")
    assert desk.current == first
    assert desk.review.decision(first).verdict is None
    perform(desk, "redo")
    assert desk.review == after


def test_another_page_finds_every_decision(make_desk: MakeDesk):
    desk, ticks = make_desk()
    perform(desk, "reject")
    settle(desk, ticks)
    perform(desk, "defer")
    again, _ = make_desk()
    assert again.review == desk.review
    assert again.steps == desk.steps


def test_two_pages_never_overwrite_each_other(make_desk: MakeDesk):
    one, _ = make_desk()
    two, ticks = make_desk()
    first = one.current
    perform(one, "reject")
    perform(two, "defer")
    assert two.review.decision(first).verdict == "rejected", "the first decision stands"
    assert "another window" in two.message
    settle(two, ticks)
    perform(two, "undo")
    assert two.review.decision(first).verdict is None


def test_choosing_a_repair_is_kept_and_used(make_desk: MakeDesk):
    desk, ticks = make_desk()
    finding = desk.current
    perform(desk, "choose", "linear")
    assert desk.chosen == desk.repair.method == "linear"
    desk.next()
    settle(desk, ticks)
    desk.select(finding)
    settle(desk, ticks)
    assert desk.chosen == "linear"
    perform(desk, "accept")
    assert desk.review.decision(finding).method == "linear"


def test_a_method_that_does_not_apply_says_why(make_desk: MakeDesk):
    desk, _ = make_desk()
    refused = [p for p in desk.previews if p.reason]
    for preview in refused:
        assert preview.reason.endswith(".")
        perform(desk, "choose", preview.name)
        assert desk.chosen != preview.name


def test_a_late_preview_never_lands_on_another_finding(make_desk: MakeDesk):
    desk, ticks = make_desk()
    first, second = desk.queue[:2]
    desk.select(first)
    desk.jobs.wait()
    desk.select(second)  # the results for the first are waiting in the page's next ticks
    settle(desk, ticks)
    spans = {(p.repair.marker, p.repair.span) for p in desk.previews if p.repair}
    assert spans == {(second.marker, second.span)}


def test_export_changes_the_accepted_spans_and_nothing_else(
    make_desk: MakeDesk, take_path: Path, tmp_path: Path
):
    desk, ticks = make_desk()
    gap = next(f for f in desk.findings if f.kind == "gap")
    desk.select(gap)
    settle(desk, ticks)
    values = desk.repair.values
    perform(desk, "accept")
    perform(desk, "export")
    settle(desk, ticks)
    assert desk.dialog == "export"
    assert desk.plan.n_changed == len(gap.span)
    target = tmp_path / "out.c3d"
    perform(desk, "export_write", None, {"target": str(target)})
    settle(desk, ticks)
    assert desk.dialog == "exported", desk.message
    before, after = mm.read(take_path), mm.read(target)
    marker = before.index(gap.marker)
    np.testing.assert_allclose(after.positions[gap.span.frames, marker], values, atol=1e-3)
    differs = ~np.isclose(before.positions, after.positions, equal_nan=True, rtol=0, atol=0)
    differs[gap.span.frames, marker] = False
    assert not differs.any()
    decisions = json.loads((tmp_path / "out.c3d.decisions.json").read_text())
    assert [f["id"] for f in decisions["findings"]] == [gap.id]


def test_an_export_onto_the_source_is_refused_in_a_sentence(make_desk: MakeDesk, take_path: Path):
    desk, ticks = make_desk()
    content = take_path.read_bytes()
    perform(desk, "export")
    settle(desk, ticks)
    perform(desk, "export_write", None, {"target": str(take_path), "overwrite": True})
    settle(desk, ticks)
    assert "never overwritten" in desk.message
    assert take_path.read_bytes() == content


def test_a_file_that_changed_is_told_and_starts_another_review(
    make_desk: MakeDesk, take_path: Path
):
    desk, _ = make_desk()
    perform(desk, "reject")
    take = mm.read(take_path)
    moved = take.positions.copy()
    moved[:, 0] += 1.0
    take_path.unlink()
    mm.write(mm.Take(moved, take.rate, take.labels), take_path)
    again, _ = make_desk()
    assert "has changed since" in again.message
    assert len(again.review) == 0


def test_a_renamed_file_keeps_its_review(make_desk: MakeDesk, take_path: Path):
    desk, ticks = make_desk()
    perform(desk, "reject")
    other = take_path.rename(take_path.with_name("renamed.c3d"))
    desk.open(other)
    settle(desk, ticks)
    assert desk.opened.name == "renamed.c3d"
    assert desk.review.counts(desk.findings).rejected == 1


@pytest.mark.parametrize("name", sorted(INTENTIONS))
def test_no_intention_fails_before_a_take_is_open(name: str, tmp_path: Path):
    from markermend.review.store import Store
    from markermend_app.state.workspace import Workspace

    with Store(tmp_path / "store.sqlite") as store:
        desk = Desk(Workspace(store, ()), lambda task: task())
        perform(desk, name, "1", {})
        desk.close()


def test_an_unreadable_file_is_a_sentence(make_desk: MakeDesk, tmp_path: Path):
    desk, ticks = make_desk()
    opened = desk.opened
    broken = tmp_path / "broken.c3d"
    broken.write_bytes(b"no take at all")
    desk.open(broken)
    settle(desk, ticks)
    assert desk.message.endswith(".")
    assert "broken.c3d" in desk.message
    assert desk.opened is opened, "the take at hand stays"
