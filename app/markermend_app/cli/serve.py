"""``markermend serve FOLDER``: an archive of takes for the people of a lab."""

import argparse
import os
from pathlib import Path

from markermend.errors import BadInput
from markermend_app.cli.common import lacking, positive, warn, whole
from markermend_app.cli.review import refuse_without_the_extra
from markermend_app.cli.terminal import finish, say

PORT = 5006
MOST_UPLOAD_MB = 512.0
OAUTH = ("PANEL_OAUTH_KEY", "PANEL_OAUTH_SECRET")


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument(
        "folder", metavar="FOLDER", type=Path, help="the archive; nothing else can be reached"
    )
    parser.add_argument(
        "--store",
        metavar="WHERE",
        help="a file, or postgresql://… (default: MARKERMEND_STORE, else your data folder)",
    )
    parser.add_argument(
        "--port", type=whole(1, 65535), default=PORT, metavar="N", help=f"default: {PORT}"
    )
    parser.add_argument(
        "--address",
        default="127.0.0.1",
        metavar="IP",
        help="where to listen (default: this machine alone; 0.0.0.0 is everywhere)",
    )
    parser.add_argument(
        "--origin",
        action="append",
        default=[],
        metavar="URL",
        help="how people reach it, e.g. https://mocap.lab.example; may be given several times",
    )
    parser.add_argument(
        "--processes",
        type=whole(1, 256),
        default=1,
        metavar="N",
        help="servers on N ports from --port on (default: 1)",
    )
    parser.add_argument(
        "--login",
        metavar="HOW",
        help="basic:FILE with the accounts of markermend account, or oauth:PROVIDER with --people",
    )
    parser.add_argument(
        "--people",
        metavar="FILE",
        type=Path,
        help='who may come in by OAuth, and as what: {"anna@lab.example": "reviewer"}',
    )
    parser.add_argument(
        "--max-upload",
        type=positive("MB"),
        default=MOST_UPLOAD_MB,
        metavar="MB",
        help=f"largest file that can be dropped on a page (default: {MOST_UPLOAD_MB:g})",
    )
    lacking(parser)


def run(options: argparse.Namespace) -> None:
    """Serve until interrupted."""
    refuse_without_the_extra()
    from markermend_app.serving.accounts import People
    from markermend_app.serving.doors import is_loopback
    from markermend_app.serving.lab import Lab, run
    from markermend_app.serving.server import new_secret

    people, provider = _login(options)
    if people is None and not is_loopback(options.address):
        raise BadInput(
            f"At {options.address} anybody could decide on your takes; add --login basic:FILE, or "
            "leave --address out."
        )
    if people is None and options.origin:
        raise BadInput("Who is reached by --origin needs a --login; add --login basic:FILE.")
    if options.port + options.processes - 1 > 65535:
        raise BadInput("There are no ports above 65535; give a lower --port.")
    lab = Lab(
        folder=options.folder,
        store=options.store,
        address=options.address,
        port=options.port,
        origins=tuple(options.origin),
        processes=options.processes,
        people=people,
        provider=provider,
        most_upload=int(options.max_upload * 1e6),
        secret=new_secret(),
        units=options.units,
        rate=options.rate,
        ignore_residuals=options.ignore_residuals,
    )
    if people is not None and (plain := People(people, passwords=not provider).in_plain_text):
        told = f"{people} holds {len(plain)} passwords that anybody who reads it knows"
        warn([f"{told}; write them with markermend account."])

    def announce(address: str) -> None:
        several = f", {options.processes} processes" if options.processes > 1 else ""
        say(f"MarkerMend serves {options.folder} at {address}{several} (Ctrl+C stops it)")
        finish()

    run(lab, announce)


def _login(options: argparse.Namespace) -> tuple[Path | None, str]:
    """Give the file of people, and the name of an OAuth provider."""
    if options.login is None:
        if options.people is not None:
            raise BadInput("--people belongs to --login oauth:PROVIDER; add it, or leave it out.")
        return None, ""
    how, _, what = options.login.partition(":")
    if how == "basic" and what:
        if options.people is not None:
            raise BadInput("With --login basic:FILE, roles are in that file; leave --people out.")
        return Path(what).expanduser(), ""
    if how == "oauth" and what:
        return _oauth(options, what), what
    raise BadInput(f"--login takes basic:FILE or oauth:PROVIDER; got {options.login!r}.")


def _oauth(options: argparse.Namespace, provider: str) -> Path:
    from panel.auth import AUTH_PROVIDERS

    known = sorted(set(AUTH_PROVIDERS) - {"basic", "pam", "password"})
    if provider not in known:
        raise BadInput(f"There is no provider {provider!r}; known are {', '.join(known)}.")
    missing = [name for name in OAUTH if not os.environ.get(name)]
    if missing:
        raise BadInput(
            f"The key and secret of {provider} are read from the environment; set "
            f"{' and '.join(missing)}."
        )
    if options.people is None:
        raise BadInput(
            f"Everybody with an account at {provider} could come in; say who may: --people FILE."
        )
    people: Path = options.people
    return people
