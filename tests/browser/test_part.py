"""A list that is drawn anew while somebody is about to choose from it."""

from collections.abc import Callable
from typing import Any

import panel as pn
import param
import pytest
from playwright.sync_api import Page

from markermend_app.views.part import Part

from .desk_page import until

ROW = "height:30px;display:block;width:200px"


class Listed(param.Parameterized):
    selected = param.String("first")
    names = param.Parameter(("a", "b", "c", "d"))
    values = param.Parameter({})


def render(state: Listed) -> str:
    rows = "".join(
        f'<button style="{ROW}" data-key="{name}" data-do="choose" data-arg="{name}">'
        f"{name} {state.values.get(name, '…')}</button>"
        for name in state.names
    )
    return (
        f'<div><p>{state.selected}</p><div class="list" data-steady="{state.selected}">{rows}</div>'
        "</div>"
    )


class Shown:
    """A part on a page, what it shows and what it sends."""

    def __init__(self, serve: Callable[..., str], open_page: Callable[..., Page]) -> None:
        self.state, self.sent, self.locked = Listed(), [], []
        self.documents: list[Any] = []

        def part() -> Part:
            made = Part(
                render,
                self.state,
                ("names", "values", "selected"),
                self._hear,
                sizing_mode="stretch_width",
            )
            self.documents.append(made)
            return made

        self.page = open_page(serve(part))
        self.page.wait_for_selector('[data-key="a"]')

    def _hear(self, name: str, arg: str, fields: Any) -> None:
        self.sent.append(arg)
        session = pn.state.curdoc.session_context.session
        self.locked.append(session._pending_writes is not None)

    def change(self, **values: Any) -> None:
        """Let Python show something else, on the page's own thread."""
        (part,) = self.documents
        (document,) = {model.document for model, _ in part._models.values()}
        document.add_next_tick_callback(lambda: self.state.param.update(**values))

    @property
    def rows(self) -> list[str]:
        return [text.split()[0] for text in self.page.locator(".list button").all_inner_texts()]

    def to(self, row: str) -> None:
        box = self.page.locator(f'[data-key="{row}"]').bounding_box()
        self.page.mouse.move(box["x"] + 20, box["y"] + 15, steps=3)

    def away(self) -> None:
        self.page.mouse.move(600, 500, steps=3)


@pytest.fixture
def shown(serve: Any, open_page: Any) -> Shown:
    return Shown(serve, open_page)


ORDER = ("d", "c", "b", "a")
VALUES = {name: f"{i}.0" for i, name in enumerate("abcd")}


def test_what_was_pressed_is_what_is_chosen(shown: Shown):
    shown.to("b")
    shown.page.mouse.down()
    shown.change(names=ORDER, values=VALUES, selected="first")
    shown.page.wait_for_timeout(300)
    assert shown.rows == ["a", "b", "c", "d"], "nothing moves while the button is down"
    shown.page.mouse.up()
    until(lambda: shown.sent == ["b"])
    shown.page.get_by_text("b 1.0").wait_for()
    assert shown.rows == ["a", "b", "c", "d"], "the pointer is still over the list"
    shown.away()
    assert shown.rows == ["a", "b", "c", "d"], "nor while the row has the focus"
    shown.page.locator('[data-key="b"]').evaluate("(it) => it.blur()")
    until(lambda: shown.rows == list(ORDER))
    assert shown.sent == ["b"]
    assert shown.locked == [True], "the page may be changed even while an answer is being sent"


def test_rows_keep_their_places_under_the_pointer(shown: Shown):
    shown.to("c")
    shown.change(names=("d", "b", "a", "e"), values=VALUES)
    shown.page.get_by_text("d 3.0").wait_for()
    assert shown.rows == ["a", "b", "c", "d", "e"], "new values, the order as it was"
    shown.page.mouse.down()
    shown.page.mouse.up()
    shown.page.wait_for_timeout(100)
    assert shown.sent == [], "what is no longer offered cannot be chosen"
    shown.away()
    until(lambda: shown.rows == ["d", "b", "a", "e"])
    # A pointer that rests where another finding's list appears holds nothing back.
    shown.to("a")
    shown.change(selected="second", names=ORDER)
    until(lambda: shown.rows == ["d", "c", "b", "a"])


def test_the_focus_stays_and_holds_the_order(shown: Shown):
    shown.page.locator('[data-key="b"]').focus()
    shown.change(names=ORDER, values=VALUES)
    shown.page.get_by_text("b 1.0").wait_for()
    assert shown.rows == ["a", "b", "c", "d"]
    shown.change(selected="second")
    until(lambda: shown.rows == list(ORDER))
    assert shown.page.locator('[data-key="b"]').evaluate("(it) => it.matches(':focus')")
