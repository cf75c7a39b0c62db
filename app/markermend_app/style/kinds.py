"""The one table of kinds: title, key, symbol and colours of each."""

from dataclasses import dataclass

from markermend.model import Kind


@dataclass(frozen=True)
class KindStyle:
    """How one kind of finding is shown.

    ``path`` is an SVG path in a box of 14 × 12 that is shaped like the signal, so that kinds are
    told apart without colour; ``on_light`` and ``on_dark`` are the ink on the kind's colour.
    """

    kind: Kind
    title: str
    key: str
    path: str
    light: str
    dark: str
    on_light: str
    on_dark: str = "#0B0D10"

    def colour(self, theme: str) -> str:
        """Colour in the theme ``"light"`` or ``"dark"``."""
        return self.dark if theme == "dark" else self.light


KIND_STYLES: dict[Kind, KindStyle] = {
    style.kind: style
    for style in (
        KindStyle(
            "gap", "Gap", "1", "M.5 7.5h4.5M9 7.5h4.5M5 4v7M9 4v7", "#9A0088", "#C2519F", "#FFFFFF"
        ),
        KindStyle("peak", "Peak", "2", "M.5 10.5h4L7 1l2.5 9.5h4", "#B93004", "#F2542D", "#FFFFFF"),
        KindStyle(
            "noise",
            "Noise",
            "3",
            "M.5 6.5 2 3.5 4 10 6 1.5 8 11l2-7.500L11.700 8l1.800-2",
            "#A77F19",
            "#D9A62E",
            "#14171C",
        ),
        KindStyle("step", "Step", "4", "M.5 10.5H4V2h6v8.5h3.5", "#38988D", "#4FE0B5", "#14171C"),
        KindStyle(
            "slow",
            "Slow",
            "5",
            "M.5 10.500C4.500 10.500 4.500 2 7 2s2.500 8.500 6.500 8.500",
            "#674D83",
            "#9066DB",
            "#FFFFFF",
        ),
    )
}


def glyph(kind: Kind, size: int = 14) -> str:
    """Give the symbol of a kind as SVG, named for screen readers."""
    style = KIND_STYLES[kind]
    return (
        f'<svg class="glyph" width="{size}" height="{size * 12 // 14}" viewBox="0 0 14 12" '
        f'role="img" aria-label="{style.title}"><path d="{style.path}" fill="none" '
        f'stroke="var(--{kind})" stroke-width="1.7" stroke-linejoin="round"/></svg>'
    )
