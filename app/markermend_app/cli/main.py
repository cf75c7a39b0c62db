"""Parse the command line, run one command, and turn its outcome into an exit code.

Exit codes: 0 done; 2 one sentence on stderr for bad input or usage; 1 a fault of ours.
"""

import argparse
import importlib
import os
import sys
import traceback
from collections.abc import Sequence
from types import ModuleType
from typing import Any, NoReturn

from markermend import __version__
from markermend.errors import MarkerMendError
from markermend_app.cli.terminal import ReaderGone, finish, hush, put, say, sentence, show_anything

COMMANDS = {
    "review": "review a take in the browser",
    "demo": "review the demonstration take",
    "info": "say what a take holds",
    "detect": "list gaps and artefacts",
    "repair": "fill gaps, repair artefacts, write the take back",
    "batch": "detect, and repair by a policy, over an archive of takes",
    "join": "put two takes into one and fill the time between",
    "evaluate": "repeat the published experiments and benchmarks, as tables",
    "simulate": "make a take of a walking or sitting person, with known artefacts",
    "serve": "serve an archive to the people of a lab",
    "account": "let somebody in at a lab's server",
    "train": "practise on a take whose truth is known, and be graded",
    "agree": "compare what several operators decided on one take",
    "recipe": "save, list, show or delete how a lab looks at takes",
    "store": "check, back up or restore the store of reviews",
}


class _Usage(Exception):
    """What was typed is not a command."""


class _Parser(argparse.ArgumentParser):
    """Refuses in one sentence; an option is written out, so that later ones never clash with it."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings, allow_abbrev=False)

    def error(self, message: str) -> NoReturn:
        raise _Usage(f"{self.prog}: {message}; see {self.prog} --help")


def _parser(command: str | None) -> argparse.ArgumentParser:
    parser = _Parser(
        prog="markermend",
        description="Find, judge and repair artefacts in marker trajectories.",
    )
    parser.add_argument("--version", action="version", version=f"markermend {__version__}")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for name, summary in COMMANDS.items():
        sub = commands.add_parser(name, help=summary, description=f"{summary.capitalize()}.")
        if name == command:  # only the command at hand is imported: the others cost nothing
            _module(name).arguments(sub)
    return parser


def _module(name: str) -> ModuleType:
    return importlib.import_module(f"markermend_app.cli.{name}")


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code."""
    given = list(sys.argv[1:] if argv is None else argv)
    show_anything()
    # Our matrices are small: threads of a numerical library would only wait for each other.
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    command = next((word for word in given if not word.startswith("-")), None)
    code = 0
    try:
        try:
            code = _run(given, command if command in COMMANDS else None)
        except (MarkerMendError, _Usage) as refusal:
            code = 2
            say(sentence(refusal), file=sys.stderr)
        except KeyboardInterrupt:
            code = 130
        except ReaderGone:
            raise
        except Exception:  # noqa: BLE001  a fault of ours: the whole of it, and exit code 1
            code = 1
            put(traceback.format_exc(), file=sys.stderr)
            say("This is a fault of markermend; please report these lines.", file=sys.stderr)
        finish()
    except ReaderGone:
        hush()
    return code


def _run(given: Sequence[str], command: str | None) -> int:
    try:
        options = _parser(command).parse_args(given)
    except SystemExit as done:  # --help and --version
        return int(done.code or 0)
    return _module(options.command).run(options) or 0
