"""A lab's server as a process of its own, tried from outside: who and what gets in."""

import asyncio
import json
import os
import re
import socket
import time
from base64 import b64encode
from collections.abc import Callable, Coroutine, Iterator
from pathlib import Path
from typing import Any

import psutil
import pytest
from tests.visitor import Served, Visitor, free_ports
from tornado.httpclient import HTTPClientError

import markermend as mm
from markermend.review.store import Store
from markermend_app.serving.accounts import hashed

from .conftest import made_take

PASSWORD = "correct horse battery"
TOKEN = "a-token-for-prometheus"
PEOPLE = {"anna": "reviewer", "bert": "operator", "carla": "teacher"}
GUARD = """
import os, socket

def _is_outside(address):
    host = address[0] if isinstance(address, tuple) else None
    return host not in (None, "", "localhost", "127.0.0.1", "::1", "0.0.0.0", "::")

def _note(what):
    with open(os.environ["OUTSIDE"], "a") as file:
        file.write(f"{what}\\n")
    raise OSError(f"the tests let nothing out: {what}")

class Guarded(socket.socket):
    def connect(self, address):
        return _note(address) if _is_outside(address) else super().connect(address)

    def connect_ex(self, address):
        return _note(address) if _is_outside(address) else super().connect_ex(address)

socket.socket = Guarded
_look_up = socket.getaddrinfo
socket.getaddrinfo = lambda host, *a, **k: (
    _note(host) if _is_outside((host or "",)) else _look_up(host, *a, **k)
)
"""
"""Put before a server's own modules: whatever it wants from outside is refused and written down."""


class Lab:
    """A served archive, with what lies beside it."""

    def __init__(self, folder: Path, *words: object) -> None:
        self.folder, self.store = folder / "archive", folder / "store.sqlite"
        self.outside, self.people = folder / "outside.txt", folder / "people.json"
        self.folder.mkdir(parents=True)
        take = made_take()
        mm.write(take, self.folder / "small.c3d")
        mm.write(take, folder / "secret.c3d")
        if os.name == "posix":
            (self.folder / "link.c3d").symlink_to(folder / "secret.c3d")
        entries = {n: {"password": hashed(PASSWORD), "role": r} for n, r in PEOPLE.items()}
        self.people.write_text(json.dumps(entries))
        (folder / "guard").mkdir()
        (folder / "guard" / "sitecustomize.py").write_text(GUARD)
        port = free_ports(2)
        self.served = Served(
            "serve", self.folder, "--store", self.store, "--port", port,
            "--login", f"basic:{self.people}", "--max-upload", "1", *words,
            log=folder / "log.txt",
            env={
                "PYTHONPATH": str(folder / "guard"), "OUTSIDE": str(self.outside),
                "MARKERMEND_METRICS_TOKEN": TOKEN, "BOKEH_PY_LOG_LEVEL": "debug",
            },
        )  # fmt: skip
        self.url = self.served.url
        self.loop = asyncio.new_event_loop()
        self._desks: dict[str, Visitor] = {}

    def close(self) -> None:
        """Close all windows, and end."""
        for desk in self._desks.values():
            self.loop.run_until_complete(desk.close())
        self.loop.close()
        self.served.stop()

    async def visitor(self, name: str) -> Visitor:
        """Give somebody who is logged in."""
        visitor = Visitor(self.url)
        assert (await visitor.log_in(name, PASSWORD)).code == 302
        return visitor

    async def at_the_desk(self, name: str) -> Visitor:
        """Give somebody whose take is open; tests go on at the same desk, which costs less."""
        if name not in self._desks:
            visitor = self._desks[name] = await self.visitor(name)
            await visitor.open()
            await visitor.until(lambda _: visitor.settled)
        return self._desks[name]

    async def leaves(self, name: str) -> None:
        """Close somebody's window."""
        await self._desks.pop(name).close()


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Lab]:
    served = Lab(tmp_path_factory.mktemp("lab"))
    yield served
    served.close()


def trying(test: Callable[[Lab], Coroutine[Any, Any, None]]) -> Callable[[Lab], None]:
    """Let a test wait for answers."""

    def run(lab: Lab) -> None:
        lab.loop.run_until_complete(test(lab))

    run.__name__, run.__doc__ = test.__name__, test.__doc__
    return run


async def refused(opening: Coroutine[Any, Any, Any]) -> int:
    """Give with which status a websocket was refused."""
    with pytest.raises(HTTPClientError) as error:
        await opening
    return int(error.value.code)


@trying
async def test_nobody_without_a_login(lab: Lab):
    stranger = Visitor(lab.url)
    for path in (
        "",
        "?x=1",
        "ws",
        "group",
        "metrics",
        "metadata",
        "autoload.js?bokeh-autoload-element=1",
    ):
        answer = await stranger.get(path)
        assert answer.code in (302, 400, 401, 403, 404), (path, answer.code)
        assert b"token" not in answer.body
        if answer.code == 302:
            assert "login" in answer.headers["Location"]
    assert await refused(stranger.connect("x.y.z")) == 403
    anna = await lab.visitor("anna")
    token = await anna.token()
    assert await refused(stranger.connect(token)) == 403, "a session is no login"
    signed = anna.cookies["user"]
    for forged in (signed[:-2] + "00", signed.replace("YW5uYQ==", "YmVydA=="), "anna", ""):
        stranger.cookies["user"] = forged
        assert (await stranger.get()).code == 302, forged


@trying
async def test_only_the_right_password_and_only_from_the_form(lab: Lab):
    for name, password in (("anna", "wrong"), ("nobody", PASSWORD), ("", ""), ("anna", "")):
        visitor = Visitor(lab.url)
        answer = await visitor.log_in(name, password)
        assert answer.code == 401
        assert b"do not belong together" in answer.body
        assert "user" not in visitor.cookies
    body = f"username=anna&password={PASSWORD.replace(' ', '+')}"
    assert (await Visitor(lab.url).get("login", method="POST", body=body)).code == 403
    page = await Visitor(lab.url).get("login?next=//evil.example&error=<script>")
    assert b"evil.example" not in page.body + str(list(page.headers.get_all())).encode()
    assert b"<script>" not in page.body


@trying
async def test_a_login_is_kept_in_a_careful_cookie_and_ends(lab: Lab):
    visitor = Visitor(lab.url)
    answer = await visitor.log_in("anna", PASSWORD)
    (cookie,) = [c for c in answer.headers.get_list("Set-Cookie") if c.startswith("user=")]
    assert "HttpOnly" in cookie
    assert "SameSite=Lax" in cookie
    kept = dict(visitor.cookies)
    assert b"logged out" in (await visitor.get("logout")).body
    assert "user" not in visitor.cookies
    assert (await visitor.get()).code == 302
    page = await Visitor(lab.url).get(headers={"Cookie": f"user={kept['user']}"})
    assert kept["user"].encode() not in page.body, "no script of the page sees the login"


@trying
async def test_a_session_belongs_to_one_person(lab: Lab):
    anna, bert = await lab.visitor("anna"), await lab.visitor("bert")
    token = await anna.token()
    assert await refused(bert.connect(token)) == 403
    for given in (f"?bokeh-token={token}", "?bokeh-session-id=chosen"):
        assert (await bert.get(given)).code == 403
    assert (await bert.get(headers={"Bokeh-Session-Id": "chosen"})).code == 403
    assert token != await anna.token()
    opened = await anna.connect(token)
    opened.close()


@trying
async def test_other_pages_and_other_names_are_refused(lab: Lab):
    anna = await lab.visitor("anna")
    token = await anna.token()
    port = lab.url.rsplit(":", 1)[1].strip("/")
    for origin in ("http://evil.example", f"http://evil.example:{port}", "null", "file://",
                   f"https://localhost:{port}", f"http://localhost:{int(port) + 1}"):  # fmt: skip
        assert await refused(anna.connect(token, Origin=origin)) == 403, origin
    for host in ("evil.example", f"evil.example:{port}", f"localhost.evil.example:{port}"):
        answer = await anna.get(headers={"Host": host})
        assert answer.code == 421, host
        assert await refused(anna.connect(token, Host=host)) in (400, 403, 421)


HOSTILE = ("/etc/passwd", "../secret.c3d", "../archive/../secret.c3d", "link.c3d", "~/x.c3d",
           "C:\\x.c3d", "\\\\server\\x.c3d", "a\x00b", "/proc/self/environ")  # fmt: skip


@trying
async def test_no_path_outside_the_folder(lab: Lab):
    anna = await lab.at_the_desk("anna")
    for path in HOSTILE if os.name == "posix" else [p for p in HOSTILE if p != "link.c3d"]:
        await anna.do("open", path)
        await anna.until(lambda page: "does not lie in the archive" in page)
        await anna.do("dismiss")
        await anna.until(lambda page: "does not lie in the archive" not in page)
    await anna.do("open", "%2e%2e/secret.c3d")
    await anna.until(lambda page: 'role="alert"' in page and "secret" in page)
    await anna.do("takes")
    listed = await anna.until(
        lambda page: re.findall(r'data-do="open"[^>]*data-arg="([^"]+)"', page)
    )
    assert {Path(p).parent for p in listed} == {lab.folder.resolve()}
    assert "link.c3d" not in {Path(p).name for p in listed}
    await anna.do("close")
    await anna.do("dismiss")


def raw(lab: Lab, target: str) -> bytes:
    """Ask for exactly this target, which no client would send."""
    host, port = lab.url.removeprefix("http://").strip("/").split(":")
    with socket.create_connection((host, int(port)), timeout=30) as stream:
        request = f"GET {target} HTTP/1.1\r\nHost: {host}:{port}\r\nConnection: close\r\n\r\n"
        stream.sendall(request.encode("latin-1"))
        return b"".join(iter(lambda: stream.recv(65536), b""))


def test_no_static_path_leads_anywhere(lab: Lab):
    up = ("../" * 12, "..%2f" * 12, "%2e%2e/" * 12, "%252e%252e%252f" * 12, "..\\" * 12,
          "..%5c" * 12, "....//" * 12,
          "/", "%2f", "%00/", "%c0%ae%c0%ae/" * 12)  # fmt: skip
    for start in ("/static/", "/static/js/", "/static/extensions/panel/", "/static/extensions/",
                  "/components/", "/"):  # fmt: skip
        for way in up:
            answer = raw(lab, start + way + "etc/passwd")
            assert b"root:" not in answer
            assert re.match(rb"HTTP/1.1 (30\d|40\d)", answer), (start, way, answer[:200])
    for folder in ("/static", "/static/", "/static/js", "/static/js/", "/static/extensions/panel/"):
        assert re.match(rb"HTTP/1.1 (403|404)", raw(lab, folder)), "no folder is listed"
    assert raw(lab, "/static/js/bokeh.min.js").startswith(b"HTTP/1.1 200")
    for module in ("antigravity/x/css/y", "panel.config/config/css/x", "os/path/css/x"):
        assert raw(lab, f"/components/{module}").startswith(b"HTTP/1.1 404")


@trying
async def test_uploads_are_bounded(lab: Lab):
    anna = await lab.at_the_desk("anna")
    await anna.message("Document", {"file": "huge.c3d", "first": True, "too_large": 3_000_000_000})
    await anna.until(lambda page: "huge.c3d has 3e+03 MB, and at most 1 MB can be dropped" in page)
    await anna.do("dismiss")
    part = b64encode(bytes(700_000)).decode()
    for i in range(3):  # a browser that does not keep to what it was told
        message = {"file": "liar.c3d", "first": i == 0, "last": i == 2, "data": part}
        await anna.message("Document", message)
    await anna.until(lambda page: "liar.c3d has" in page and "can be dropped" in page)
    assert not (lab.folder / "dropped").exists()
    await anna.message("Document", {"file": "x.c3d", "data": "A" * 2_500_000})
    with pytest.raises(ConnectionError):
        await anna.until(lambda _: False)
    await lab.leaves("anna")
    try:
        code = (await Visitor(lab.url).get("login", method="POST", body="x" * 100_000)).code
    except OSError:  # it hung up before it had heard all
        code = 400
    assert code in (400, 413, 599)


@trying
async def test_two_people_in_one_process_do_not_meet(lab: Lab):
    anna, bert = await lab.at_the_desk("anna"), await lab.at_the_desk("bert")
    before, others = anna.settled[0], bert.settled[0]
    await anna.do("reject")
    await anna.until(lambda _: anna.settled[0] == before + 1)
    await anna.do("filter_text", "only-annas-words")
    await anna.until(lambda page: "only-annas-words" in page)
    await bert.do("thresholds")
    await bert.until(lambda page: 'data-dialog="thresholds"' in page)
    await anna.do("next")
    await asyncio.sleep(0.3)
    assert bert.settled[0] == others
    assert "only-annas-words" not in bert.page
    assert 'data-dialog="thresholds"' not in anna.page
    assert not set(anna.values) & set(bert.values) - shared_ids(anna, bert)
    with Store(lab.store) as store:
        by = {record.operator: len(store.entries(record.id)) for record in store.reviews()}
    assert by["anna"] == before + 1
    assert by["bert"] == others
    await anna.do("filter_clear")
    await bert.do("close")
    await bert.do("agreement")
    await bert.until(lambda page: "is for reviewers, and bert is operator here" in page)
    await bert.do("dismiss")


def shared_ids(one: Visitor, other: Visitor) -> set[str]:
    """Give the ids under which both know the very same value, such as a constant of Bokeh's."""
    return {i for i in set(one.values) & set(other.values) if one.values[i] == other.values[i]}


@trying
async def test_health_and_figures(lab: Lab):
    stranger = Visitor(lab.url)
    for headers in ({}, {"Host": "whatever.example"}):
        answer = await stranger.get("health", headers=headers)
        assert answer.code == 200
        assert json.loads(answer.body) == {"status": "ok", "store": "reachable"}
    assert (await stranger.get("metrics", headers={"Authorization": "Bearer no"})).code == 401
    answer = await stranger.get("metrics", headers={"Authorization": f"Bearer {TOKEN}"})
    anna = await lab.visitor("anna")
    assert (await anna.get("metrics")).code == answer.code == 200
    assert answer.headers["Content-Type"].startswith("text/plain")
    for name in ("sessions", "sessions_opened_total", "decisions_total", "decision_seconds_bucket",
                 "http_requests_total", "loop_delay_seconds_count"):  # fmt: skip
        assert re.search(rf"^markermend_{name}[ {{]", answer.body.decode(), re.MULTILINE), name


@trying
async def test_a_group_is_shown_to_its_teacher(lab: Lab):
    assert (await Visitor(lab.url).get("group")).code == 302
    assert (await (await lab.visitor("bert")).get("group")).code == 403
    answer = await (await lab.visitor("carla")).get("group")
    assert answer.code == 200
    assert b"Nobody has finished an exercise yet" in answer.body


@trying
async def test_every_answer_tells_the_browser_to_be_strict(lab: Lab):
    anna, stranger = await lab.visitor("anna"), Visitor(lab.url)
    answers = [await anna.get(), await anna.get("metrics"), await stranger.get("login")]
    answers += [await stranger.get(p) for p in ("", "health", "nowhere", "static/js/bokeh.min.js")]
    for answer in answers:
        policy = answer.headers["Content-Security-Policy"]
        scripts = re.search(r"script-src ([^;]+)", policy)[1]
        assert "unsafe" not in scripts
        assert "http" not in policy
        assert "frame-ancestors 'none'" in policy
        for name in ("X-Content-Type-Options", "Referrer-Policy", "Permissions-Policy",
                     "Cross-Origin-Opener-Policy", "X-Frame-Options"):  # fmt: skip
            assert answer.headers[name]
    for answer in answers[:-1]:
        assert answer.headers["Cache-Control"] == "no-store"


@trying
async def test_nothing_secret_is_logged_and_nothing_goes_out(lab: Lab):
    anna = await lab.at_the_desk("anna")
    token = await anna.token()
    await anna.do("undo")
    await anna.do("reject")
    await Visitor(lab.url).log_in("bert", "a wrong password")
    said = lab.served.said
    for secret in (PASSWORD, PASSWORD.replace(" ", "+"), "a wrong password", "a+wrong+password",
                   TOKEN, anna.cookies["user"], anna.cookies["_xsrf"], token,
                   "scrypt$"):  # fmt: skip
        assert secret not in said, said[max(0, said.find(secret) - 200) :][:400]
    assert not lab.outside.exists(), lab.outside.read_text()


def test_two_processes_share_the_people_and_end_with_their_parent(tmp_path: Path):
    lab = Lab(tmp_path, "--processes", 2)
    port = int(lab.url.rsplit(":", 1)[1].strip("/"))
    children = psutil.Process(lab.served.process.pid).children(recursive=True)
    try:
        lab.loop.run_until_complete(_led(lab, port))
    finally:
        lab.served.process.kill()
        lab.close()
    end = time.monotonic() + 30
    while any(child.is_running() and child.status() != psutil.STATUS_ZOMBIE for child in children):
        assert time.monotonic() < end, "a process outlived its parent"
        time.sleep(0.1)


async def _led(lab: Lab, port: int) -> None:
    homes = set()
    for name in ("anna", "bert"):
        one = Visitor(f"http://localhost:{port}")
        assert (await one.log_in(name, PASSWORD)).code == 302
        answer = await one.get()
        home = answer.headers.get("Location", one.url)
        assert home in (f"http://localhost:{port}/", f"http://localhost:{port + 1}/")
        there = Visitor(home)
        there.cookies = dict(one.cookies)
        assert (await there.get("metrics")).code == 200, "a login counts in every process"
        homes.add(home)
    assert len(homes) == 2, "one is served here, the other there"
