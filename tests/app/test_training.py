"""Exercises, second reviews and adjudication on a desk without a screen."""

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import markermend as mm
from markermend.comparing import agreement
from markermend.model import Finding, Span, Take
from markermend.review import Accept, AddFinding, Reclassify, Reject, Review
from markermend.review.decisions import decisions_on, read_decisions
from markermend.review.session import ReviewSession
from markermend.review.store import Store
from markermend.train import Request, archive, make_exercise
from markermend_app.state.intents import perform
from markermend_app.state.people import Person
from markermend_app.state.second_review import Comparing
from markermend_app.state.training import Trainer
from markermend_app.state.worker import Worker
from markermend_app.state.workspace import Workspace
from markermend_app.views import adjudication, dialogs, exercise, exercise_feedback

from .conftest import METHODS, Command, Ticks, made_take, settle

LEVEL, SEED, DENSITY = 2, 4_815_162, 20.0
Make = Callable[..., tuple[Comparing, Ticks]]


def clean_take() -> Take:
    """The small take as it would be without its artefacts."""
    take = made_take()
    positions = take.positions[:, :9].copy()
    positions[200:240, 2] = positions[199, 2]
    positions[400, 6] = positions[399, 6]
    return Take(positions, 100, take.labels[:9])


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    with Store(tmp_path / "store.sqlite") as store:
        yield store


@pytest.fixture
def make(store: Store, tmp_path: Path, worker: Worker, found_before: Path) -> Iterator[Make]:
    shutil.copytree(found_before, tmp_path / "findings")
    desks: list[Comparing] = []

    def new(
        *paths: Path, trainer: Trainer | None = None, name: str = "ben"
    ) -> tuple[Comparing, Ticks]:
        ticks = Ticks()
        workspace = Workspace(store, paths, methods=METHODS, ahead=0, worker=worker)
        desks.append(Comparing(workspace, ticks, Person(name, "teacher"), trainer=trainer))
        return desks[-1], ticks

    yield new
    for desk in desks:
        desk.close()


def practising(make: Make, store: Store, **wanted: object) -> tuple[Comparing, Ticks, Trainer]:
    request = Request(clean_take(), LEVEL, SEED, density=DENSITY, **wanted)  # type: ignore[arg-type]
    trainer = Trainer(store, request, methods=("linear", "rigid"))
    desk, ticks = make(trainer=trainer)
    desk.practise()
    settle(desk, ticks)
    return desk, ticks, trainer


def solve(desk: Comparing, ticks: Ticks) -> None:
    """Say of everything that is shown what it is, by the truth."""
    truths = make_exercise(clean_take(), LEVEL, SEED, density=DENSITY).truths
    true = {(truth.marker, truth.span.start) for truth in truths}
    while desk.queue:
        desk.select(desk.queue[0])
        settle(desk, ticks)
        here = (desk.current.marker, desk.current.span.start) in true
        perform(desk, "accept" if here else "reject")
        settle(desk, ticks)


def test_an_exercise_is_graded_at_its_end_and_counts_once(make: Make, store: Store) -> None:
    desk, ticks, _ = practising(make, store)
    assert desk.opened.name == f"Exercise {desk.practice.number}"
    assert desk.session.record.purpose == "exercise"
    assert str(SEED) not in exercise.strip(desk)
    solve(desk, ticks)
    perform(desk, "finish")
    settle(desk, ticks)
    assert desk.dialog == "feedback"
    told = desk.feedback
    assert told.grade.count("right") == len(
        make_exercise(clean_take(), LEVEL, SEED, density=DENSITY).truths
    )
    assert told.n_done == 1
    page = exercise_feedback.sheet(desk)
    for mark in told.grade.marks:
        assert mark.marker in page
    assert page.count("<article") == page.count('class="sight"') == len(told.sights)
    (result,) = archive.results(store, "ben")
    assert result.trainee == "ben"

    # What is finished stays; the next exercise is another one.
    perform(desk, "close")
    perform(desk, "undo")
    assert "finished" in desk.message
    number = desk.practice.number
    perform(desk, "practise_next")
    settle(desk, ticks)
    assert desk.practice.number != number
    assert desk.locked


def test_the_curves_of_a_feedback_are_distances_to_the_truth(make: Make, store: Store) -> None:
    desk, ticks, _ = practising(make, store)
    solve(desk, ticks)
    perform(desk, "finish")
    settle(desk, ticks)
    made = make_exercise(clean_take(), LEVEL, SEED, density=DENSITY)
    for mark, seen in zip(desk.feedback.grade.marks, desk.feedback.sights, strict=True):
        axis = "xyz".index(seen.axis)
        m = made.take.index(mark.marker)
        off = (made.take.positions - made.clean.positions)[mark.span.frames, m, axis]
        inside = (seen.time >= seen.start_s) & (seen.time < seen.stop_s)
        np.testing.assert_allclose(seen.lines["recorded"][inside], off)
        assert not seen.lines["truth"].any()


def test_a_page_that_is_loaded_again_goes_on_with_its_exercise(make: Make, store: Store) -> None:
    desk, ticks, trainer = practising(make, store)
    perform(desk, "reject")
    settle(desk, ticks)
    again, later = make(trainer=trainer)
    again.practise()
    settle(again, later)
    assert again.practice == desk.practice
    assert again.review == desk.review
    perform(again, "finish")
    perform(again, "finish")  # findings are open: it is asked for once more
    settle(again, later)
    third, last = make(trainer=trainer)
    third.practise()
    settle(third, last)
    assert third.dialog == "feedback"
    assert third.feedback is again.feedback


def test_the_same_exercise_once_more_is_begun_anew_and_does_not_count(
    make: Make, store: Store
) -> None:
    for purpose in ("exercise", "exercise 2"):
        desk, _, trainer = practising(make, store)
        assert desk.session.record.purpose == purpose
        assert not len(desk.review)
        perform(desk, "reject")
        assert trainer.finish("ben", desk.session, lambda done, total: None).n_done == 1


def test_nothing_leads_from_an_exercise_to_its_truth(
    make: Make, store: Store, take_path: Path
) -> None:
    desk, ticks, _ = practising(make, store)
    opened = desk.opened
    for intention, arg in (("open", str(take_path)), ("takes", None), ("agreement", None)):
        perform(desk, intention, arg)
        settle(desk, ticks)
        assert desk.opened is opened
        assert "under way" in desk.message
        assert not desk.dialog
        desk.dismiss()
    perform(desk, "export")
    assert desk.dialog == "finish"
    assert "still open" in dialogs.render(desk)
    perform(desk, "close")
    perform(desk, "practise_leave")
    desk.open(take_path)
    settle(desk, ticks)
    assert desk.opened is not opened
    assert desk.practice is None


def test_answers_after_each_decision_are_help_that_does_not_count(make: Make, store: Store) -> None:
    desk, ticks, _ = practising(make, store)
    perform(desk, "practise_help")
    perform(desk, "accept")
    settle(desk, ticks)
    assert desk.hints
    assert desk.practice.helped
    for mark in desk.hints:
        assert mark.why.partition("'")[0] in exercise.strip(desk)
    solve(desk, ticks)
    perform(desk, "finish")
    settle(desk, ticks)
    assert desk.feedback.n_done == 0
    assert archive.results(store) == ()


def test_where_nothing_is_shown_everything_is_added(make: Make, store: Store) -> None:
    desk, ticks, _ = practising(make, store, hidden=True)
    assert desk.findings == ()
    assert desk.empty
    truths = make_exercise(clean_take(), LEVEL, SEED, density=DENSITY).truths
    for truth in truths:
        desk.select_marker(desk.opened.take.index(truth.marker))
        desk.add_span(truth.span.start, truth.span.stop)
        settle(desk, ticks)
        perform(desk, f"kind_{truth.kind}")
        settle(desk, ticks)
        perform(desk, "accept")
        settle(desk, ticks)
    perform(desk, "finish")
    settle(desk, ticks)
    assert desk.feedback.grade.count("right") == len(truths)


# a second review, and what is made of both


@pytest.fixture
def reviewed(store: Store, take_path: Path) -> tuple[Take, tuple[Finding, ...], Finding]:
    take = mm.read(take_path)
    findings = mm.detect(take)
    added = Finding("M3", Span(20, 40), "noise")
    session = ReviewSession.open(store, take, "anna")
    session.do(AddFinding((added,)))
    session.do(Accept((added,), "pchip"))
    session.do(Reclassify((findings[0],), "slow"))
    session.do(Accept((findings[0],), "linear"))
    session.do(Reject(findings[1:]))
    return take, findings, added


def second(make: Make, take_path: Path) -> tuple[Comparing, Ticks]:
    desk, ticks = make(take_path)
    desk.open_blind()
    settle(desk, ticks)
    return desk, ticks


def test_a_second_review_sees_nothing_of_the_first(
    make: Make, take_path: Path, reviewed: tuple[Take, tuple[Finding, ...], Finding]
) -> None:
    _, findings, added = reviewed
    desk, ticks = second(make, take_path)
    assert desk.second == ("anna",)
    assert desk.session.operator == "ben"
    assert not len(desk.review)
    assert {f.id for f in desk.findings} == {f.id for f in findings}
    assert desk.find(added.id) is None
    perform(desk, "agreement")
    assert "when it is finished" in desk.message
    assert "anna" in exercise.strip(desk)
    perform(desk, "accept")
    settle(desk, ticks)
    perform(desk, "finish")
    settle(desk, ticks)
    assert (desk.dialog, desk.second) == ("agreement", ())
    again, _ = second(make, take_path)
    assert again.second == ()


def test_the_first_reviewer_may_ask_for_a_second(make: Make, take_path: Path) -> None:
    desk, ticks = make(take_path, name="anna")
    desk.open(take_path)
    settle(desk, ticks)
    perform(desk, "reject")
    settle(desk, ticks)
    perform(desk, "second")
    assert "anna decided is hidden" in dialogs.render(desk)
    perform(desk, "second_begin", None, {"operator": "anna"})
    assert "needs somebody else" in desk.message
    perform(desk, "second_begin", None, {"operator": "ben"})
    settle(desk, ticks)
    assert desk.session.operator == desk.person.name == "ben"
    assert not len(desk.review)
    assert desk.second == ("anna",)


def test_who_has_signed_in_stays_who_it_is(make: Make, take_path: Path) -> None:
    desk, ticks = make(take_path, name="anna")
    desk.open(take_path)
    settle(desk, ticks)
    desk.workspace.reach = object()
    perform(desk, "second_begin", None, {"operator": "ben"})
    assert "signed in as anna" in desk.message
    assert desk.person.name == "anna"


def test_the_page_of_an_agreement_says_what_the_library_says(
    make: Make, store: Store, take_path: Path, reviewed: tuple[Take, tuple[Finding, ...], Finding]
) -> None:
    take, _, _ = reviewed
    desk, ticks = second(make, take_path)
    perform(desk, "accept")
    settle(desk, ticks)
    perform(desk, "finish")
    settle(desk, ticks)
    reviews = {r.operator: ReviewSession(store, r).review for r in store.reviews()}
    assert desk.compared.agreement == agreement(reviews, take)
    page = exercise_feedback.sheet(desk)
    assert f"{desk.compared.agreement.alpha_samples:.2f} over samples" in page
    perform(desk, "agreement_expert", "anna")
    settle(desk, ticks)
    assert desk.compared.agreement == agreement(reviews, take, expert="anna")
    assert [row.operator for row in desk.compared.agreement.table2] == ["none", "anna", "ben"]


def test_an_adjudication_follows_one_the_other_or_neither_and_exports(
    make: Make, take_path: Path, reviewed: tuple[Take, tuple[Finding, ...], Finding], tmp_path: Path
) -> None:
    take, findings, added = reviewed
    desk, ticks = second(make, take_path)
    for _ in range(2):
        perform(desk, "choose", "rigid")
        perform(desk, "accept")
        settle(desk, ticks)
    perform(desk, "finish")
    settle(desk, ticks)
    perform(desk, "adjudicate")
    settle(desk, ticks)
    assert desk.adjudicating == ("anna", "ben")
    assert desk.session.record.purpose == "adjudication"
    assert {f.id for f in desk.findings} == {f.id for f in (*findings, added)}

    desk.select(added.id)
    assert [one.words for one in desk.opinions] == ["noise 20–39, pchip", "nothing is wrong here"]
    assert adjudication.opinions(desk).count("<svg viewBox") == 2
    perform(desk, "opinion_1")
    settle(desk, ticks)
    assert desk.review.decision(added.id).verdict == "accepted"
    assert desk.review.judgements[added.id].added

    desk.select(findings[0])
    perform(desk, "opinion_1")
    settle(desk, ticks)
    judged = desk.review.judgements[findings[0].id]
    assert (judged.kind, judged.decision.method) == ("slow", "linear")
    perform(desk, "undo")  # one gesture is one command
    settle(desk, ticks)
    assert desk.review.decision(findings[0]).verdict is None
    desk.select(findings[0])
    perform(desk, "opinion_2")
    settle(desk, ticks)
    assert desk.review.judgements[findings[0].id].kind == findings[0].kind
    for finding in findings[1:]:
        desk.select(finding)
        settle(desk, ticks)
        perform(desk, "reject")
        settle(desk, ticks)
    assert not desk.queue

    perform(desk, "export")
    settle(desk, ticks)
    desk.export(tmp_path / "settled.c3d")
    settle(desk, ticks)
    decisions = read_decisions(tmp_path / "settled.c3d.decisions.json")
    accepted = [(w.marker, w.span, w.kind, w.method) for w in decisions.review.accepted()]
    assert accepted == [(w.marker, w.span, w.kind, w.method) for w in desk.review.accepted()]
    assert {wish.marker for wish in decisions.wishes(take)} == {"M3", findings[0].marker}


# how the commands begin


@pytest.fixture
def served(monkeypatch: pytest.MonkeyPatch, store: Store) -> list[Any]:
    """What the commands would serve; nothing listens."""
    monkeypatch.setenv("MARKERMEND_STORE", store.where)
    found: list[Any] = []
    for name in ("train", "agree", "review"):
        monkeypatch.setattr(
            f"markermend_app.cli.{name}.serve", lambda options, *given: found.append(given)
        )
    return found


def test_train_begins_with_an_exercise(
    make: Make, command: Command, served: list[Any], tmp_path: Path
) -> None:
    clean = tmp_path / "clean.npz"
    mm.write(clean_take(), clean)
    ended = command("train", clean, "--level", 2, "--seed", 5, "--hidden", "--operator", "jo")
    assert (ended.code, ended.out) == (0, "")
    ((paths, begin, _),) = served
    assert paths == ()
    desk, ticks = make()
    begin(desk)
    settle(desk, ticks)
    assert (desk.practice.trainee, desk.practice.level, desk.practice.hidden) == ("jo", 2, True)
    take = make_exercise(mm.read(clean), 2, 5).take
    assert desk.opened.take.content_hash == take.content_hash


def test_agree_begins_with_the_tables(
    make: Make, command: Command, served: list[Any], tmp_path: Path, take_path: Path
) -> None:
    take = mm.read(take_path)
    finding = mm.detect(take)[0]
    for name, decision in (("anna", Accept((finding,), "linear")), ("ben", Reject((finding,)))):
        review = decision.apply(Review())
        decisions_on(take, review).write(tmp_path / f"{name}.json")
    files = (tmp_path / "anna.json", tmp_path / "ben.json")
    assert command("agree", *files, "--page").code == 0
    assert command("agree", *files, "--page", "--take", take_path).code == 0
    (without, begin), (paths, begin_with) = served
    assert (without, paths) == ((), (take_path,))
    desk, ticks = make()
    begin(desk)
    settle(desk, ticks)
    assert desk.compared.agreement.names == ("anna.json", "ben.json")
    assert 'data-do="adjudicate" type="button" title="Needs the take' in exercise_feedback.sheet(
        desk
    )
    desk, ticks = make(take_path)
    begin_with(desk)
    settle(desk, ticks)
    perform(desk, "adjudicate")
    settle(desk, ticks)
    assert [one.words for one in desk.opinions] == [
        f"{finding.kind} {finding.span.start}–{finding.span.stop - 1}, linear",
        "false alarm",
    ]


def test_review_blind_needs_somebody_else(
    make: Make,
    command: Command,
    served: list[Any],
    take_path: Path,
    reviewed: tuple[Take, tuple[Finding, ...], Finding],
) -> None:
    refused = command("review", take_path, "--blind", "--operator", "anna")
    assert "name the second reviewer with --operator" in refused.refusal
    assert command("review", take_path, "--blind", "--operator", "ben").code == 0
    ((paths, begin),) = served
    desk, ticks = make(*paths, name="whoever")
    begin(desk)
    settle(desk, ticks)
    assert desk.session.operator == "ben"
    assert desk.second == ("anna",)
