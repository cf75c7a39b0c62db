"""Small pieces of HTML; everything that comes from a file or an operator is escaped here."""

from html import escape

from markermend.model import FloatArray, Kind
from markermend_app.keys import in_force

ICONS = {
    "undo": "M5.5 3 2.5 6l3 3M3 6h6a4 4 0 0 1 0 8H7.5",
    "redo": "m10.5 3 3 3-3 3M13 6H7a4 4 0 0 0 0 8h1.500",
    "theme": "M8 2.500a5.500 5.500 0 1 0 0 11zM8 2.500a5.500 5.500 0 0 1 0 11",
    "accepted": "m3 8.500 3 3 6.500-7.500",
    "rejected": "m4 4 8 8m0-8-8 8",
    "deferred": "M8 2.500a5.500 5.500 0 1 0 .01 0M8 5v3.500l2.500 1.500",
    "left": "M6 3H3.500v10H6M10 3h2.500v10H10",
    "back": "M11.500 3.500 5.500 8l6 4.500zM4 3.500v9",
    "on": "m4.500 3.500 6 4.500-6 4.500zM12 3.500v9",
    "play": "m5 3 8 5-8 5z",
    "pause": "M5.500 3v10M10.500 3v10",
    "star": "m8 2 1.8 4 4.2.5-3.1 2.9.8 4.100L8 11.4l-3.700 2.100.8-4.100L2 6.500 6.200 6z",
    "note": "M3 3h10v8H8l-3 2.500V11H3z",
    "open": "M2 4h4l1.500 2H14v7H2z",
    "down": "m4 6 4 4 4-4",
    "right": "m6 4 4 4-4 4",
    "saved": "m3 8.500 3 3 6.500-7.500",
}


def icon(name: str, size: int = 15, filled: bool = False) -> str:
    """Give an icon as SVG in the colour of the text around it."""
    fill = "currentColor" if filled else "none"
    return (
        f'<svg width="{size}" height="{size}" viewBox="0 0 16 16" aria-hidden="true">'
        f'<path d="{ICONS[name]}" fill="{fill}" stroke="currentColor" stroke-width="1.5"/></svg>'
    )


def kbd(action: str) -> str:
    """Give the key of an intention, or nothing where it has none."""
    hint = in_force().hints.get(action, "")
    return f"<kbd>{escape(hint)}</kbd>" if hint else ""


def button(
    action: str,
    label: str,
    *,
    classes: str = "tool",
    arg: str | None = None,
    title: str = "",
    disabled: bool = False,
    pressed: bool | None = None,
    key: bool = True,
    current: bool = False,
) -> str:
    """Give a button that sends an intention; `label` is HTML, everything else is text."""
    attributes = [f'class="{classes}"', f'data-do="{escape(action)}"', 'type="button"']
    if arg is not None:
        attributes.append(f'data-arg="{escape(arg)}"')
    if title:
        attributes.append(f'title="{escape(title)}"')
    if disabled:
        attributes.append("disabled")
    if pressed is not None:
        attributes.append(f'aria-pressed="{str(pressed).lower()}"')
    if current:
        attributes.append('aria-current="true"')
    return f"<button {' '.join(attributes)}>{label}{kbd(action) if key else ''}</button>"


def footer(*buttons: str) -> str:
    """Give the foot of a dialog."""
    return f"<footer>{''.join(buttons)}</footer>"


def closing(label: str) -> str:
    """Give the button that closes a dialog."""
    return button("close", label, classes="deed")


def number(value: float | None) -> str:
    """Write a length in mm with two significant digits below 10, whole above."""
    if value is None:
        return "–"
    if value < 0.05:
        return "<0.1"
    return f"{value:.1f}" if value < 10 else f"{value:.0f}"


def spark(outline: FloatArray, begins: float, ends: float, kind: Kind) -> str:
    """Draw the outline of a finding; `begins` and `ends` are shares of its width."""
    width, height = 100.0, 20.0
    n = max(1, len(outline) - 1)
    pieces, pen = [], False
    for i, value in enumerate(outline):
        if value != value:  # NaN: the pen is lifted over a gap
            pen = False
            continue
        pieces.append(f"{'L' if pen else 'M'}{i / n * width:.1f} {18 - 16 * value:.1f}")
        pen = True
    left, right = begins * width, max(ends * width, begins * width + 3)
    return (
        f'<svg class="shape" viewBox="0 0 {width:g} {height:g}" preserveAspectRatio="none" '
        f'aria-hidden="true"><rect x="{left:.1f}" y="0" width="{right - left:.1f}" '
        f'height="{height:g}" fill="var(--{kind})" opacity=".2"/>'
        f'<path d="{"".join(pieces)}" fill="none" stroke="var(--ink2)" stroke-width="1.2" '
        f'vector-effect="non-scaling-stroke"/></svg>'
    )
