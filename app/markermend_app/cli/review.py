"""``markermend review PATH…``: the application in the browser."""

import argparse
import importlib.util
from pathlib import Path

from markermend.errors import BadInput, MarkerMendError
from markermend_app.cli.common import lacking, read, whole
from markermend_app.cli.terminal import finish, say

NEEDED = ("bokeh", "panel", "param", "pyvista")
"""What the application imports of the extra."""
NEEDS_APP = "The application needs more packages: install them with pip install 'markermend[app]'."


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument(
        "paths", metavar="PATH", nargs="+", type=Path, help="takes, or folders of takes, to review"
    )
    lacking(parser)
    serving(parser)


def serving(parser: argparse.ArgumentParser) -> None:
    """Add where to serve and where to keep reviews."""
    parser.add_argument(
        "--port",
        type=whole(1, 65535),
        metavar="N",
        help="port on the loopback (default: any free one)",
    )
    parser.add_argument(
        "--window", action="store_true", help="a window of its own, where pywebview is installed"
    )
    parser.add_argument(
        "--keys", metavar="FILE", type=Path, help='other keys, as JSON: {"accept": "Enter"}'
    )
    parser.add_argument("--no-browser", action="store_true", help="print the address only")
    parser.add_argument(
        "--store",
        metavar="PATH",
        help="where reviews are kept (default: MARKERMEND_STORE, else your data folder)",
    )


def run(options: argparse.Namespace) -> None:
    """Serve on the loopback until interrupted."""
    refuse_without_the_extra()
    for path in options.paths:
        if not path.exists():
            raise BadInput(f"There is no file {path}; give the path of a recording.")
    # The page asks for what later takes lack; the one it opens with is refused here and now.
    from markermend_app.state.workspace import work_list

    paths = work_list(path.absolute() for path in options.paths)
    read(paths[0], options)
    serve(options, paths)


def refuse_without_the_extra() -> None:
    """Say what to install, before anything is read.

    Raises
    ------
    MarkerMendError
        If the packages of the application are not installed.
    """
    if not all(map(installed, NEEDED)):
        raise MarkerMendError(NEEDS_APP)


def installed(package: str) -> bool:
    """Say whether a package can be imported, without importing it."""
    try:
        return importlib.util.find_spec(package) is not None
    except ModuleNotFoundError:
        return False


def serve(options: argparse.Namespace, paths: tuple[Path, ...]) -> None:
    """Open the store and serve these takes."""
    from markermend.review.store import Store
    from markermend_app import keys, shell
    from markermend_app.state.workspace import Workspace

    if options.keys is not None:
        keys.use(keys.read_keys(options.keys))
    store = Store(options.store)
    workspace = Workspace(
        store,
        paths,
        units=options.units,
        rate=options.rate,
        ignore_residuals=options.ignore_residuals,
    )
    shell.serve(
        workspace,
        port=options.port,
        show=not options.no_browser,
        window=options.window,
        ready=_announce,
    )


def _announce(address: str) -> None:
    say(f"MarkerMend at {address} (Ctrl+C stops it)")
    finish()
