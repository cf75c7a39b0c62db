"""The server of one person: on the loopback, one desk per page."""

import importlib.util
import threading
from collections.abc import Callable
from typing import Any

from markermend.errors import BadInput
from markermend_app.serving.doors import loopback_doors
from markermend_app.serving.login import Gate
from markermend_app.serving.server import Serving, free_port, make, new_secret
from markermend_app.serving.session import Begin, visit
from markermend_app.state.workspace import Workspace

ADDRESS = "127.0.0.1"


def serve(
    workspace: Workspace,
    *,
    port: int | None = None,
    show: bool = True,
    window: bool = False,
    begin: Begin | None = None,
    ready: Callable[[str], None] = lambda _: None,
) -> None:
    """Serve the application until it is interrupted.

    Parameters
    ----------
    workspace
        Takes and store.
    port
        Where; by default any that is free.
    show
        Whether to open the browser.
    window
        Whether to open a window of its own instead, where pywebview is installed; closing it ends
        the server.
    begin
        Called with the desk of each page that is loaded; by default the first take is opened.
    ready
        Called with the address before the first page is served.

    Raises
    ------
    BadInput
        If the port is taken, or a window is wanted and pywebview is not installed.
    """
    if window and importlib.util.find_spec("webview") is None:
        raise BadInput("A window of its own needs pywebview: install it, or leave --window out.")
    port = free_port(ADDRESS, port)
    address = f"http://localhost:{port}/"
    secret = new_secret()
    serving = Serving(
        ADDRESS, port, loopback_doors(port), Gate(None, secret), workspace.store, secret
    )

    def start(**options: Any) -> Any:
        server = make(serving, lambda: visit(workspace, None, serving.metrics, begin), **options)
        server.start()
        ready(address)
        return server

    if window:
        _in_a_window(start, address)
        return
    server = start(show=show)
    server.io_loop.start()


def _in_a_window(start: Callable[[], Any], address: str) -> None:
    """Show the page in a native window until it is closed; the server has a thread of its own."""
    import asyncio

    import webview

    loops: list[Any] = []
    up = threading.Event()

    def run() -> None:
        asyncio.set_event_loop(asyncio.new_event_loop())
        server = start()
        loops.append(server.io_loop)
        up.set()
        server.io_loop.start()

    threading.Thread(target=run, daemon=True).start()
    up.wait()
    webview.create_window("MarkerMend", address, width=1600, height=1000)
    webview.start()
    loops[0].add_callback(loops[0].stop)
