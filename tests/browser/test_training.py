"""Practice, a blinded second review and an adjudication, in a real browser."""

from base64 import b64decode
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sqlalchemy import select

import markermend as mm
from markermend.comparing import agreement
from markermend.model import Finding, Span, Take
from markermend.review import Accept, AddFinding, Annotate, Command, Reclassify, Reject
from markermend.review.decisions import read_decisions
from markermend.review.schema import exercises, grades
from markermend.review.session import ReviewSession
from markermend.review.store import Store
from markermend.train import Exercise, make_exercise

from .desk_page import OPENS_MS, DeskPage, Server, until
from .traffic import Traffic, told, values

LEVEL, SEED, DENSITY = 5, 48_151_623, 27.0
Start = Callable[..., Server]


def swinging(n_groups: int = 3, n_frames: int = 900, rate: float = 100.0) -> Take:
    """Groups of markers that swing: small, so that everything here is quick."""
    rng = np.random.default_rng(11)
    t = np.arange(n_frames) / rate
    parts = []
    for g in range(n_groups):
        ways = (
            300 * np.sin(1.7 * t + g),
            120 * np.cos(1.1 * t + 2 * g),
            900 + 60 * np.sin(2.3 * t),
        )
        parts += [np.column_stack(ways) + offset for offset in rng.normal(0, 90, (4, 3))]
    positions = np.stack(parts, axis=1) + rng.normal(0, 0.1, (n_frames, 4 * n_groups, 3))
    return Take(positions, rate, [f"M{i}" for i in range(4 * n_groups)])


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Start]:
    servers: list[Server] = []

    def begin(command: str, *arguments: str | Path) -> Server:
        servers.append(Server(*arguments, store=tmp_path / "store.sqlite", command=command))
        return servers[-1]

    yield begin
    for server in servers:
        server.kill()


def text(page: Any, selector: str) -> str:
    return str(page.locator(selector).first.inner_text())


def decide(desk: DeskPage, key: str) -> str:
    """Decide on the finding at hand and wait until the next one is."""
    before = desk.selected
    desk.press(key)
    until(lambda: before in desk.rows(settled=True))
    if desk.rows():
        until(lambda: desk.selected != before)
        desk.settled()
    return before


def stored(path: Path) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    with Store(path) as store:
        made = [row.content for row in store.rows(select(exercises).order_by(exercises.c.id))]
        given = [row.result for row in store.rows(select(grades).order_by(grades.c.id))]
    return made, given


def test_an_exercise_to_its_feedback_and_no_truth_before(
    start: Start, open_page: Any, tmp_path: Path
) -> None:
    clean = tmp_path / "clean.c3d"
    mm.write(swinging(), clean)
    made = make_exercise(mm.read(clean), LEVEL, SEED, density=DENSITY)
    shown = mm.detect(made.take)
    wanted = ("--level", str(LEVEL), "--seed", str(SEED), "--density", str(DENSITY))
    server = start("train", clean, *wanted, "--trainee", "Jo")
    page = open_page("about:blank")
    traffic = Traffic(page)
    page.goto(server.url)
    desk = DeskPage(page)
    assert "Level 5: Steps and peaks" in text(page, ".strip")
    assert "Jo" in text(page, ".strip")
    assert set(desk.rows()) == {finding.id for finding in shown}

    # The same desk and the same keys; every repair is tried before the end.
    right = {(t.marker, t.span, t.kind) for t in made.truths}
    for _ in shown:
        finding = next(f for f in shown if f.id == desk.selected)
        decide(desk, "a" if (finding.marker, finding.span, finding.kind) in right else "f")
    before = traffic.heard()
    assert told(before, made, {(f.span.start, f.span.stop) for f in shown}) == []
    assert str(SEED).encode() not in before
    assert b"data-outcome" not in before
    wrong = made.answers[0]
    given = made.take.positions[wrong.span.frames, made.take.index(wrong.marker)]
    assert any(needle in before for needle in values(given, wrong.values)), "what is shown is heard"

    # The end: the page says what the grade in the store says.
    desk.press("Control+Enter")
    page.wait_for_selector(".sheet", timeout=OPENS_MS)
    _, (grade,) = stored(tmp_path / "store.sqlite")
    assert text(page, "#sheet-title") == grade["verdict"]
    outcomes = [m["outcome"] for m in grade["marks"]]
    assert page.locator("article.mark").count() == len(outcomes)
    assert page.locator('.mark[data-outcome="right"]').count() == outcomes.count("right") >= 2
    assert page.locator("article.mark .sight path").count() >= 2 * len(outcomes)
    assert page.locator(".sheet .curves figure").count() == 2
    link = page.locator('.sheet a[href^="data:text/html"]').get_attribute("href")
    assert "<h1>Jo</h1>" in b64decode(link.partition(",")[2]).decode()
    assert b"data-outcome" in traffic.heard(), "what is told at the end is heard"

    # What is finished stays as it is; one mark is looked at on the desk.
    page.locator("article.mark [data-do=feedback_look]").first.click()
    page.wait_for_selector(".sheet", state="detached")
    desk.press("u")
    desk.wait_for("The exercise is finished", ".message")

    # Another one, of a simulated person, in which nothing is shown: not even its spans are known.
    traffic.forget()
    desk.press("p")
    page.fill(".dialog input[name=words]", "practise truth")
    page.keyboard.press("Enter")
    page.check(".dialog input[name=hidden]")
    page.click(".dialog [data-do=practise_begin]")
    desk.wait_for("find what is wrong", ".empty")
    for key in ("i", ".", ".", "o"):
        desk.press(key)
    desk.settled()
    desk.press("q")
    decide(desk, "a")
    (_, second), _ = stored(tmp_path / "store.sqlite")
    hidden = make_exercise(
        None, second["level"], second["seed"], kinds=second["kinds"], hidden=True
    )
    before = traffic.heard()
    assert told(before, hidden) == []
    assert str(second["seed"]).encode() not in before
    desk.press("Control+Enter")
    page.wait_for_selector('.mark[data-outcome="missed"]', timeout=OPENS_MS)
    assert page.locator('.mark[data-outcome="invented"]').count() == 1


@dataclass(frozen=True)
class Reviewed:
    """A take with a first review."""

    path: Path
    take: Take
    findings: tuple[Finding, ...]
    added: Finding


@pytest.fixture
def reviewed(tmp_path: Path) -> Reviewed:
    path = tmp_path / "walk.c3d"
    made: Exercise = make_exercise(swinging(), LEVEL, SEED, density=DENSITY)
    mm.write(made.take, path)
    take = mm.read(path)
    findings = mm.detect(take)
    assert len(findings) >= 3
    added = Finding("M3", Span(20, 40), "noise")
    first, second, *others = findings
    with Store(tmp_path / "store.sqlite") as store:
        session = ReviewSession.open(store, take, "Anna")
        steps: list[Command] = [
            Annotate((first,), "surely the elbow"),
            Reclassify((first,), "slow"),
            Accept((first,), "linear"),
            Reject((second,)),
            AddFinding((added,)),
            Accept((added,), "pchip"),
            *(Accept((finding,), "linear") for finding in others),
        ]
        for step in steps:
            session.do(step)
    return Reviewed(path, take, findings, added)


def test_a_blinded_second_review_and_an_adjudication_that_exports(
    reviewed: Reviewed, start: Start, open_page: Any, tmp_path: Path
) -> None:
    server = start("review", reviewed.path, "--blind", "--operator", "Ben")
    page = open_page("about:blank")
    traffic = Traffic(page)
    page.goto(server.url)
    desk = DeskPage(page)

    # The same findings, open; what Anna said, and what she added, is nowhere.
    assert "by Ben" in text(page, ".strip")
    assert set(desk.rows()) == {finding.id for finding in reviewed.findings}
    assert desk.rows(settled=True) == []
    desk.press("p")
    page.fill(".dialog input[name=words]", "compare reviews")
    page.keyboard.press("Enter")
    desk.wait_for("shows the others when it is finished", ".message")
    for _ in reviewed.findings:
        page.locator('.repair[data-arg="pchip"]').click()
        page.wait_for_selector('.repair[data-arg="pchip"][aria-checked="true"]')
        decide(desk, "a")
    heard = traffic.heard()
    for secret in (b"surely the elbow", reviewed.added.id.encode()):
        assert secret not in heard, secret
    assert reviewed.findings[0].id.encode() in heard, "what is shown is heard"

    # Finished, both are compared: the page says what the library says of the two reviews.
    desk.press("Control+Enter")
    page.wait_for_selector(".sheet", timeout=OPENS_MS)
    with Store(tmp_path / "store.sqlite") as store:
        reviews = {
            record.operator: ReviewSession(store, record).review for record in store.reviews()
        }
    found = agreement(reviews, reviewed.take)
    assert f"{found.alpha_samples:.2f} over samples" in text(page, ".sheet header")
    shown = page.locator(".sheet .cross td").all_inner_texts()
    assert [int(n) for n in shown] == [n for row in found.pairs[0].spans for n in row]
    page.screenshot(path=tmp_path / "agreement.png")

    # A third review: side by side where they differ, one key takes one's decision over.
    page.click("[data-do=adjudicate]")
    page.wait_for_selector(".opinions", timeout=OPENS_MS)
    desk.settled()
    assert set(desk.rows()) == {f.id for f in (*reviewed.findings, reviewed.added)}
    taken: dict[str, str] = {}
    while desk.rows():
        key = ("6", "7", "f")[len(taken) % 3]
        page.wait_for_selector(".opinion .sight")
        taken[decide(desk, key)] = key
    desk.press("Control+s")
    page.wait_for_selector(".dialog input[name=target]", timeout=OPENS_MS)
    target = tmp_path / "settled.c3d"
    page.fill(".dialog input[name=target]", str(target))
    page.click("[data-do=export_write]")
    desk.wait_for("Exported and verified", ".dialog header")

    decisions = read_decisions(Path(f"{target}.decisions.json"))
    assert {one.operator for one in decisions.findings} == {"Ben"}
    anna, ben = reviews["Anna"], reviews["Ben"]
    for key, how in taken.items():
        said = decisions.review.judgements[key]
        if how == "f":
            assert said.decision.verdict == "rejected"
            continue
        theirs = (anna if how == "6" else ben).judgements.get(key)
        verdict = "rejected" if theirs is None else theirs.decision.verdict
        assert said.decision.verdict == verdict
        if theirs is not None and verdict == "accepted":
            assert (said.kind, said.span) == (theirs.kind, theirs.span)
            assert said.decision.method == theirs.decision.method
    back = mm.read(target)
    changed = (back.positions != reviewed.take.positions).any(axis=2)
    wishes = decisions.wishes(reviewed.take)
    assert wishes
    for wish in wishes:
        changed[wish.span.frames, reviewed.take.index(wish.marker)] = False
    assert not changed.any()
