"""The one stylesheet, for the page and for every part of it."""

from pathlib import Path

from markermend_app.style.tokens import css_variables
from markermend_app.style.typeface import font_face

HERE = Path(__file__).parent
SHEETS = ("desk.css", "training.css", "archive.css")
STYLESHEET = "".join((HERE / name).read_text(encoding="utf-8") for name in SHEETS)

PAGE_STYLESHEET = "\n".join((font_face(400), font_face(700), css_variables(), STYLESHEET))
