"""The overview of an archive as one HTML file that needs nothing else and asks nobody."""

from html import escape
from pathlib import Path

from markermend.batch.overview import Overview
from markermend_app.plots import archive
from markermend_app.style import tokens
from markermend_app.style.typeface import font_face

_POLICY = "default-src 'none'; style-src 'unsafe-inline'; font-src data:"


def archive_body(seen: Overview, door: archive.Door) -> str:
    """Give the sections of an overview, the same in the application and in the file."""
    work = _section("Takes, worst first", "by expected damage", archive.takes(seen, door))
    what = _section("Kinds", "damage is size × duration × confidence, mm s", archive.kinds(seen))
    where = _section("Markers that fail most", "damage by kind, mm s", archive.markers(seen))
    drawn = _section("Markers by takes", "which one, and since when", archive.picture(seen, door))
    left = archive.not_done(seen)
    return (
        f'<div class="archive-grid"><div>{work}</div><div>{what}{where}</div>'
        f'<div class="whole">{drawn}{_section("Not done", "and why", left) if left else ""}</div>'
        "</div>"
    )


def _section(title: str, explained: str, content: str) -> str:
    return f"<section><h2>{title}<span>{explained}</span></h2>{content}</section>"


def archive_page(seen: Overview) -> str:
    """Give the page; it follows the reader's system in light and dark, and runs no script."""
    name = escape(seen.folder.name or str(seen.folder))
    css = "\n".join(
        (
            font_face(400),
            font_face(700),
            f":root{{color-scheme:light dark;{tokens.theme_variables('light')}}}",
            f"@media (prefers-color-scheme:dark){{:root{{{tokens.theme_variables('dark')}}}}}",
            _sheet("archive_page.css"),
            _sheet("archive.css"),
        )
    )
    at = f"{seen.begun.astimezone():%Y-%m-%d %H:%M}"
    return (
        '<!doctype html><html lang="en"><head><meta charset="utf-8">'
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">'
        '<meta name="viewport" content="width=device-width">'
        f"<title>{name} – MarkerMend</title><style>{css}</style></head><body><main>"
        f"<header><h1>{name}</h1><p class='quiet'>{escape(str(seen.folder))} · looked at {at} · "
        f"detector {escape(str(seen.settings['detector']))}</p>{archive.facts(seen)}</header>"
        f"{archive_body(seen, _no_door)}</main></body></html>\n"
    )


def _sheet(name: str) -> str:
    return (Path(tokens.__file__).with_name(name)).read_text(encoding="utf-8")


def _no_door(_take: str, html: str) -> str:
    return html
