"""Learning curves as SVG inside a page, for a report and for the application."""

from collections.abc import Mapping
from html import escape

from markermend.model import Kind
from markermend.train.learning import WINDOW, Curve

_WIDTH, _HEIGHT, _PAD = 300, 150, 30


def learning_curves(found: Mapping[Kind, Curve]) -> str:
    """Draw one figure per kind: shares found with their intervals, and the line of pooled ones.

    Returns
    -------
    HTML that takes its colours from the variables ``--line``, ``--ink3`` and ``--accent``.
    """
    return "".join(_figure(curve) for curve in found.values())


def _figure(curve: Curve) -> str:
    n = len(curve.points)

    def x(i: float) -> float:
        return _PAD + (i + 0.5) * (_WIDTH - _PAD) / n

    def y(value: float) -> float:
        return 8 + (1.0 - value) * (_HEIGHT - 30)

    marks = [
        f'<line x1="{_PAD}" x2="{_WIDTH}" y1="{y(value):.1f}" y2="{y(value):.1f}" '
        'stroke="var(--line)"/>'
        f'<text x="0" y="{y(value) + 4:.1f}" font-size="10" fill="var(--ink3)">{value:.0%}</text>'
        for value in (0.0, 0.5, 1.0)
    ]
    for i, point in enumerate(curve.points):
        one = point.share
        marks.append(
            f'<line x1="{x(i):.1f}" x2="{x(i):.1f}" y1="{y(one.low):.1f}" y2="{y(one.high):.1f}" '
            'stroke="var(--ink3)"/>'
            f'<circle cx="{x(i):.1f}" cy="{y(one.value or 0.0):.1f}" r="3" fill="var(--accent)"/>'
            f'<text x="{x(i):.1f}" y="{_HEIGHT - 4}" font-size="10" text-anchor="middle" '
            f'fill="var(--ink3)">{point.level or "r"}</text>'
        )
    if curve.line:
        places = " ".join(
            f"{x(i + WINDOW - 1):.1f},{y(one.value or 0.0):.1f}" for i, one in enumerate(curve.line)
        )
        ends = [(x(i + WINDOW - 1), one) for i, one in enumerate(curve.line)]
        band = [f"{at:.1f},{y(one.high):.1f}" for at, one in ends]
        band += [f"{at:.1f},{y(one.low):.1f}" for at, one in reversed(ends)]
        marks.insert(
            0, f'<polygon points="{" ".join(band)}" fill="var(--accent)" fill-opacity="0.12"/>'
        )
        marks.append(
            f'<polyline points="{places}" fill="none" stroke="var(--accent)" stroke-width="1.5"/>'
        )
    title = escape(curve.kind)
    return (
        f'<figure><figcaption>{title}</figcaption><svg width="{_WIDTH}" height="{_HEIGHT}" '
        f'role="img" aria-label="Share of {title} found over time">{"".join(marks)}</svg></figure>'
    )
