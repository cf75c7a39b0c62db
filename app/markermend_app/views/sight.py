"""Small pictures of one finding in several versions, and their legend."""

import numpy as np

from markermend.model import FloatArray
from markermend_app.state.sights import Sight
from markermend_app.views.markup import number

WIDTH, HEIGHT, TOP = 260.0, 76.0, 5.0
STROKES = {
    "recorded": 'stroke-width="1.4"',  # in the colour of its kind
    "truth": 'stroke="var(--ink)" stroke-width="1.2"',
    "best": 'stroke="var(--ink3)" stroke-width="1.1" stroke-dasharray="5 4"',
    "yours": 'stroke="var(--accent)" stroke-width="2.2"',
}
WORDS = {
    "recorded": "As recorded",
    "truth": "What it really did",
    "best": "Best method",
    "yours": "Your repair",
}


def picture(seen: Sight, label: str) -> str:
    """Draw the versions; the span is tinted in the colour of its kind."""
    values = np.concatenate([line[np.isfinite(line)] for line in seen.lines.values()])
    low, high = (float(values.min()), float(values.max())) if values.size else (0.0, 0.0)
    room = max(high - low, 1e-6)
    first, last = float(seen.time[0]), float(seen.time[-1])
    length = max(last - first, 1e-9)

    def x(time: float) -> float:
        return (time - first) / length * WIDTH

    def y(value: float) -> float:
        return TOP + (high - value) / room * (HEIGHT - 2 * TOP)

    left, right = x(seen.start_s), max(x(seen.stop_s), x(seen.start_s) + 3)
    paths = "".join(
        f'<path d="{_path(seen.time, line, x, y)}" fill="none" {_stroke(name, seen)} '
        'stroke-linejoin="round" vector-effect="non-scaling-stroke"/>'
        for name, line in seen.lines.items()
    )
    return (
        f'<figure class="sight"><svg viewBox="0 0 {WIDTH:g} {HEIGHT:g}" '
        f'preserveAspectRatio="none" role="img" aria-label="{label}">'
        f'<rect x="{left:.1f}" y="0" width="{right - left:.1f}" height="{HEIGHT:g}" '
        f'fill="var(--{seen.kind})" opacity=".16"/>{paths}</svg>'
        f'<figcaption class="num">{seen.axis.upper()}, {number(room)} {seen.unit} from top to '
        f"bottom, {first:.2f}–{last:.2f} s</figcaption></figure>"
    )


def _stroke(name: str, seen: Sight) -> str:
    colour = f'stroke="var(--{seen.kind})" ' if name == "recorded" else ""
    return colour + STROKES[name]


def _path(time: FloatArray, line: FloatArray, x, y) -> str:  # type: ignore[no-untyped-def]
    """Lift the pen over gaps; a sample that stands alone is a dash."""
    pieces, pen = [], False
    for at, value in zip(time, line, strict=True):
        if not np.isfinite(value):
            pen = False
            continue
        pieces.append(f"{'L' if pen else 'M'}{x(at):.1f} {y(value):.1f}")
        if not pen:
            pieces.append("h.5")
        pen = True
    return "".join(pieces)


def legend(*names: str) -> str:
    """Name the lines."""
    grey = 'stroke="var(--ink2)" '  # as recorded is drawn in many colours, one for each kind
    entries = "".join(
        '<span><svg width="26" height="8" viewBox="0 0 26 8" aria-hidden="true">'
        f'<path d="M1 4h24" fill="none" {grey if name == "recorded" else ""}{STROKES[name]}/></svg>'
        f"{WORDS[name]}</span>"
        for name in names
    )
    return f'<div class="sight-legend">{entries}</div>'
