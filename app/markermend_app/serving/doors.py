"""Under which names a server may be reached, and from which pages its websocket."""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from ipaddress import ip_address
from urllib.parse import urlsplit

from markermend.errors import BadInput

LOOPBACK = ("localhost", "127.0.0.1", "[::1]")
PORTS = {"http": 80, "https": 443}


def is_loopback(address: str) -> bool:
    """Say whether only this machine reaches an address."""
    if address == "localhost":
        return True
    try:
        return ip_address(address).is_loopback
    except ValueError:
        return False


@dataclass(frozen=True)
class Doors:
    """The addresses of one server, as browsers write them.

    Attributes
    ----------
    origins
        Such as ``https://lab.example``; a page from anywhere else is refused.
    """

    origins: tuple[str, ...]

    @property
    def hosts(self) -> tuple[str, ...]:
        """Names under which it answers; any other may be a name that was bent to this machine."""
        return tuple(dict.fromkeys(_host(urlsplit(origin).hostname) for origin in self.origins))

    @property
    def https(self) -> bool:
        """Whether it is reached by https alone."""
        return all(origin.startswith("https://") for origin in self.origins)

    @property
    def foreign_host(self) -> str:
        """Regular expression of every name but its own."""
        return f"^(?!(?:{'|'.join(map(re.escape, self.hosts))})$).*$"

    def admits(self, origin: str) -> bool:
        """Say whether a page from there may open the websocket."""
        try:
            return plain_origin(origin) in self.origins
        except BadInput:
            return False

    def on_port(self, port: int) -> "Doors":
        """Give the doors of a process beside this one, on a port of its own."""
        return Doors(
            tuple(
                plain_origin(f"{urlsplit(o).scheme}://{_host(urlsplit(o).hostname)}:{port}")
                for o in self.origins
            )
        )


def loopback_doors(port: int) -> Doors:
    """Give the doors of a server on this machine alone."""
    return Doors(tuple(plain_origin(f"http://{host}:{port}") for host in LOOPBACK))


def doors(address: str, port: int, given: Iterable[str]) -> Doors:
    """Give the doors of a server.

    Parameters
    ----------
    address, port
        Where it listens.
    given
        How people reach it.

    Raises
    ------
    BadInput
        If an origin is none, or one is needed.
    """
    origins = tuple(dict.fromkeys(map(plain_origin, given)))
    if origins:
        return Doors(origins)
    if is_loopback(address):
        return loopback_doors(port)
    if address in ("0.0.0.0", "::", ""):
        raise BadInput(
            "Say under which address people reach this server: --origin http://NAME:PORT, or "
            "https://NAME behind a proxy."
        )
    return Doors((plain_origin(f"http://{_host(address)}:{port}"),))


def plain_origin(given: str) -> str:
    """Write an origin as a browser does: lower case, no default port, no path.

    Raises
    ------
    BadInput
        If it is no origin.
    """
    try:
        parts = urlsplit(given)
        port = parts.port
    except ValueError:
        parts, port = urlsplit(""), None
    host = parts.hostname or ""
    if (
        parts.scheme not in PORTS
        or not re.fullmatch(r"[\w.:-]+", host)
        or parts.path not in ("", "/")
        or parts.query
        or parts.fragment
        or "@" in parts.netloc
    ):
        raise BadInput(
            f"{given!r} is no origin; write it as https://lab.example or http://pc:5006."
        )
    shown = "" if port in (None, PORTS[parts.scheme]) else f":{port}"
    return f"{parts.scheme}://{_host(host)}{shown}"


def _host(name: str | None) -> str:
    name = (name or "").lower()
    return f"[{name}]" if ":" in name and not name.startswith("[") else name
