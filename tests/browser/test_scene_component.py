"""The 3D view as it is really drawn, and the key listener as it is really pressed."""

import itertools
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import panel as pn
import pytest

from markermend_app.plots.scene import scene_colours
from markermend_app.views.keyboard import KeyListener
from markermend_app.views.playheads import Playheads
from markermend_app.views.scene import Focus, SceneView

N_FRAMES, RATE = 3000, 100.0
LABELS = ["HEAD", "LSHO", "RSHO", "LWRA", "RWRA", "PELV", "LANK", "RANK"]
BONES = [(0, 1), (0, 2), (1, 3), (2, 4), (0, 5), (5, 6), (5, 7)]
WRIST, ANKLE = 3, 6
SPAN = (100, 200)
UNSEEN = (1000, 1100)
ACCENT = tuple(int(scene_colours("light")["accent"][i : i + 2], 16) for i in (1, 3, 5))
DARK_VIEW = tuple(int(scene_colours("dark")["view"][i : i + 2], 16) for i in (1, 3, 5))


def figure() -> np.ndarray:
    """A standing figure that waves its left wrist up and down, and is unseen for a second."""
    standing = np.array(
        [
            (0, 0, 1750),
            (0, 250, 1450),
            (0, -250, 1450),
            (0, 420, 1000),
            (0, -420, 900),
            (0, 0, 950),
            (0, 150, 80),
            (0, -150, 80),
        ],
        float,
    )
    positions = np.tile(standing, (N_FRAMES, 1, 1))
    positions[:, WRIST, 2] += 350 * np.sin(2 * np.pi * np.arange(N_FRAMES) / 200)
    positions[slice(*UNSEEN), WRIST] = np.nan
    return positions


def focus(colour: str = "#A77F19") -> Focus:
    repaired = figure()[slice(*SPAN), WRIST]
    raw = repaired + np.array([0, 300, 0])
    return Focus(WRIST, *SPAN, colour, (1, 5), raw, repaired)


class Stage:
    """One served view and the page that shows it."""

    def __init__(self, serve: Any, open_page: Any, **how: Any) -> None:
        self.views: list[SceneView] = []

        def factory() -> SceneView:
            view = SceneView(width=600, height=500)
            view.show_take(figure(), RATE, LABELS, BONES, frame=50)
            self.views.append(view)
            return view

        self.page = open_page(serve(factory), **how)
        self.page.wait_for_function("window.markermendScene?.ready")
        self.view = self.views[0]

    def js(self, expression: str) -> Any:
        return self.page.evaluate(f"markermendScene.{expression}")

    def wait(self, expression: str) -> None:
        self.page.wait_for_function(f"markermendScene.{expression}")

    def python(self, change: Callable[[SceneView], None]) -> None:
        """Change the view as the application does, in the session's own turn."""
        document = next(iter(self.view._models.values()))[0].document
        document.add_next_tick_callback(lambda: change(self.view))

    def seek(self, frame: int) -> None:
        self.python(lambda view: view.param.update(frame=frame))
        self.wait(f"frame === {frame}")

    def colour_at(self, x: float, y: float) -> tuple[int, ...]:
        return tuple(self.js(f"colourAt({x}, {y})"))


@pytest.fixture
def stage(serve: Any, open_page: Any) -> Stage:
    return Stage(serve, open_page)


def near(colour: tuple[int, ...], other: tuple[int, ...], within: int = 12) -> bool:
    return max(abs(a - b) for a, b in zip(colour, other, strict=True)) <= within


def until(true: Callable[[], bool], seconds: float = 10.0) -> None:
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end, "it did not come true in time"
        time.sleep(0.02)


def test_selected_marker_is_drawn_where_it_is_and_moves(stage: Stage) -> None:
    assert stage.js("renderer") == "webgl"
    stage.python(lambda view: view.show_focus(focus()))
    stage.wait(f"selected === {WRIST}")
    stage.seek(50)
    high = stage.js(f"markerPixel({WRIST})")
    assert near(stage.colour_at(*high), ACCENT)
    stage.seek(150)
    low = stage.js(f"markerPixel({WRIST})")
    assert low[1] - high[1] > 40, "700 mm further down"
    assert near(stage.colour_at(*low), ACCENT)
    assert not near(stage.colour_at(*high), ACCENT), "it left its former place"


def test_raw_ghost_is_a_ring_beside_the_repair_within_the_span_only(stage: Stage) -> None:
    stage.python(lambda view: view.show_focus(focus("#D000D0")))
    stage.seek(150)
    x, y = stage.js("ghostPixel()")
    row = [stage.colour_at(x + dx, y) for dx in range(-12, 13)]
    assert any(near(colour, (0xD0, 0, 0xD0), 30) for colour in row)
    assert not near(stage.colour_at(x, y), (0xD0, 0, 0xD0), 60), "it is hollow"
    stage.seek(SPAN[1])
    assert stage.js("ghostPixel()") is None
    assert stage.js("neighbours") == [1, 5]


def test_unseen_marker_is_hidden_and_comes_back(stage: Stage) -> None:
    stage.python(lambda view: view.param.update(selected=WRIST))
    stage.seek(UNSEEN[0] - 1)
    x, y = stage.js(f"markerPixel({WRIST})")
    assert near(stage.colour_at(x, y), ACCENT)
    stage.seek(UNSEEN[0])
    assert stage.js(f"markerPixel({WRIST})") is None
    stage.seek(UNSEEN[1])
    assert stage.js(f"markerPixel({WRIST})") is not None


def test_accepted_repair_reaches_what_was_already_sent(stage: Stage) -> None:
    values = np.tile((0.0, 420.0, 1000.0), (UNSEEN[1] - UNSEEN[0], 1))
    stage.seek(1050)
    assert stage.js(f"markerPixel({WRIST})") is None
    stage.python(lambda view: view.amend(WRIST, UNSEEN, values))
    stage.wait(f"markerPixel({WRIST}) !== null")


def test_click_selects_the_marker_everywhere(stage: Stage) -> None:
    x, y = stage.js(f"markerPixel({ANKLE})")
    stage.page.mouse.click(x, y)
    stage.wait(f"selected === {ANKLE}")
    until(lambda: stage.view.selected == ANKLE)
    assert stage.page.locator(".label").inner_text() == "LANK"


def test_playback_runs_in_the_browser_and_loops(stage: Stage) -> None:
    stage.page.evaluate(
        "window.heard = [];addEventListener('markermend:frame', (e) => heard.push(e.detail.frame))"
    )
    stage.python(lambda view: view.param.update(frame=100, loop=(100, 160), playing=True))
    stage.page.wait_for_function("heard.some((f, i) => i > 0 && f < heard[i - 1])")
    stage.python(lambda view: view.param.update(playing=False))
    stage.page.wait_for_function("!markermendScene.owner.player.playing")
    heard = stage.page.evaluate("heard.slice(1)")
    assert all(100 <= frame < 160 for frame in heard)
    until(lambda: stage.view.frame == stage.js("frame"))


def test_playback_never_steps_back(stage: Stage) -> None:
    stage.page.evaluate(
        "window.heard = [];addEventListener('markermend:frame', (e) => heard.push(e.detail.frame))"
    )
    stage.python(lambda view: view.param.update(frame=300, speed=2.0, playing=True))
    stage.page.wait_for_function("heard.at(-1) > 700")
    stage.python(lambda view: view.param.update(playing=False))
    heard = stage.page.evaluate("heard")
    assert len(heard) > 10
    assert all(later > earlier for earlier, later in itertools.pairwise(heard))


def test_other_parts_of_the_page_seek_step_and_play_without_python(stage: Stage) -> None:
    send = "(n, d) => dispatchEvent(new CustomEvent(n, {detail: d}))"
    stage.page.evaluate(f"({send})('markermend:seek', {{time: 7.25}})")
    stage.wait("frame === 725")
    stage.page.evaluate(f"({send})('markermend:step', {{by: -1}})")
    stage.wait("frame === 724")
    until(lambda: stage.view.frame == 724)
    stage.page.evaluate(f"({send})('markermend:play')")
    until(lambda: stage.view.playing)
    stage.page.evaluate(f"({send})('markermend:step', {{by: 1}})")
    until(lambda: not stage.view.playing)


def test_camera_survives_everything_but_another_take(stage: Stage) -> None:
    box = stage.page.locator(".draw").bounding_box()
    assert box is not None
    before = stage.js("camera")
    stage.page.mouse.move(box["x"] + 100, box["y"] + 100)
    stage.page.mouse.down()
    stage.page.mouse.move(box["x"] + 200, box["y"] + 130, steps=4)
    stage.page.mouse.up()
    stage.page.mouse.wheel(0, -200)
    until(lambda: stage.js("camera")["distance"] < before["distance"])
    turned = stage.js("camera")
    assert turned["azimuth"] != before["azimuth"]
    until(lambda: stage.view.view == "free")

    stage.python(lambda view: view.param.update(colours=scene_colours("dark"), selected=2))
    stage.python(lambda view: view.show_focus(focus()))
    stage.seek(160)
    for name in ("azimuth", "elevation", "distance"):
        assert stage.js("camera")[name] == pytest.approx(turned[name])
    assert near(stage.colour_at(box["x"] + 20, box["y"] + 20), DARK_VIEW)

    stage.python(lambda view: view.param.update(view="front"))
    stage.page.wait_for_function(
        f"Math.abs(markermendScene.camera.azimuth - {turned['azimuth']}) > 0.01"
    )
    assert stage.js("camera")["azimuth"] == pytest.approx(0.0, abs=0.01), "the figure faces x"


def test_long_take_comes_in_chunks_around_the_cursor(serve: Any, open_page: Any) -> None:
    n_frames, n_markers = 60_000, 20
    positions = np.zeros((n_frames, n_markers, 3))
    positions += 1000 * np.random.default_rng(1).random((n_markers, 3))
    positions[:, 0, 2] = 1000 + np.arange(n_frames) / 100
    views: list[SceneView] = []

    def factory() -> SceneView:
        views.append(SceneView(width=400, height=300, follow=False))
        views[0].show_take(positions, 1000.0, [f"M{i}" for i in range(n_markers)], [(0, 1)])
        return views[0]

    page = open_page(serve(factory))
    page.wait_for_function("window.markermendScene?.ready")
    assert page.evaluate("markermendScene.chunks") == 1
    page.evaluate("dispatchEvent(new CustomEvent('markermend:seek', {detail: {frame: 59999}}))")
    page.wait_for_function("markermendScene.frame === 59999")
    assert page.evaluate("markermendScene.chunks") == 2
    drawn = page.evaluate("markermendScene.owner.picture.xyz[2]")
    assert drawn == pytest.approx(positions[-1, 0, 2], abs=0.01)


def test_without_webgl_a_plain_canvas_shows_the_same(
    serve: Any, open_page: Any, launch: Any, stage: Stage
) -> None:
    plain = Stage(serve, open_page, browser=launch("--disable-3d-apis"))
    assert plain.js("renderer") == "canvas"
    assert "no WebGL" in plain.page.locator(".note").inner_text()
    for one in (plain, stage):
        one.python(lambda view: view.show_focus(focus()))
        one.wait(f"selected === {WRIST}")
        one.seek(150)
        place = one.js(f"markerPixel({WRIST})")
        assert near(one.colour_at(*place), ACCENT)
    assert plain.js(f"markerPixel({WRIST})") == pytest.approx(
        stage.js(f"markerPixel({WRIST})"), abs=0.01
    )


def test_cursor_of_a_figure_moves_in_the_browser_only(serve: Any, open_page: Any) -> None:
    from bokeh.models import Span
    from bokeh.plotting import figure as bokeh_figure

    sent: list[float] = []
    views: list[SceneView] = []

    def factory() -> pn.Column:
        plot = bokeh_figure(width=300, height=150, x_range=(0, 30), y_range=(0, 1))
        cursor = Span(location=0, dimension="height", name="playhead")
        plot.add_layout(cursor)
        cursor.on_change("location", lambda _name, _old, new: sent.append(new))
        views.append(SceneView(width=300, height=300))
        views[0].show_take(figure(), RATE, LABELS, BONES)
        return pn.Column(views[0], plot, Playheads())

    page = open_page(serve(factory))
    page.wait_for_function("window.markermendScene?.ready")
    page.evaluate("dispatchEvent(new CustomEvent('markermend:seek', {detail: {frame: 1234}}))")
    page.wait_for_function("Bokeh.documents[0].get_model_by_name('playhead')?.location === 12.34")
    until(lambda: views[0].frame == 1234)
    assert sent == []
    line, inside = (
        page.evaluate(
            f"""(() => {{
                const view = Bokeh.index.find_one(
                    Bokeh.documents[0].get_model_by_name('playhead'));
                const {{ canvas_view, frame }} = view.plot_view;
                const box = canvas_view.el.getBoundingClientRect();
                const line = canvas_view.overlays_el.querySelector('.playhead');
                const drawn = line.getBoundingClientRect();
                return {what};
            }})()"""
        )
        for what in (
            "drawn.left + drawn.width / 2 - box.left",
            "[frame.bbox.left, frame.bbox.right]",
        )
    )
    assert line == pytest.approx(inside[0] + (inside[1] - inside[0]) * 12.34 / 30, abs=1)


class Keys:
    """A served key listener among fields of a form, some of them in a shadow DOM."""

    def __init__(self, serve: Any, open_page: Any, **listener: Any) -> None:
        self.pressed: list[str] = []

        def factory() -> pn.Column:
            keys = KeyListener(**listener)
            keys.on_key(self.pressed.append)
            return pn.Column(
                keys, pn.widgets.TextInput(label="note"), pn.widgets.Button(label="press")
            )

        self.page = open_page(serve(factory))
        self.page.locator("input").wait_for()
        self.page.wait_for_timeout(200)

    def expect(self, *names: str) -> None:
        until(lambda: len(self.pressed) >= len(names), 5)
        assert self.pressed == list(names)


def test_listed_keys_arrive_and_others_are_left_alone(serve: Any, open_page: Any) -> None:
    keys = Keys(serve, open_page, keys=["a", "?", " ", "Ctrl+z", "Ctrl+Shift+z", "ArrowLeft", "["])
    for key in ("a", "b", "Shift+a", "?", "Space", "Control+z", "Control+Shift+Z", "ArrowLeft"):
        keys.page.keyboard.press(key)
    keys.page.keyboard.press("[")
    keys.expect("a", "?", " ", "Ctrl+z", "Ctrl+Shift+z", "ArrowLeft", "[")


def test_typing_into_a_field_is_no_command_and_escape_leaves_it(serve: Any, open_page: Any) -> None:
    keys = Keys(serve, open_page, keys=["a", "Ctrl+z", "Escape"])
    field = keys.page.locator("input")
    field.click()
    keys.page.keyboard.type("abba")
    keys.page.keyboard.press("Escape")
    keys.page.keyboard.press("a")
    keys.expect("a")
    assert field.input_value() == "abba"
    keys.page.keyboard.press("Escape")
    keys.expect("a", "Escape")


def test_space_is_the_buttons_only_when_it_was_reached_by_keyboard(
    serve: Any, open_page: Any
) -> None:
    keys = Keys(serve, open_page, keys=[" "])
    button = keys.page.get_by_role("button", name="press")
    button.evaluate("b => { window.clicks = 0; b.addEventListener('click', () => clicks++) }")
    button.click()
    keys.page.keyboard.press("Space")
    keys.expect(" ")
    assert keys.page.evaluate("clicks") == 1
    keys.page.locator("input").focus()
    keys.page.keyboard.press("Tab")
    keys.page.keyboard.press("Space")
    keys.page.wait_for_function("clicks === 2")
    keys.expect(" ")


def test_held_keys_repeat_only_where_allowed(serve: Any, open_page: Any) -> None:
    keys = Keys(serve, open_page, keys=["a", "."], repeating=["."])
    for key in ("a", "."):
        for _ in range(3):
            keys.page.keyboard.down(key)
            keys.page.wait_for_timeout(150)
        keys.page.keyboard.up(key)
    keys.expect("a", ".", ".", ".")


def test_local_keys_stay_in_the_browser(serve: Any, open_page: Any) -> None:
    step = {"event": "markermend:step", "detail": {"by": 1}}
    keys = Keys(serve, open_page, keys=["a"], local={".": step})
    keys.page.evaluate(
        "window.steps = []; addEventListener('markermend:step', (e) => steps.push(e.detail))"
    )
    keys.page.keyboard.press(".")
    keys.page.keyboard.press("a")
    keys.expect("a")
    assert keys.page.evaluate("steps") == [{"by": 1}]
