"""The desk opens with its gaps; everything else arrives while the operator is at work."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import markermend as mm
from markermend import detection
from markermend.review.store import Store
from markermend_app.state import keeping
from markermend_app.state.desk import Desk
from markermend_app.state.intents import perform
from markermend_app.state.worker import Worker
from markermend_app.state.workspace import Opened, Workspace
from markermend_app.views import dialogs, header, queue

from .conftest import METHODS, Ticks, settle


@pytest.fixture
def fresh(tmp_path: Path, take_path: Path, worker: Worker):
    """Give a desk on the small take, before anything was looked for in it."""
    with Store(tmp_path / "store.sqlite") as store:
        ticks = Ticks()
        workspace = Workspace(store, (take_path,), methods=METHODS, ahead=0, worker=worker)
        desk = Desk(workspace, ticks)
        desk.open(take_path)
        desk.jobs.wait()
        yield desk, ticks
        desk.close()


def test_gaps_are_there_at_once_and_nothing_at_hand_jumps(fresh: tuple[Desk, Ticks]):
    desk, ticks = fresh
    ticks.waiting = ticks.waiting[:]  # the search has not been begun yet
    while not desk.opened:
        ticks.waiting.pop(0)()
    assert {f.kind for f in desk.findings} == {"gap"}
    assert "Looking for artefacts" in header.render(desk)
    assert desk.selected
    perform(desk, "zoom")
    before = desk.selected, desk.frame, desk.window, desk.zoom
    settle(desk, ticks)
    assert not desk.searching
    assert (desk.selected, desk.frame, desk.window, desk.zoom) == before
    assert [f.id for f in desk.found] == [f.id for f in mm.detection.scan(desk.opened.take)]
    # What has arrived was not passed: the worst of it comes next.
    others = [f.id for f in desk.queue if f.id != desk.selected]
    perform(desk, "reject")
    assert desk.selected == others[0]


def test_a_search_that_is_stopped_leaves_the_gaps(fresh: tuple[Desk, Ticks]):
    desk, ticks = fresh
    while not desk.opened:
        ticks.waiting.pop(0)()
    perform(desk, "cancel")
    assert "Only gaps are listed" in desk.message
    settle(desk, ticks)
    assert {f.kind for f in desk.findings} == {"gap"}
    assert not desk.searching


def test_what_was_found_is_kept_with_its_evidence(tmp_path: Path, take_path: Path):
    take = mm.read(take_path)
    found = detection.scan(take)
    path = keeping.place(tmp_path / "findings", take.content_hash, detector="likelihood")
    assert keeping.kept(path) is None
    keeping.keep(path, found)
    back = keeping.kept(path)
    assert back == found
    for one, two in zip(found, back, strict=True):
        assert one.id == two.id
        assert (one.evidence is None) == (two.evidence is None)
        if one.evidence is not None:
            assert (one.evidence.name, one.evidence.threshold) == (
                two.evidence.name,
                two.evidence.threshold,
            )
            np.testing.assert_array_equal(one.evidence.signal, two.evidence.signal)
            if one.evidence.prediction is not None:
                np.testing.assert_array_equal(one.evidence.prediction, two.evidence.prediction)
    path.write_bytes(b"PK half a file")
    assert keeping.kept(path) is None
    other = keeping.place(tmp_path / "findings", take.content_hash, detector="another")
    assert other != path


def test_a_take_that_was_looked_at_opens_with_everything(
    make_desk: Callable[..., tuple[Desk, Ticks]],
):
    desk, _ = make_desk()
    assert isinstance(desk.opened, Opened)
    assert desk.opened.complete
    assert not desk.searching
    assert {f.kind for f in desk.findings} > {"gap"}
    assert "Still looking" not in queue.head(desk)


def test_how_small_a_slow_change_would_be_found_is_shown_by_marker(fresh: tuple[Desk, Ticks]):
    desk, ticks = fresh
    settle(desk, ticks)
    perform(desk, "thresholds")
    assert 'data-arg="slow_reach"' in dialogs.render(desk)
    perform(desk, "run", "slow_reach")
    assert (desk.dialog, desk.busy) == ("", "Measuring how small a slow change would be found")
    settle(desk, ticks)
    assert desk.opened is not None
    assert (desk.dialog, desk.busy) == ("slow_reach", "")
    assert desk.slow_reach == detection.smallest_slow_changes(desk.opened.take)
    said = dialogs.render(desk)
    assert desk.slow_reach
    assert all(f"<td>{row.marker}</td>" in said for row in desk.slow_reach)


def test_another_detector_cannot_say_how_small(fresh: tuple[Desk, Ticks]):
    desk, ticks = fresh
    settle(desk, ticks)
    desk.workspace.detector = "published"
    perform(desk, "slow_reach")
    settle(desk, ticks)
    assert "known of the detector likelihood, not of published" in desk.message
    assert desk.busy == ""


def test_what_is_measured_late_opens_nothing_over_what_is_being_written(
    fresh: tuple[Desk, Ticks], take_path: Path
):
    desk, ticks = fresh
    settle(desk, ticks)
    perform(desk, "slow_reach")
    perform(desk, "note")
    settle(desk, ticks)
    assert (desk.dialog, desk.busy) == ("note", "")
    assert desk.slow_reach
    assert "is measured" in desk.message
    desk.close_dialog()
    desk.slow_reach = None
    perform(desk, "slow_reach")
    desk.open(take_path)  # another take: what was measured is not of it
    settle(desk, ticks)
    assert (desk.slow_reach, desk.dialog) == (None, "")
