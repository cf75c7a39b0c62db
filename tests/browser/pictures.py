"""Take the pictures of the README anew: ``python -m tests.browser.pictures``."""

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image
from playwright.sync_api import Browser, sync_playwright
from tests.browser.conftest import FLAGS, find_chromium
from tests.browser.desk_page import DeskPage, Server, until

import markermend as mm
from markermend.assets import demonstration
from markermend.review import Accept, Reclassify, Reject
from markermend.review.session import ReviewSession
from markermend.review.store import Store
from markermend.train import make_exercise

PICTURES = Path(__file__).resolve().parents[2] / "assets" / "pictures"


def main() -> int:
    """Photograph the desk with the demonstration take, light and dark."""
    with TemporaryDirectory() as folder, sync_playwright() as playwright:
        path = find_chromium(playwright)
        browser = playwright.chromium.launch(executable_path=path, args=[*FLAGS, "--no-sandbox"])
        server = Server(demonstration(), store=Path(folder) / "store.sqlite")
        for theme in ("light", "dark"):
            page = browser.new_page(viewport={"width": 1600, "height": 1000}, color_scheme=theme)
            page.goto(server.url)
            desk = DeskPage(page)
            row = page.locator('.row:has-text("LWRA")').first
            row.click()
            until(lambda row=row: row.get_attribute("aria-selected") == "true")
            desk.settled()
            until(lambda page=page: page.locator(".repair .refused:text-is('…')").count() == 0, 60)
            page.wait_for_timeout(1500)
            page.screenshot(path=PICTURES / f"desk-{theme}.png")
        server.kill()
        _exercise(browser, Path(folder))
        _adjudication(browser, Path(folder))
        browser.close()
    return 0


def _exercise(browser: Browser, folder: Path) -> None:
    """Photograph the end of an exercise that was stopped halfway."""
    given = ("--level", "3", "--seed", "5", "--trainee", "Jo")
    server = Server(*given, store=folder / "exercise.sqlite", command="train")
    page = browser.new_page(viewport={"width": 1440, "height": 900})
    page.goto(server.url)
    page.wait_for_selector(".row", timeout=240_000)
    desk = DeskPage(page)
    for key in ("a", "a", "f", "a"):
        before = desk.selected
        desk.press(key)
        until(lambda before=before: before in desk.rows(settled=True), 60)
        desk.settled()
    desk.press("Control+Enter")
    page.click('.dialog [data-do="finish"]')
    page.wait_for_selector(".sheet", timeout=240_000)
    page.wait_for_timeout(500)
    page.screenshot(path=folder / "exercise.png")
    _keep(folder / "exercise.png")
    server.kill()


def _adjudication(browser: Browser, folder: Path) -> None:
    """Photograph two reviews side by side."""
    path, store = folder / "walk.c3d", folder / "reviews.sqlite"
    mm.write(make_exercise(None, 6, 8).take, path)
    take = mm.read(path)
    findings = mm.detect(take)
    with Store(store) as reviews:
        anna, ben = (ReviewSession.open(reviews, take, name) for name in ("Anna", "Ben"))
        for i, finding in enumerate(findings):
            if i % 2:
                anna.do(Reclassify((finding,), "slow" if finding.kind == "step" else "step"))
            anna.do(Accept((finding,), "linear" if i % 2 else "rigid"))
            ben.do(Reject((finding,)) if i == 2 else Accept((finding,), "rigid"))
    server = Server(path, "--operator", "Clara", store=store)
    page = browser.new_page(viewport={"width": 1440, "height": 900})
    page.goto(server.url)
    desk = DeskPage(page)
    desk.press("p")
    page.fill(".dialog input[name=words]", "compare reviews")
    page.keyboard.press("Enter")
    page.wait_for_selector("[data-do=adjudicate]", timeout=60_000)
    page.wait_for_timeout(500)
    page.screenshot(path=folder / "agreement.png")
    _keep(folder / "agreement.png")
    page.click("[data-do=adjudicate]")
    page.wait_for_selector(".opinion .sight", timeout=60_000)
    desk.settled()
    page.wait_for_timeout(1500)
    page.screenshot(path=folder / "adjudication.png")
    _keep(folder / "adjudication.png")
    server.kill()


def _keep(taken: Path) -> None:
    """Put a picture beside the others, with as many colours as it takes to look the same."""
    # What is rare is kept: the kinds are told apart by a few pixels of colour.
    rare = Image.Quantize.MAXCOVERAGE
    picture = Image.open(taken).convert("RGB").quantize(256, method=rare, dither=Image.Dither.NONE)
    picture.save(PICTURES / f"{taken.stem}-light.png", optimize=True)


if __name__ == "__main__":
    sys.exit(main())
