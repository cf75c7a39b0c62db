"""Logins by an identity provider, which is played here: who is listed comes in, others do not."""

import asyncio
import json
from base64 import urlsafe_b64encode
from pathlib import Path
from urllib.parse import urlencode

from tests.visitor import Served, Visitor, free_ports
from tornado.httpserver import HTTPServer
from tornado.httputil import url_concat
from tornado.web import Application, RequestHandler

import markermend as mm

from .conftest import made_take

SECRET = "the-secret-of-the-client"


class Provider:
    """An identity provider at which somebody is logged in already."""

    def __init__(self) -> None:
        self.who, self.given = "", []
        provider = self

        class Authorize(RequestHandler):
            def get(self) -> None:
                back = {"code": "a-code", "state": self.get_argument("state")}
                self.redirect(url_concat(self.get_argument("redirect_uri"), back))

        class Token(RequestHandler):
            def post(self) -> None:
                provider.given.append(self.get_argument("client_secret"))
                claims = json.dumps({"email": provider.who}).encode()
                token = f"e30.{urlsafe_b64encode(claims).decode().rstrip('=')}.e30"
                self.write({"access_token": "access", "id_token": token})

        self.port = free_ports()
        self.server = HTTPServer(Application([("/authorize", Authorize), ("/token", Token)]))
        self.server.listen(self.port, "127.0.0.1")


def test_a_provider_names_people_and_the_file_admits_them(tmp_path: Path):
    asyncio.run(_logins(tmp_path))


async def _logins(tmp_path: Path) -> None:
    archive, people = tmp_path / "archive", tmp_path / "people.json"
    archive.mkdir()
    mm.write(made_take(), archive / "small.c3d")
    people.write_text(json.dumps({"anna@lab.example": "teacher"}))
    provider = Provider()
    at = f"http://127.0.0.1:{provider.port}"
    served = await asyncio.to_thread(
        Served, "serve", archive, "--store", tmp_path / "store.sqlite", "--port", free_ports(),
        "--login", "oauth:generic", "--people", people, log=tmp_path / "log.txt",
        env={
            "PANEL_OAUTH_KEY": "markermend", "PANEL_OAUTH_SECRET": SECRET,
            "PANEL_OAUTH_TOKEN_URL": f"{at}/token", "PANEL_OAUTH_AUTHORIZE_URL": f"{at}/authorize",
        },
    )  # fmt: skip
    try:
        for who, admitted in (("anna@lab.example", True), ("eve@evil.example", False)):
            provider.who, visitor = who, Visitor(served.url)
            answer = await visitor.get("login")
            assert answer.code == 302
            asked = answer.headers["Location"]
            assert asked.startswith(at)
            assert SECRET not in asked
            back = (await visitor.get_from(asked)).headers["Location"]
            answer = await visitor.get("login?" + back.partition("?")[2])
            flags = [c for c in answer.headers.get_list("Set-Cookie") if c.startswith("user=")]
            assert all("HttpOnly" in c and "SameSite=Lax" in c for c in flags)
            page = await visitor.get()
            assert page.code == (200 if admitted else 403)
            assert (await visitor.get("group")).code == (200 if admitted else 302)
            if not admitted:
                assert b"eve@evil.example may not come in here" in page.body
        assert provider.given == [SECRET, SECRET]
        stolen = Visitor(served.url)
        query = urlencode({"code": "a-code", "state": "chosen"})
        assert (await stolen.get(f"login?{query}")).code == 401, "a state that was not given out"
        assert SECRET not in served.said
    finally:
        served.stop()
        provider.server.stop()
