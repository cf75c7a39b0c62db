"""Colours of the two themes; the kinds' own are in `kinds`."""

from markermend_app.style.kinds import KIND_STYLES

TOKENS: dict[str, dict[str, str]] = {
    "light": {
        "bg": "#EEF0F3",
        "panel": "#FFFFFF",
        "sunk": "#F6F7F9",
        "hover": "#F0F3F8",
        "view": "#F3F5F8",
        "line": "#E2E5EA",
        "line2": "#C6CCD5",
        "ink": "#1A1D21",
        "ink2": "#4F5762",
        "ink3": "#626B78",
        "accent": "#1F5FE0",
        "on-accent": "#FFFFFF",
        "soft": "#EAF0FC",
        "band": "#DBE6FA",
        "warn": "#8A5A00",
        "warn-ground": "#FFF6E0",
        "scrim": "rgba(26,29,33,.35)",
    },
    "dark": {
        "bg": "#0C0E11",
        "panel": "#14171C",
        "sunk": "#101317",
        "hover": "#1B2027",
        "view": "#101318",
        "line": "#252A32",
        "line2": "#3B434F",
        "ink": "#E6E9EE",
        "ink2": "#A9B1BD",
        "ink3": "#8A93A1",
        "accent": "#7AA7FF",
        "on-accent": "#0A1224",
        "soft": "#212A39",
        "band": "#283449",
        "warn": "#F0C36A",
        "warn-ground": "#2A2415",
        "scrim": "rgba(0,0,0,.55)",
    },
}
for _theme, _tokens in TOKENS.items():
    for _kind, _style in KIND_STYLES.items():
        _tokens[_kind] = _style.colour(_theme)
        _tokens[f"on-{_kind}"] = _style.on_dark if _theme == "dark" else _style.on_light


def css_variables() -> str:
    """Give both themes as CSS custom properties."""
    return "\n".join(
        f'[data-theme="{theme}"]{{color-scheme:{theme};{theme_variables(theme)}}}'
        for theme in TOKENS
    )


def theme_variables(theme: str) -> str:
    """Give one theme as CSS custom properties, without a rule around them."""
    return "".join(f"--{name}:{value};" for name, value in TOKENS[theme].items())
