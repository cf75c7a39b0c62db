"""The typeface, inside whatever sheet it is used in, so that nothing has to be fetched."""

from base64 import b64encode
from pathlib import Path

_FOLDER = Path(__file__).with_name("fonts")


def font_face(weight: int) -> str:
    """Give one weight of the typeface as a rule of CSS that holds it."""
    data = (_FOLDER / f"roboto-latin-{weight}-normal.woff2").read_bytes()
    source = f'url("data:font/woff2;base64,{b64encode(data).decode()}") format("woff2")'
    return f'@font-face{{font-family:"Roboto";font-weight:{weight};src:{source}}}'
