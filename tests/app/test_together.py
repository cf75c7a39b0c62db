"""Several people at one store: who has a take, and what becomes of two who decide at once."""

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from tests.app.conftest import METHODS, Ticks, settle

from markermend.errors import Unreachable
from markermend.review.claims import claimed
from markermend.review.requests import requests
from markermend.review.store import Store
from markermend_app.state.intents import perform
from markermend_app.state.people import Person
from markermend_app.state.together import Together
from markermend_app.state.worker import Worker
from markermend_app.state.workspace import Workspace
from markermend_app.views import dialogs

Sit = Callable[[str], Together]


@pytest.fixture
def sit(tmp_path: Path, take_path: Path, worker: Worker, found_before: Path) -> Iterator[Sit]:
    """Give a function that opens the small take on the page of a person."""
    shutil.copytree(found_before, tmp_path / "findings")
    desks: list[Together] = []
    stores: list[Store] = []

    def opened(name: str) -> Together:
        stores.append(Store(tmp_path / "store.sqlite"))
        ticks = Ticks()
        workspace = Workspace(stores[-1], (take_path,), methods=METHODS, ahead=0, worker=worker)
        desk = Together(workspace, ticks, Person(name))
        desks.append(desk)
        desk.open(take_path)
        settle(desk, ticks)
        return desk

    yield opened
    for desk in desks:
        desk.close()
    for store in stores:
        store.close()


def names(desk: Together) -> list[str]:
    return [one.operator for one in claimed(desk.workspace.store)]


def test_a_take_is_claimed_while_it_is_at_hand(sit: Sit) -> None:
    anna = sit("anna")
    assert names(anna) == ["anna"]
    assert (anna.holder, anna.message) == ("", "")
    again = sit("anna")  # another window of hers
    assert again.holder == ""
    anna.close()
    assert names(again) == ["anna"]
    again.close()
    assert names(again) == []


def test_who_comes_second_hears_who_has_it_and_overwrites_nobody(sit: Sit) -> None:
    anna, bo = sit("anna"), sit("bo")
    assert bo.holder == "anna"
    assert "anna has been reviewing this take since" in bo.message
    bo.reject()
    assert (len(anna.session.review), len(bo.session.review)) == (0, 1)  # type: ignore[union-attr]
    assert names(anna) == ["anna"]


def test_one_looks_on_and_cannot_decide(sit: Sit) -> None:
    anna, bo = sit("anna"), sit("bo")
    anna.reject()
    perform(bo, "look_on")
    assert bo.looking_on
    assert bo.review == anna.review
    bo.reject()
    bo.undo()
    assert bo.message == "anna has this take; you look on. Take it over to decide."
    assert len(bo.session.review) == 1  # type: ignore[union-attr]


def test_a_take_is_taken_over_on_purpose(sit: Sit) -> None:
    anna, bo = sit("anna"), sit("bo")
    anna.reject()
    perform(bo, "take_over")
    assert (bo.holder, bo.looking_on, names(bo)) == ("", False, ["bo"])
    bo.reject()
    assert len(bo.review) == 2
    anna.reject()
    assert anna.holder == "bo"
    assert anna.message == "bo has taken this review over; look on, or take it over again."
    perform(anna, "look_on")
    assert anna.review == bo.review


@pytest.mark.parametrize("way", ["mine", "theirs", "both"])
def test_two_windows_that_decide_at_once_are_shown_and_settled(sit: Sit, way: str) -> None:
    one, two = sit("anna"), sit("anna")
    one.reject()
    two.defer()
    assert two.conflict is not None
    assert "Meanwhile: anna: Reject" in two.message
    assert "Yours: Set aside" in two.message
    first = one.session.review  # type: ignore[union-attr]
    perform(two, f"settle_{way}")
    assert two.conflict is None
    verdicts = {judged.decision.verdict for judged in two.review}
    assert verdicts == {"theirs": {"rejected"}}.get(way, {"deferred"})
    one.session.refresh()  # type: ignore[union-attr]
    assert (one.session.review == first) == (way != "mine")  # type: ignore[union-attr]
    assert len(two.workspace.store.reviews()) == (2 if way == "both" else 1)


def test_a_second_review_is_asked_for_seen_and_answered(sit: Sit) -> None:
    anna = sit("anna")
    anna.reject()
    perform(anna, "second")
    assert 'data-do="second_request"' in dialogs.render(anna)
    perform(anna, "second_request", fields={"operator": "bo", "note": "for the paper"})
    assert anna.dialog == ""
    assert anna.message == "bo will see that a second review is asked for."
    anna.close()
    bo = sit("bo")
    assert bo.message.startswith("anna asks for a second review of this take (for the paper);")
    store = bo.workspace.store
    perform(bo, "takes")
    assert "anna asks: for the paper" in dialogs.render(bo)
    bo.close_dialog()
    perform(bo, "second")
    assert (bo.second, bo.dialog) == (("anna",), "")
    bo.reject()
    bo.finish_second()
    assert requests(store) == ()
    (done,) = requests(store, ended=True)
    assert done.review == bo.session.record.id  # type: ignore[union-attr]


def test_what_no_store_has_is_shown_as_unsaved_and_saved_later(
    sit: Sit, monkeypatch: pytest.MonkeyPatch
) -> None:
    anna = sit("anna")

    def nobody(*_: object) -> None:
        raise Unreachable("The store does not answer.")

    with monkeypatch.context() as patch:
        patch.setattr(anna.workspace.store, "append", nobody)
        anna.reject()
        assert len(anna.unsaved) == 1
        assert anna.unsaved[0].startswith("Reject ")
        assert anna.message.endswith("1 decision is kept here, not saved yet.")
        assert len(anna.review) == 0
    perform(anna, "save")
    assert anna.unsaved == ()
    assert anna.message == ""
    assert len(anna.review) == 1
