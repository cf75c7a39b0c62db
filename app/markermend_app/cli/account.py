"""``markermend account FILE NAME``: let somebody in at a lab's server."""

import argparse
import getpass
import json
import sys
from pathlib import Path

from markermend.errors import BadInput
from markermend.io.disk import write_whole
from markermend_app.cli.review import refuse_without_the_extra
from markermend_app.cli.terminal import plain, say

FEWEST_CHARACTERS = 8


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument(
        "file", metavar="FILE", type=Path, help="accounts for markermend serve --login basic:FILE"
    )
    parser.add_argument("name", metavar="NAME", help="under which decisions are kept")
    parser.add_argument(
        "--role",
        metavar="ROLE",
        help="operator, reviewer or teacher (default: as before, else operator)",
    )
    parser.add_argument("--remove", action="store_true", help="let the person in no longer")


def run(options: argparse.Namespace) -> None:
    """Write one account; the password is asked for, or read from stdin."""
    refuse_without_the_extra()
    from markermend_app.serving.accounts import check_name, hashed, read_accounts
    from markermend_app.state.people import as_role

    check_name(options.name)
    if options.file.exists():
        read_accounts(options.file, passwords=True)
        accounts = json.loads(options.file.read_text(encoding="utf-8"))
    else:
        accounts = {}
    if options.remove:
        if options.name not in accounts:
            raise BadInput(f"{options.file} has no account {options.name!r}; nothing was changed.")
        del accounts[options.name]
        if not accounts:
            raise BadInput(
                f"{options.name} is the last account, and a server without any lets nobody in; "
                "remove the file instead."
            )
    else:
        before = accounts.get(options.name, {})
        known = before.get("role", "operator") if isinstance(before, dict) else "operator"
        role = as_role(options.role or known, options.name)
        accounts[options.name] = {"password": hashed(_password(options.name)), "role": role}
    text = json.dumps(accounts, indent=2, ensure_ascii=False) + "\n"
    write_whole(options.file, text.encode(), overwrite=True)
    _for_the_owner_alone(options.file)
    say(f"{options.file}: {len(accounts)} account{'s' if len(accounts) > 1 else ''}")


def _for_the_owner_alone(path: Path) -> None:
    try:
        path.chmod(0o600)
    except OSError as error:
        raise BadInput(
            f"{path} is written, but others may read it ({error.strerror}); keep it elsewhere."
        ) from None


def _password(name: str) -> str:
    if sys.stdin.isatty():
        given = getpass.getpass(f"Password of {plain(name)}: ")
        if given != getpass.getpass("Once more: "):
            raise BadInput("The two are not the same; nothing was changed.")
    else:
        given = sys.stdin.readline().rstrip("\r\n")
    if len(given) < FEWEST_CHARACTERS:
        raise BadInput(
            f"A password has at least {FEWEST_CHARACTERS} characters; give a longer one."
        )
    return given
