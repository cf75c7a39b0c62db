"""What the page says of an exercise or a second review under way, and what it asks."""

from datetime import UTC, datetime
from html import escape
from pathlib import Path
from typing import Any

import param
from panel.custom import JSComponent

from markermend.train import LEVELS
from markermend_app.state.second_review import Comparing
from markermend_app.style.kinds import glyph
from markermend_app.style.sheet import STYLESHEET
from markermend_app.views.markup import button, closing, footer, icon

STRIP_SHOWS = (
    "practice", "helping", "hints", "second", "adjudicating", "review", "findings", "feedback",
)  # fmt: skip
GOOD = ("right", "dismissed")


def strip(desk: Comparing) -> str:
    """Give the line under the header, where there is something to say."""
    if desk.practice is not None:
        return _practice(desk)
    if desk.second:
        return _bar(
            f"<b>Second review</b><span>by {escape(desk.person.name)}</span><span>What "
            f"{escape(' and '.join(desk.second))} decided is hidden until you finish.</span>",
            button("finish", "Finish the second review", classes="tool boxed"),
        )
    if desk.adjudicating:
        counts = desk.review.counts(desk.findings)
        return _bar(
            f"<b>Adjudication</b><span>of {escape(' and '.join(desk.adjudicating))}</span>"
            f'<span class="num">{counts.open} of {counts.total} are open; what they decided alike '
            "is settled.</span>",
            button("agreement", "Agreement", classes="tool boxed", key=False)
            + button("export", "Export…", classes="tool boxed", key=False),
        )
    return ""


def _bar(said: str, buttons: str) -> str:
    return f'<div class="strip">{said}<span class="push"></span>{buttons}</div>'


def _practice(desk: Comparing) -> str:
    practice = desk.practice
    assert practice is not None
    level = f"Level {practice.level}: " if practice.level else ""
    kinds = "".join(glyph(kind) for kind in practice.kinds)
    task = "Find what is wrong: I and O mark it" if practice.hidden else "Judge what is shown"
    said = (
        f'<b>Exercise {practice.number}</b><span title="{escape(practice.why)}">'
        f"{level}{escape(practice.title)}</span>"
        f'<span class="kinds" title="May be in it">{kinds}</span>'
        f"<span>{task}</span><span>{escape(practice.trainee)}</span>"
    )
    if practice.finished:
        return _bar(
            f"{said}<span>finished</span>",
            button("feedback", "Feedback", classes="tool boxed", key=False)
            + button("practise_next", "Next exercise", classes="tool boxed", key=False),
        )
    answers = "after each decision" if desk.helping else "at the end"
    bar = _bar(
        said,
        button(
            "practise_help",
            f"Answers {answers}",
            classes="tool on" if desk.helping else "tool",
            pressed=desk.helping,
            title="With answers after each decision the exercise does not count",
            key=False,
        )
        + button("finish", "Finish exercise", classes="tool boxed"),
    )
    return bar + "".join(
        f'<div class="hint">{icon("accepted" if m.outcome in GOOD else "rejected", 13)}'
        f"<span>{escape(m.why)}</span></div>"
        for m in desk.hints
    )


class Clock(JSComponent):
    """Counts the time of an exercise; the browser does it by itself."""

    elapsed_s = param.Number(default=0.0)
    runs = param.Boolean(default=False)

    _esm = Path(__file__).with_name("exercise.js")
    _stylesheets = [STYLESHEET]  # noqa: RUF012  (Panel's own convention)

    def __init__(self, desk: Comparing, **params: Any) -> None:
        super().__init__(**params)
        self._desk = desk
        desk.param.watch(self._follow, ["practice"])
        self._follow()

    def _follow(self, *_: object) -> None:
        practice = self._desk.practice
        if practice is None or practice.finished:
            self.runs = False
            return
        elapsed_s = (datetime.now(UTC) - practice.begun).total_seconds()
        self.param.update(elapsed_s=elapsed_s, runs=True)


def practise(desk: Comparing) -> str:
    """Ask for an exercise."""
    levels = "".join(
        f'<option value="{level.number}">{level.number}: {escape(level.title)}</option>'
        for level in LEVELS
    )
    return (
        '<header><h1 id="dialog-title">Practise</h1><p>A simulated person with artefacts whose '
        "truth is known and told at the end. Your own take: markermend train TAKE.</p></header>"
        '<div class="body"><label>Trainee<input type="text" name="trainee" '
        f'value="{escape(desk.person.name)}" data-autofocus spellcheck="false"></label>'
        '<label>Level<select class="field" name="level">'
        f'<option value="">What you need next</option>{levels}</select></label>'
        '<label class="check"><input type="checkbox" name="hidden"> Show no findings: find '
        "everything alone</label></div>"
        + footer(
            closing("Cancel"),
            button("practise_begin", "Begin<kbd>↵</kbd>", classes="deed primary", key=False),
        )
    )


def finish(desk: Comparing) -> str:
    """Say what is still open."""
    n = desk.review.counts(desk.findings).open
    what = "1 finding is" if n == 1 else f"{n} findings are"
    return (
        f'<header><h1 id="dialog-title">{what} still open</h1><p>What is open counts as missed '
        "where something is wrong, and as nothing where all is well.</p></header>"
        + footer(
            closing("Back"),
            button("finish", "Finish exercise", classes="deed primary"),
        )
    )


def second(desk: Comparing) -> str:
    """Ask who reviews the take once more: later, or at this desk at once."""
    return (
        '<header><h1 id="dialog-title">Second review, blinded</h1><p>The same findings; what '
        f"{escape(desk.person.name)} decided is hidden until the second review is finished.</p>"
        '</header><div class="body"><label>Second reviewer<input type="text" name="operator" '
        'data-autofocus spellcheck="false" autocomplete="off"></label>'
        '<label>Why, for a request<input type="text" name="note" autocomplete="off"></label>'
        '<p class="quiet">A request stands first in the list of takes of whoever is named, or of '
        "everybody else where nobody is.</p></div>"
        + footer(
            closing("Cancel"),
            button("second_request", "Request it", classes="deed", key=False),
            button("second_begin", "Begin here<kbd>↵</kbd>", classes="deed primary", key=False),
        )
    )


DIALOGS = {"practise": practise, "finish": finish, "second": second}
