"""Who may come in: names with passwords, and the roles of the people of a lab.

A file of accounts is JSON, ``{"anna": {"password": "scrypt$…", "role": "reviewer"}}``, as
``markermend account`` writes it; ``{"anna": "password"}``, as Panel's own, is read too. A file of
roles is ``{"anna": "reviewer"}``. Both are read anew when they change.
"""

import hashlib
import hmac
import json
import secrets
import threading
from base64 import b64decode, b64encode
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from markermend.errors import BadInput
from markermend_app.state.people import Person, as_role

COST = {"n": 2**14, "r": 8, "p": 1}
"""Of scrypt: about 50 ms and 16 MB for each guess."""
LONGEST_NAME = 64
LONGEST_PASSWORD = 1024


@dataclass(frozen=True)
class Account:
    """A person and what the password is compared with; empty where somebody else asks for it."""

    person: Person
    password: str = ""


def hashed(password: str) -> str:
    """Give what is kept of a password."""
    salt = secrets.token_bytes(16)
    key = hashlib.scrypt(password.encode(), salt=salt, **COST)  # type: ignore[arg-type]
    return f"scrypt${b64encode(salt).decode()}${b64encode(key).decode()}"


_NOBODY = hashed(secrets.token_urlsafe(16))


def fits(password: str, kept: str) -> bool:
    """Say whether a password is the one that is kept, in a time that does not tell how near."""
    given = password[:LONGEST_PASSWORD].encode("utf-8", "surrogatepass")
    if not kept.startswith("scrypt$"):
        return hmac.compare_digest(given, kept.encode())
    _, salt, key = kept.split("$")
    made = hashlib.scrypt(given, salt=b64decode(salt), **COST)  # type: ignore[arg-type]
    return hmac.compare_digest(made, b64decode(key))


class People:
    """The people of a file, which is read again when it changes.

    Parameters
    ----------
    path
        A file of accounts or roles.
    passwords
        Whether everybody in it needs a password.

    Raises
    ------
    BadInput
        If the file cannot be used.
    """

    def __init__(self, path: Path, *, passwords: bool) -> None:
        self._path, self._passwords = path, passwords
        self._lock = threading.Lock()
        self._stamp, self._accounts = self._read()

    def person(self, name: str) -> Person | None:
        """Give somebody who may come in, or None."""
        account = self._now().get(name)
        return None if account is None else account.person

    def check(self, name: str, password: str) -> Person | None:
        """Give the person of a name and password, or None; nobody takes as long as somebody."""
        account = self._now().get(name)
        right = fits(password, _NOBODY if account is None else account.password)
        return account.person if account is not None and account.password and right else None

    @property
    def in_plain_text(self) -> tuple[str, ...]:
        """Names whose passwords anybody can read in the file."""
        return tuple(
            name
            for name, account in self._now().items()
            if self._passwords and not account.password.startswith("scrypt$")
        )

    def _now(self) -> Mapping[str, Account]:
        with self._lock:
            try:
                if self._stamp != _stamp(self._path):
                    self._stamp, self._accounts = self._read()
            except (BadInput, OSError):
                pass  # it is being written, or was spoiled: those who were known stay known
            return self._accounts

    def _read(self) -> tuple[tuple[int, int], Mapping[str, Account]]:
        return _stamp(self._path), read_accounts(self._path, passwords=self._passwords)


def _stamp(path: Path) -> tuple[int, int]:
    try:
        found = path.stat()
    except OSError:
        return 0, 0
    return found.st_mtime_ns, found.st_size


def read_accounts(path: Path, *, passwords: bool) -> dict[str, Account]:
    """Read a file of accounts or roles.

    Raises
    ------
    BadInput
        If it is no such file.
    """
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise BadInput(
            f"The people in {path} cannot be read ({error.strerror}); write them with "
            "markermend account."
        ) from None
    except ValueError:
        found = None
    if not isinstance(found, dict) or not found:
        raise BadInput(
            f"{path} names no people; write them with markermend account, or as "
            '{"anna": "reviewer"} where somebody else asks for passwords.'
        )
    return {name: _account(name, entry, passwords) for name, entry in found.items()}


def _account(name: str, entry: object, passwords: bool) -> Account:
    check_name(name)
    if passwords and isinstance(entry, str):
        entry = {"password": entry}
    elif not passwords:
        entry = {"role": entry} if isinstance(entry, str) else entry
    if not isinstance(entry, dict):
        raise BadInput(f"What is said of {name} is no account; see markermend account --help.")
    role = as_role(entry.get("role", "operator"), name)
    password = entry.get("password", "")
    if passwords and (not isinstance(password, str) or not _usable(password)):
        raise BadInput(f"{name} has no password; give one with markermend account.")
    return Account(Person(name, role, signed_in=True), password if passwords else "")


def _usable(kept: str) -> bool:
    return bool(kept) and (not kept.startswith("scrypt$") or kept.count("$") == 2)


def check_name(name: str) -> None:
    """Refuse what is no name of a person.

    Raises
    ------
    BadInput
        If it is empty, too long, or cannot be shown.
    """
    if not name or name != name.strip() or len(name) > LONGEST_NAME or not name.isprintable():
        raise BadInput(f"{name[:80]!r} is no name; use 1 to {LONGEST_NAME} characters of a line.")
