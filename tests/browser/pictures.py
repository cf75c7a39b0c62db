"""Take the pictures of the README anew: ``python -m tests.browser.pictures``."""

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from playwright.sync_api import sync_playwright
from tests.browser.conftest import FLAGS, find_chromium
from tests.browser.desk_page import DeskPage, Server, until

from markermend.assets import demonstration

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
        browser.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
