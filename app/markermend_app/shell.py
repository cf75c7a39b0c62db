"""The server: on the loopback, one desk per page."""

import importlib.util
import socket
from collections.abc import Callable

import panel as pn

from markermend.errors import BadInput
from markermend_app.state.desk import Desk
from markermend_app.state.workspace import Workspace
from markermend_app.views.page import build

ADDRESS = "127.0.0.1"


def free_port(wanted: int | None) -> int:
    """Give the port that was asked for, or one that nobody uses.

    Raises
    ------
    BadInput
        If the port that was asked for is taken.
    """
    with socket.socket() as probe:
        try:
            probe.bind((ADDRESS, wanted or 0))
        except OSError:
            raise BadInput(
                f"Port {wanted} is in use; give another with --port, or leave it out."
            ) from None
        return int(probe.getsockname()[1])


def serve(
    workspace: Workspace,
    *,
    port: int | None = None,
    show: bool = True,
    window: bool = False,
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
    ready
        Called with the address before the first page is served.

    Raises
    ------
    BadInput
        If the port is taken, or a window is wanted and pywebview is not installed.
    """
    if window and importlib.util.find_spec("webview") is None:
        raise BadInput("A window of its own needs pywebview: install it, or leave --window out.")
    pn.extension("vtk", notifications=False)
    port = free_port(port)
    ready(f"http://localhost:{port}/")
    server = pn.serve(
        {"/": lambda: page(workspace)},
        title="MarkerMend",
        address=ADDRESS,
        port=port,
        show=show and not window,
        threaded=window,
        websocket_origin=[f"{host}:{port}" for host in ("localhost", ADDRESS)],
        verbose=False,
    )
    if window:
        _show_window(f"http://localhost:{port}/")
        server.stop()


def _show_window(address: str) -> None:
    """Show the page in a native window until it is closed."""
    import webview

    webview.create_window("MarkerMend", address, width=1600, height=1000)
    webview.start()


def page(workspace: Workspace) -> pn.Template:
    """Make the page of a new visitor and open the first take."""
    document = pn.state.curdoc

    def schedule(task: Callable[[], None]) -> None:
        document.add_next_tick_callback(task)

    desk = Desk(workspace, schedule)
    template = build(desk)
    pn.state.on_session_destroyed(lambda _: desk.close())
    if workspace.paths:
        pn.state.onload(lambda: desk.open(workspace.paths[0]))
    return template
