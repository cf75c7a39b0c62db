"""What answers: the page, its websocket, and what a lab's own watch asks for."""

import asyncio
import hmac
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from panel.io.server import DocHandler, WSHandler
from sqlalchemy import text
from tornado.ioloop import IOLoop
from tornado.web import HTTPError, RequestHandler

from markermend.errors import StoreError
from markermend.review.store import Store
from markermend.train import archive, group_table
from markermend_app.serving.doors import Doors
from markermend_app.serving.login import Careful, Gate
from markermend_app.serving.metrics import Metrics

OURS_ALONE = ("bokeh-token", "bokeh-session-id")
"""Arguments with which a visitor would choose the session; this server gives out sessions."""
GROUP = Path(__file__).with_name("group.html")
STORE_ANSWERS_WITHIN_S = 5.0
Elsewhere = Callable[[str, str], str | None]
"""Name of a person and of the host as it was asked for -> address of the process that serves that
person; None if it is this one."""


class Page(Careful, DocHandler):  # type: ignore[misc]
    """The desk of one visitor."""

    async def prepare(self) -> None:
        """Refuse what is no plain visit, and send people to the process that is theirs."""
        await super().prepare()
        if any(self.get_arguments(name) for name in OURS_ALONE) or (
            "Bokeh-Session-Id" in self.request.headers
        ):
            raise HTTPError(403, reason="Sessions are given out by this server")
        gate: Gate = self.settings["gate"]
        if gate.open:
            return
        name, person = gate.proven(self.request), gate.person(self.request)
        if name is not None and person is None:
            self.set_status(403)
            self.show(
                said=f"{name} may not come in here; ask whoever keeps the list of people.",
                way="./logout",
                words="Log out",
            )
            return
        elsewhere: Elsewhere = self.settings["elsewhere"]
        if person is not None and (address := elsewhere(person.name, self.request.host_name)):
            self.redirect(address)


class Socket(WSHandler):  # type: ignore[misc]
    """The websocket of a page; from a page of another server, none is opened."""

    async def prepare(self) -> None:
        """Refuse before the handshake; Tornado alone would look at the host and not the scheme."""
        origin = self.request.headers.get("Origin")
        if origin is not None and not self.check_origin(origin):
            self.set_status(403)
            self.finish("This page is not the server's own.\n")
            return
        await super().prepare()

    def check_origin(self, origin: str) -> bool:
        """Say whether the page is this server's own."""
        doors: Doors = self.settings["doors"]
        return doors.admits(origin)


class Foreign(RequestHandler):
    """Answers whoever came under a name that is not this server's."""

    def prepare(self) -> None:
        """Refuse."""
        self.set_status(421)
        self.set_header("Content-Type", "text/plain; charset=utf-8")
        self.finish("This server is not known by that name; start it with --origin.\n")


class Health(RequestHandler):
    """Says whether the server is there and reaches its store; needs no login, tells nothing."""

    async def get(self) -> None:
        """Answer 200 or 503, as JSON."""
        reached = await _reached(self.settings["store"])
        self.set_status(200 if reached else 503)
        self.set_header("Content-Type", "application/json")
        words = {
            "status": "ok" if reached else "failing",
            "store": "reachable" if reached else "unreachable",
        }
        self.finish(json.dumps(words) + "\n")


async def _reached(store: Store) -> bool:
    def ask() -> bool:
        try:
            return bool(store.rows(text("SELECT 1")))  # type: ignore[arg-type]
        except StoreError:
            return False

    try:
        return await asyncio.wait_for(
            IOLoop.current().run_in_executor(None, ask), STORE_ANSWERS_WITHIN_S
        )
    except TimeoutError:
        return False


class Group(Careful):
    """How the trainees of a group stand, for their teacher."""

    async def get(self) -> None:
        """Show the table."""
        gate: Gate = self.settings["gate"]
        person = gate.person(self.request)
        if not gate.open and person is None:
            self.redirect("./login")
            return
        if person is not None and not person.may("groups"):
            self.set_status(403)
            self.show(said=f"This is for teachers, and {person.name} is {person.role} here.")
            return
        store: Store = self.settings["store"]
        found = await IOLoop.current().run_in_executor(None, archive.results, store, None)
        self.render(str(GROUP), table=group_table(found))


class Counts(RequestHandler):
    """What Prometheus reads: for people who are logged in, and for whoever has the token."""

    def get(self) -> None:
        """Write all figures."""
        gate: Gate = self.settings["gate"]
        if not gate.open and gate.person(self.request) is None and not self._has_token():
            self.set_header("WWW-Authenticate", "Bearer")
            raise HTTPError(401)
        metrics: Metrics = self.settings["metrics"]
        self.set_header("Content-Type", metrics.content_type)
        self.finish(metrics.text())

    def _has_token(self) -> bool:
        token: str = self.settings["metrics_token"]
        given: Any = self.request.headers.get("Authorization", "")
        return bool(token) and hmac.compare_digest(given.encode(), f"Bearer {token}".encode())
