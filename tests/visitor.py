"""A visitor without a browser: logs in, loads the page, and speaks to it as BokehJS does.

Just enough of Bokeh's protocol to ask for the document, send what buttons send, and follow what the
server changes.
"""

import asyncio
import contextlib
import json
import os
import re
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from html import unescape
from http.cookies import SimpleCookie
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

from tornado.httpclient import AsyncHTTPClient, HTTPRequest, HTTPResponse
from tornado.websocket import WebSocketClientConnection, websocket_connect

STARTS_S = 400.0
ANSWERS_S = 60.0


def free_ports(n: int = 1) -> int:
    """Give a port that nobody uses, with as many more after it."""
    for _ in range(50):
        with contextlib.ExitStack() as held:
            first = held.enter_context(socket.socket())
            first.bind(("127.0.0.1", 0))
            port = int(first.getsockname()[1])
            try:
                for i in range(1, n):
                    held.enter_context(socket.socket()).bind(("127.0.0.1", port + i))
            except (OSError, OverflowError):
                continue
            return port
    raise OSError("no free ports")


class Served:
    """A command that serves, as a process of its own; its log goes to a file.

    Parameters
    ----------
    words
        The command line after ``markermend``.
    log
        Where all that it prints goes.
    env
        Added to the environment.
    """

    def __init__(self, *words: object, log: Path, env: Mapping[str, str] | None = None) -> None:
        self.log = log
        with log.open("wb") as out:
            self.process = subprocess.Popen(
                [sys.executable, "-m", "markermend_app", *map(str, words)],
                stdout=out,
                stderr=subprocess.STDOUT,
                env={**os.environ, **(env or {})},
            )
        self.url = self._address()

    def _address(self) -> str:
        end = time.monotonic() + STARTS_S
        while time.monotonic() < end and self.process.poll() is None:
            if found := re.search(r"MarkerMend .*(http\S+/)", self.said):
                return found[1]
            time.sleep(0.05)
        self.stop()
        raise RuntimeError(f"the server did not start: {self.said}")

    @property
    def said(self) -> str:
        """All that it has printed."""
        return self.log.read_text(encoding="utf-8", errors="replace")

    def stop(self) -> None:
        """Ask it to end, and make it if it does not."""
        self.process.terminate()
        try:
            self.process.wait(20)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()


class Visitor:
    """One browser window.

    Parameters
    ----------
    url
        The server's address.
    """

    def __init__(self, url: str) -> None:
        self.url = url.rstrip("/") + "/"
        self.cookies: dict[str, str] = {}
        self.values: dict[str, dict[str, Any]] = {}
        self.classes: dict[str, list[str]] = {}
        self.socket: WebSocketClientConnection | None = None
        self.told = asyncio.Event()
        self._reader: asyncio.Task[None] | None = None
        self._n = 0

    async def get(self, path: str = "", **given: Any) -> HTTPResponse:
        """Ask for something; every status is an answer."""
        return await self.get_from(self.url + path, **given)

    async def get_from(self, address: str, **given: Any) -> HTTPResponse:
        """Ask for something at an address."""
        headers = {**self._cookie_header(), **given.pop("headers", {})}
        request = HTTPRequest(
            address, headers=headers, follow_redirects=False, request_timeout=120, **given
        )
        answer = await AsyncHTTPClient().fetch(request, raise_error=False)
        for line in answer.headers.get_list("Set-Cookie"):
            for name, morsel in SimpleCookie(line).items():
                self.cookies[name] = morsel.value
                if not morsel.value:
                    del self.cookies[name]
        return answer

    async def log_in(self, name: str, password: str) -> HTTPResponse:
        """Fill in the form."""
        page = (await self.get("login")).body.decode()
        found = re.search(r'name="_xsrf" value="([^"]+)"', page)
        fields = {"username": name, "password": password, "_xsrf": found[1] if found else ""}
        return await self.get("login", method="POST", body=urlencode(fields))

    async def token(self) -> str:
        """Load the page, and give the token of its session."""
        answer = await self.get()
        assert answer.code == 200, (answer.code, answer.headers.get("Location"))
        found = re.search(r'"token":"([^"]+)"', unescape(answer.body.decode()))
        assert found, "the page has no session"
        return found[1]

    async def connect(self, token: str, **headers: str) -> WebSocketClientConnection:
        """Open the websocket of a session, from this server's own page unless told otherwise."""
        given = {"Origin": self.url.rstrip("/"), **self._cookie_header(), **headers}
        address = self.url.replace("http", "ws", 1) + "ws"
        request = HTTPRequest(address, headers={k: v for k, v in given.items() if v})
        return await websocket_connect(
            request, subprotocols=["bokeh", token], max_message_size=500_000_000
        )

    async def open(self) -> None:
        """Load the page and its document, as a browser does."""
        self.socket = await self.connect(await self.token())
        header, _, _ = await self._message()
        assert header["msgtype"] == "ACK", header
        await self._send("PULL-DOC-REQ", {})
        header, content, _ = await self._message()
        assert header["msgtype"] == "PULL-DOC-REPLY", header
        self._learn(content["doc"])
        self._reader = asyncio.get_running_loop().create_task(self._read())
        await self.event("document_ready", {})

    async def event(self, name: str, values: Mapping[str, Any]) -> None:
        """Send what happened in the browser."""
        data = {"type": "event", "name": name, "values": {"type": "map", "entries": [
            [k, v] for k, v in values.items()
        ]}}  # fmt: skip
        change = {"kind": "MessageSent", "msg_type": "bokeh_event", "msg_data": data}
        await self._send("PATCH-DOC", {"events": [change]})

    async def do(self, name: str, arg: Any = None, **fields: Any) -> None:
        """Press a button."""
        await self.message("Part", {"do": name, "arg": arg, "fields": fields})

    async def message(self, component: str, message: Mapping[str, Any]) -> None:
        """Send what a component's script sends."""
        model = self.classes[component][0]
        await self.event("data_event", {"model": {"id": model}, "data": _map(message)})

    async def until(self, said: Callable[[str], Any], timeout_s: float = ANSWERS_S) -> Any:
        """Wait until what is on the page makes `said` true, and give what it gives."""
        end = time.monotonic() + timeout_s
        while True:
            self.told.clear()
            if found := said(self.page):
                return found
            left = end - time.monotonic()
            if left <= 0:
                raise TimeoutError(re.sub(r"<[^>]+>", " ", self.page)[:2000])
            if self._reader is not None and self._reader.done():
                raise ConnectionError("the server closed the websocket")
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(self.told.wait(), min(left, 1.0))

    @property
    def page(self) -> str:
        """The HTML of all parts of the page."""
        return "\n".join(str(v["html"]) for v in self.values.values() if "html" in v)

    @property
    def settled(self) -> tuple[int, int] | None:
        """How many findings are settled, and how many there are."""
        found = re.search(r"<b>(\d+)</b> of (\d+) settled", self.page)
        return (int(found[1]), int(found[2])) if found else None

    async def close(self) -> None:
        """Close the window."""
        if self.socket is not None:
            self.socket.close()
        if self._reader is not None:
            await asyncio.wait([self._reader], timeout=10)

    def _cookie_header(self) -> dict[str, str]:
        pairs = "; ".join(f"{k}={v}" for k, v in self.cookies.items())
        return {"Cookie": pairs} if pairs else {}

    async def _send(self, kind: str, content: Mapping[str, Any]) -> None:
        assert self.socket is not None
        self._n += 1
        header = {"msgid": f"{id(self)}-{self._n}", "msgtype": kind}
        for part in (header, {}, content):
            await self.socket.write_message(json.dumps(part))

    async def _message(self) -> tuple[dict[str, Any], dict[str, Any], list[bytes]]:
        assert self.socket is not None
        header, _, content = [json.loads(await self._fragment()) for _ in range(3)]
        buffers = []
        for _ in range(header.get("num_buffers", 0)):
            await self._fragment()
            buffers.append(await self._fragment())
        return header, content, buffers

    async def _fragment(self) -> Any:
        assert self.socket is not None
        found = await asyncio.wait_for(self.socket.read_message(), 600)
        if found is None:
            raise ConnectionError("the server closed the websocket")
        return found

    async def _read(self) -> None:
        with contextlib.suppress(ConnectionError):
            await self._follow()

    async def _follow(self) -> None:
        while True:
            header, content, _ = await self._message()
            if header["msgtype"] == "PATCH-DOC":
                for change in content["events"]:
                    if change.get("kind") == "ModelChanged":
                        self.values.setdefault(change["model"]["id"], {})[change["attr"]] = change[
                            "new"
                        ]
                    self._learn(change)
                self.told.set()

    def _learn(self, found: Any) -> None:
        """Note every model in what was received: its values, and the class of a component."""
        for one in _objects(found):
            attributes = one.get("attributes") or {}
            self.values.setdefault(one["id"], {}).update(attributes)
            if "class_name" in attributes:
                self.classes.setdefault(str(attributes["class_name"]), []).append(one["id"])


def _objects(found: Any) -> Iterator[dict[str, Any]]:
    if isinstance(found, dict):
        if found.get("type") == "object" and "id" in found:
            yield found
        for value in found.values():
            yield from _objects(value)
    elif isinstance(found, list):
        for value in found:
            yield from _objects(value)


def _map(found: Any) -> Any:
    if isinstance(found, Mapping):
        return {"type": "map", "entries": [[key, _map(value)] for key, value in found.items()]}
    return [_map(value) for value in found] if isinstance(found, list | tuple) else found
