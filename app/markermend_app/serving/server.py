"""One server in one process: Panel's own, with its doors, its gate and its headers."""

import os
import secrets
import socket
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import panel as pn
from bokeh.server.views.metadata_handler import MetadataHandler
from panel.io.application import build_applications
from panel.io.server import (
    AutoloadJsHandler,
    ComponentResourceHandler,
    DocHandler,
    WSHandler,
    get_server,
)
from tornado.web import ErrorHandler

from markermend.errors import BadInput
from markermend.review.store import Store
from markermend_app.serving.doors import Doors
from markermend_app.serving.handlers import (
    Counts,
    Elsewhere,
    Foreign,
    Group,
    Health,
    Page,
    Socket,
)
from markermend_app.serving.headers import Guarded, GuardedByTls
from markermend_app.serving.login import Basic, Bound, Gate, Oauth
from markermend_app.serving.metrics import Metrics
from markermend_app.state.memory import keep_little

UNUSED = (AutoloadJsHandler, MetadataHandler, ComponentResourceHandler)
"""What Panel would serve and no page here asks for: a page for other sites, and any module."""
FORGETS_MS = 5_000
"""How often the server looks for pages that are gone; they are kept for 15 s, to be found again."""
MOST_MESSAGE_BYTES = 2_000_000
"""Of the websocket: a dropped file comes in parts of half that."""
MOST_BODY_BYTES = 64_000
"""Of a request: the form of the login is all that is ever sent."""
METRICS_TOKEN = "MARKERMEND_METRICS_TOKEN"


@dataclass(frozen=True)
class Serving:
    """What one server needs besides its page.

    Attributes
    ----------
    address, port
        Where it listens.
    doors
        How it is reached.
    gate
        Who may come in.
    store
        What `Health` asks for.
    provider
        Name of an OAuth provider, or empty.
    elsewhere
        Which process serves whom.
    secret
        Signs the tokens of sessions.
    metrics
        What is counted.
    """

    address: str
    port: int
    doors: Doors
    gate: Gate
    store: Store
    secret: str
    provider: str = ""
    elsewhere: Elsewhere = lambda _name, _host: None
    metrics: Metrics = field(default_factory=Metrics)


def make(serving: Serving, page: Callable[[], Any], **options: Any) -> Any:
    """Make a server that shows a page; it listens, and answers when its loop runs.

    Parameters
    ----------
    serving
        Doors and gate.
    page
        Makes the page of a visitor.
    options
        Passed on to `panel.io.server.get_server`.
    """
    keep_little()
    pn.extension("vtk", notifications=False)
    # Panel's own places of these would be read from the environment.
    pn.config.cookie_secret = serving.secret
    apps = build_applications({"/": page}, title="MarkerMend")
    apps["/"].add(Bound(serving.gate))
    settings = {
        "doors": serving.doors,
        "gate": serving.gate,
        "store": serving.store,
        "metrics": serving.metrics,
        "metrics_token": os.environ.get(METRICS_TOKEN, ""),
        "elsewhere": serving.elsewhere,
        "secure_cookies": serving.doors.https,
    }
    if serving.provider:
        pn.config.oauth_provider = serving.provider
        options["auth_provider"] = Oauth(serving.gate)
    elif not serving.gate.open:
        options["auth_provider"] = Basic(serving.gate)
    server = get_server(
        apps,
        title="MarkerMend",
        address=serving.address,
        port=serving.port,
        cookie_secret=serving.secret,
        sign_sessions=True,
        secret_key=serving.secret.encode(),
        include_headers=[],
        include_cookies=[],
        xsrf_cookies=True,
        check_unused_sessions_milliseconds=FORGETS_MS,
        transforms=[GuardedByTls if serving.doors.https else Guarded],
        websocket_max_message_size=MOST_MESSAGE_BYTES,
        http_server_kwargs={
            "max_body_size": MOST_BODY_BYTES,
            "max_buffer_size": 2 * MOST_MESSAGE_BYTES,
        },
        extra_patterns=[("/health", Health), ("/metrics", Counts), ("/group", Group)],
        log_function=serving.metrics.log,
        **options,
        **settings,
    )
    _narrow(server._tornado, serving.doors)  # noqa: SLF001  as Panel itself reaches it
    server.io_loop.add_callback(serving.metrics.start)
    return server


def _narrow(app: Any, doors: Doors) -> None:
    """Put our handlers in place of Panel's, and take away those that nobody needs."""
    rules = app.wildcard_router.rules
    for rule in rules:
        if rule.target is DocHandler:
            rule.target = Page
        elif rule.target is WSHandler:
            rule.target = Socket
    rules[:] = [rule for rule in rules if rule.target not in UNUSED]
    app.add_handlers(doors.foreign_host, [(r"(?!/health$).*", Foreign)])
    app.add_handlers(r".*", [(r".*%00.*", ErrorHandler, {"status_code": 404})])


def free_port(address: str, wanted: int | None) -> int:
    """Give the port that was asked for, or one that nobody uses.

    Raises
    ------
    BadInput
        If the port that was asked for is taken, or the address is not this machine's.
    """
    try:
        kind = socket.getaddrinfo(address, wanted or 0, type=socket.SOCK_STREAM)[0]
        with socket.socket(kind[0]) as probe:
            probe.bind(kind[4])
            return int(probe.getsockname()[1])
    except socket.gaierror:
        raise BadInput(f"{address} is no address of this machine; leave --address out.") from None
    except OSError as error:
        if wanted is None:
            raise BadInput(f"{address} cannot be listened on ({error.strerror}).") from None
        raise BadInput(
            f"Port {wanted} is in use; give another with --port, or leave it out."
        ) from None


def new_secret() -> str:
    """Give a secret that nobody guesses."""
    return secrets.token_urlsafe(32)
