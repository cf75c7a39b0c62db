"""Who is at the other end: Panel's own logins, with people, limits and careful cookies.

The name that was proven lives in one signed cookie, which scripts cannot read. It never gets into
a page: the session of a page is bound to its person by the signed token of the session, and the
websocket must come from the same person.
"""

import asyncio
import time
from collections import OrderedDict
from pathlib import Path
from typing import Any

from bokeh.application.handlers.handler import Handler
from bokeh.util.token import check_token_signature, get_token_payload
from panel.auth import BasicAuthProvider, BasicLoginHandler, LogoutHandler, OAuthProvider
from tornado.httputil import HTTPServerRequest
from tornado.web import HTTPError, RequestHandler, decode_signed_value
from tornado.websocket import WebSocketHandler

from markermend_app.serving.accounts import LONGEST_PASSWORD, People
from markermend_app.state.people import Person

PAGE = Path(__file__).with_name("login.html")
COOKIE = "user"
"""Panel's own name of it."""
DAYS = 1.0
PERSON = "person"
"""What the token of a session calls its person."""


class Gate:
    """What all handlers of one server ask: who is it, and may he come in.

    Parameters
    ----------
    people
        Who may, or None where everybody who reaches the server may.
    secret
        Signs cookies.
    """

    def __init__(self, people: People | None, secret: str) -> None:
        self.people, self._secret = people, secret
        self.tries = Tries()

    @property
    def open(self) -> bool:
        """Whether nobody has to log in."""
        return self.people is None

    def proven(self, request: HTTPServerRequest) -> str | None:
        """Give the name that this browser has proven, whether it is still let in or not."""
        morsel = request.cookies.get(COOKIE)
        value = None if morsel is None else morsel.value
        found = decode_signed_value(self._secret, COOKIE, value or "", max_age_days=DAYS)
        return None if found is None else found.decode("utf-8", "replace")

    def person(self, request: HTTPServerRequest) -> Person | None:
        """Give who it is, or None if nobody who may come in."""
        name = self.proven(request)
        return None if name is None or self.people is None else self.people.person(name)

    def name(self, handler: RequestHandler) -> str | None:
        """Give the name for a handler; a websocket must belong to the same person as its page."""
        person = self.person(handler.request)
        if person is None:
            return None
        if isinstance(handler, WebSocketHandler) and _of_token(handler) != person.name:
            return None
        return person.name


def _of_token(handler: WebSocketHandler) -> str | None:
    """Give whose session a websocket asks for; None unless this server has signed it."""
    asked = handler.request.headers.get("Sec-WebSocket-Protocol", "").split(",")
    token = asked[-1].strip()
    app = handler.application
    try:
        if not check_token_signature(token, secret_key=app.secret_key, signed=app.sign_sessions):
            return None
        return str(get_token_payload(token).get(PERSON))
    except ValueError:  # it is no token at all
        return None


class Bound(Handler):  # type: ignore[misc]  # bokeh has no types
    """Writes into the token of every session whose it is."""

    def __init__(self, gate: Gate) -> None:
        super().__init__()
        self._gate = gate

    def modify_document(self, doc: Any) -> None:
        """Leave the document as it is."""

    def process_request(self, request: HTTPServerRequest) -> dict[str, Any]:
        """Give what the token holds; see Bokeh's `Handler`."""
        person = self._gate.person(request)
        return {} if person is None else {PERSON: person.name}


class Tries:
    """Counts wrong passwords by name and address, so that guessing becomes slow."""

    MOST, WITHIN_S, KEPT = 8, 300.0, 10_000

    def __init__(self) -> None:
        self._failed: OrderedDict[tuple[str, str], list[float]] = OrderedDict()

    def exhausted(self, key: tuple[str, str]) -> bool:
        """Say whether there were too many lately."""
        since = time.monotonic() - self.WITHIN_S
        recent = [at for at in self._failed.get(key, ()) if at > since]
        return len(recent) >= self.MOST

    def failed(self, key: tuple[str, str]) -> None:
        """Note a wrong one."""
        self._failed.setdefault(key, []).append(time.monotonic())
        del self._failed[key][: -self.MOST]
        self._failed.move_to_end(key)
        while len(self._failed) > self.KEPT:
            self._failed.popitem(last=False)


class Careful(RequestHandler):
    """Cookies that no script reads, that no other site sends, and that stay on https."""

    def set_cookie(self, name: str, value: str | bytes, *given: Any, **flags: Any) -> None:
        """Set a cookie with all flags."""
        flags |= {"httponly": True, "samesite": "Lax", "secure": self.settings["secure_cookies"]}
        super().set_cookie(name, value, *given, **flags)

    def show(self, **values: Any) -> None:
        """Write the page that stands before the desk."""
        shown = {"said": "", "form": "", "way": "./", "words": "Go on"} | values
        self.render(str(PAGE), **shown)


class Login(Careful, BasicLoginHandler):  # type: ignore[misc]
    """Asks for a name and a password."""

    def get(self) -> None:
        """Show the form."""
        self.show(form=self.xsrf_form_html())

    async def post(self) -> None:
        """Let somebody in, or say in a sentence why not."""
        gate: Gate = self.settings["gate"]
        name, password = self.get_argument("username", ""), self._password()
        key = (name[:80], str(self.request.remote_ip))
        if gate.people is None or gate.tries.exhausted(key):
            self.set_status(429)
            said = "Too many wrong passwords; wait five minutes and try again."
            self.show(said=said, form=self.xsrf_form_html())
            return
        loop = asyncio.get_running_loop()
        person = await loop.run_in_executor(None, gate.people.check, name, password)
        if person is None:
            gate.tries.failed(key)
            self.set_status(401)
            said = "Name and password do not belong together; try again."
            self.show(said=said, form=self.xsrf_form_html())
            return
        self.set_signed_cookie(COOKIE, person.name, expires_days=DAYS)
        self.redirect("./")

    def _password(self) -> str:
        given = self.get_arguments("password", strip=False)
        if len(given) != 1 or len(given[0]) > LONGEST_PASSWORD:
            raise HTTPError(400)
        return str(given[0])


class Logout(Careful, LogoutHandler):  # type: ignore[misc]
    """Forgets who it is."""

    def get(self) -> None:
        """Clear the cookies and say so."""
        for name in self.request.cookies:
            if name != "_xsrf":
                self.clear_cookie(name)
        self.set_header("Clear-Site-Data", '"cache"')
        self.show(said="You are logged out; every decision is kept.", way="./login", words="Log in")


class Basic(BasicAuthProvider):  # type: ignore[misc]
    """Panel's login by name and password, of the people of a file."""

    def __init__(self, gate: Gate) -> None:
        self._gate = gate
        super().__init__()

    @property
    def get_user(self) -> Any:
        """Give the function that names who asks."""
        return self._gate.name

    @property
    def login_handler(self) -> Any:
        """Give the handler that asks for a password."""
        return Login

    @property
    def logout_handler(self) -> Any:
        """Give the handler that forgets."""
        return Logout


class Oauth(OAuthProvider):  # type: ignore[misc]
    """Panel's login by an identity provider, for the people of a file."""

    def __init__(self, gate: Gate) -> None:
        self._gate = gate
        super().__init__()

    @property
    def get_user_async(self) -> Any:
        """Give the function that names who asks."""
        name = self._gate.name

        async def get_user(handler: RequestHandler) -> str | None:
            return name(handler)

        return get_user

    @property
    def login_handler(self) -> Any:
        """Give Panel's handler for the provider, with careful cookies."""
        asks = super().login_handler
        return type(asks.__name__, (Careful, asks), {})

    @property
    def logout_handler(self) -> Any:
        """Give the handler that forgets."""
        return Logout
