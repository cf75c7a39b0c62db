"""The one stylesheet, for the page and for every part of it."""

from pathlib import Path

from markermend_app.style.tokens import css_variables

STYLESHEET = Path(__file__).with_name("desk.css").read_text(encoding="utf-8")
PAGE_STYLESHEET = f"{css_variables()}\n{STYLESHEET}"
