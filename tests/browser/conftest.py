"""A real browser, headless, that may talk to the loopback only."""

import os
import shutil
import socket
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import panel as pn
import pytest
from playwright.sync_api import Browser, Page, Playwright, sync_playwright

NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")
FLAGS = [
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    # As browsers do by themselves without a graphics card: only what changed is put together anew.
    "--disable-gpu-compositing",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
    "--force-color-profile=srgb",
]
LOOPBACK = {"127.0.0.1", "localhost", "::1", None}
TIMEOUT_MS = 60_000


def find_chromium(playwright: Playwright) -> str | None:
    """Find a Chromium: named by MARKERMEND_CHROMIUM, on PATH, or Playwright's own."""
    named = os.environ.get("MARKERMEND_CHROMIUM")
    own = playwright.chromium.executable_path
    found = [named, *(shutil.which(name) for name in NAMES), own]
    return next((path for path in found if path and Path(path).exists()), None)


@pytest.fixture(scope="session")
def launch() -> Iterator[Callable[..., Browser]]:
    """Give a function that starts a browser with further flags."""
    with sync_playwright() as playwright:
        path = find_chromium(playwright)
        if path is None:
            reason = (
                "there is no Chromium; install one, or name it in MARKERMEND_CHROMIUM "
                "(make browser gets one)"
            )
            (pytest.fail if os.environ.get("CI") else pytest.skip)(reason)
        as_root = ["--no-sandbox"] if getattr(os, "geteuid", lambda: 1)() == 0 else []
        started: list[Browser] = []

        def start(*flags: str) -> Browser:
            started.append(
                playwright.chromium.launch(executable_path=path, args=[*FLAGS, *as_root, *flags])
            )
            return started[-1]

        yield start
        for browser in started:
            browser.close()


@pytest.fixture(scope="session")
def browser(launch: Callable[..., Browser]) -> Browser:
    """Give the browser that tests share."""
    return launch()


@pytest.fixture
def open_page(browser: Browser) -> Iterator[Callable[..., Page]]:
    """Give a function that opens an address in a page of its own.

    Requests beyond the loopback are stopped; they, and errors on a page, fail the test at its end.
    """
    pages: list[Page] = []
    outside: list[str] = []
    errors: list[str] = []

    def guard(route: Any) -> None:
        address = urlsplit(route.request.url)
        if address.hostname in LOOPBACK:
            route.continue_()
        else:
            outside.append(route.request.url)
            route.abort()

    def new(url: str, *, browser: Browser = browser, **context: Any) -> Page:
        page = browser.new_page(**{"viewport": {"width": 1600, "height": 1000}} | context)
        page.set_default_timeout(TIMEOUT_MS)
        page.route("**/*", guard)
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.on(
            "console",
            lambda message: errors.append(message.text) if message.type == "error" else None,
        )
        page.goto(url)
        pages.append(page)
        return page

    yield new
    for page in pages:
        page.close()
    assert outside == [], "requests left the loopback"
    assert errors == [], "errors in the browser's console"


@pytest.fixture
def serve() -> Iterator[Callable[[Callable[[], Any]], str]]:
    """Give a function that serves what a factory makes for every session, and tells where."""
    servers: list[Any] = []

    def start(factory: Callable[[], Any]) -> str:
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        servers.append(
            pn.serve(
                factory, port=port, address="127.0.0.1", threaded=True, show=False, verbose=False
            )
        )
        url = f"http://127.0.0.1:{port}"
        _wait_for(port)
        return url

    yield start
    for server in servers:
        server.stop()


def _wait_for(port: int) -> None:
    end = time.monotonic() + TIMEOUT_MS / 1000
    while time.monotonic() < end:
        with socket.socket() as probe:
            if probe.connect_ex(("127.0.0.1", port)) == 0:
                return
        time.sleep(0.02)
    raise TimeoutError(f"nothing answers on port {port}")
