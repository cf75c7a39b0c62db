"""Playback: scrub, step, play, loop, speed."""

from markermend_app.state.desk import VIEWS, Desk
from markermend_app.views.markup import button, icon

SHOWS = ("opened", "selected", "playing", "looping", "speed", "review")
VIEW_SHOWS = ("view", "following", "opened", "bones")
SPEEDS = (0.1, 0.25, 0.5, 1.0, 2.0, 4.0)


def render(desk: Desk) -> str:
    """Give the scrubber over the loop, and its buttons."""
    if desk.opened is None:
        return '<div class="transport"></div>'
    take, loop, span = desk.opened.take, desk.loop, desk.span
    first = loop.start if loop else 0
    last = (loop.stop if loop else take.n_frames) - 1
    width = max(1, last - first)
    mark = ""
    if span is not None and desk.current is not None:
        kind = desk.judged(desk.current).kind
        left = 100 * (span.start - first) / width
        mark = (
            f'<span class="mark" style="left:{left:.2f}%;width:{100 * len(span) / width:.2f}%;'
            f'background:var(--{kind})"></span>'
        )
    speeds = "".join(
        f'<option value="{s}"{" selected" if s == desk.speed else ""}>{s:g} ×</option>'
        for s in SPEEDS
    )
    number = desk.frame + take.first_frame
    return (
        f'<div class="transport"><div class="scrub">{mark}<input type="range" '
        f'aria-label="Frame" min="{first}" max="{last}" step="1" value="{desk.frame}"></div>'
        '<div class="buttons">'
        + button("frame_back", icon("back"), title="One frame back")
        + button(
            "play",
            icon("pause" if desk.playing else "play", filled=not desk.playing),
            classes="tool play",
            title="Play or pause",
        )
        + button("frame_on", icon("on"), title="One frame on")
        + button("loop", "Loop ± 1 s", classes="tool on" if desk.looping else "tool",
                 pressed=desk.looping)
        + f'<select data-do="speed" aria-label="Speed">{speeds}</select>'
        f'<span class="push num"><b data-time>{desk.frame / take.rate:.2f} s</b> '
        f'<span class="small-out" data-frame>frame {number}</span></span></div></div>'
    )  # fmt: skip


def views(desk: Desk) -> str:
    """Give the switches over the 3D view."""
    presets = "".join(
        button("view", view.title(), arg=view, classes="", pressed=view == desk.view, key=False)
        for view in VIEWS
    )
    follow = button("follow", "Follow", classes="", pressed=desk.following, key=False)
    bones = ""
    if desk.opened is not None and desk.opened.skeleton is not None:
        name, _ = desk.opened.skeleton
        bones = button(
            "bones", "Bones", classes="", pressed=desk.bones == "template", key=False,
            title=f"Bones of {name}, by the labels; else those that keep their distance",
        )  # fmt: skip
        bones = f'<div class="choice">{bones}</div>'
    return (
        '<div style="display:flex;gap:6px">'
        f'<div class="choice" role="group" aria-label="View" title="Next view: V">{presets}</div>'
        f'<div class="choice" title="Follow the subject: W">{follow}</div>{bones}</div>'
    )
