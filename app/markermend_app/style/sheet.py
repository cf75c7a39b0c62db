"""The one stylesheet, for the page and for every part of it."""

from base64 import b64encode
from pathlib import Path

from markermend_app.style.tokens import css_variables

HERE = Path(__file__).parent
STYLESHEET = (HERE / "desk.css").read_text(encoding="utf-8")


def _font(weight: int) -> str:
    """Give one weight of the typeface inside the sheet, so that nothing has to be fetched."""
    data = (HERE / "fonts" / f"roboto-latin-{weight}-normal.woff2").read_bytes()
    source = f'url("data:font/woff2;base64,{b64encode(data).decode()}") format("woff2")'
    return f'@font-face{{font-family:"Roboto";font-weight:{weight};src:{source}}}'


PAGE_STYLESHEET = "\n".join((_font(400), _font(700), css_variables(), STYLESHEET))
