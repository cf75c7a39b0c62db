"""Files with pictures of experiments, opened in a browser that has no network to ask."""

from collections.abc import Callable
from pathlib import Path

from playwright.sync_api import Page

from markermend import io
from markermend.body import infer
from markermend_app.plots.mesh import body_mesh
from markermend_app.plots.picture import html

DEMO = Path(__file__).resolve().parents[2] / "assets" / "takes" / "demo.c3d"


def test_a_picture_draws_itself_from_its_file_alone(
    tmp_path: Path, open_page: Callable[..., Page]
) -> None:
    take = io.read(DEMO)
    body = infer(take)
    picture = body_mesh(take, body, "demo.c3d")
    path = tmp_path / "mesh.html"
    path.write_text(html(picture), encoding="utf-8")
    # What the file's own policy forbids would be an error on the console, and fail here.
    page = open_page(path.as_uri())
    figures = page.locator(".bk-Figure")
    figures.nth(len(picture.panels) - 1).wait_for()
    assert figures.count() == len(picture.panels)
    assert page.title() == picture.title
    fonts = page.evaluate("[...document.fonts].map((font) => font.status)")
    assert fonts == ["loaded", "loaded"]
    for figure in figures.all():
        box = figure.bounding_box()
        assert box is not None
        assert min(box["width"], box["height"]) > 150
