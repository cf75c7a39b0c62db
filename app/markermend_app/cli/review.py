"""``markermend review PATH…``: the application in the browser."""

import argparse
import importlib.util
from pathlib import Path
from typing import TYPE_CHECKING

from markermend.errors import BadInput, MarkerMendError
from markermend.model import Take
from markermend_app.cli.common import lacking, read, whole
from markermend_app.cli.terminal import finish, say

if TYPE_CHECKING:
    from markermend.review.store import Store
    from markermend_app.serving.session import Begin
    from markermend_app.state.archive import Archive
    from markermend_app.state.second_review import Comparing

NEEDED = ("bokeh", "panel", "param", "prometheus_client", "pyvista")
"""What the application imports of the extra."""
NEEDS_APP = "The application needs more packages: install them with pip install 'markermend[app]'."


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument(
        "paths", metavar="PATH", nargs="+", type=Path, help="takes, or folders of takes, to review"
    )
    lacking(parser)
    parser.add_argument("--operator", metavar="NAME", help="whose review it is (default: yours)")
    parser.add_argument(
        "--blind",
        action="store_true",
        help="a second review: what others decided on the take is hidden until it is finished",
    )
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
    from markermend_app.state.places import work_list

    archive = None if options.blind else _archive(options)
    if archive is not None:
        begin = _beginning(options, archive.paths)
        serve(options, archive.paths, begin, archive.store, archive)
        return
    paths = work_list(path.absolute() for path in options.paths)
    take = read(paths[0], options)
    if options.blind:
        _refuse_own(options, take)
    serve(options, paths, _beginning(options, paths))


def _archive(options: argparse.Namespace) -> "Archive | None":
    """Give the folder as an archive, if it is one and a batch has looked at it."""
    if len(options.paths) != 1 or not options.paths[0].is_dir():
        return None
    from markermend.review.store import Store
    from markermend_app.state.archive import find_archive

    store = Store(options.store)
    archive = find_archive(store, options.paths)
    if archive is None:
        store.close()
    return archive


def _refuse_own(options: argparse.Namespace, take: Take) -> None:
    """Refuse a second review by the one who made the first."""
    from markermend.review.store import Store, default_operator
    from markermend_app.state.compared import others

    name = options.operator or default_operator()
    with Store(options.store) as store:
        everybody = {record.operator for record in others(store, take)}
    if everybody == {name}:
        raise BadInput(
            f"{name} made the first review of this take; name the second reviewer with --operator."
        )


def _beginning(options: argparse.Namespace, paths: tuple[Path, ...]) -> "Begin | None":
    """Give what each page begins with, where it is not the first take as ever."""
    if options.operator is None and not options.blind:
        return None

    def begin(desk: "Comparing") -> None:
        if options.operator is not None:
            desk.rename(options.operator)
        if options.blind:
            desk.open_blind()
        else:
            desk.open(paths[0])

    return begin


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


def serve(
    options: argparse.Namespace,
    paths: tuple[Path, ...],
    begin: "Begin | None" = None,
    store: "Store | None" = None,
    archive: "Archive | None" = None,
) -> None:
    """Open the store, where it is not open yet, and serve these takes."""
    from markermend.review.store import Store
    from markermend_app import keys, shell
    from markermend_app.state.workspace import Workspace

    if options.keys is not None:
        keys.use(keys.read_keys(options.keys))
    store = Store(options.store) if store is None else store
    workspace = Workspace(
        store,
        paths,
        units=options.units or (archive.units if archive else None),
        rate=options.rate or (archive.rate if archive else None),
        ignore_residuals=options.ignore_residuals,
        archive=archive,
    )
    shell.serve(
        workspace,
        port=options.port,
        show=not options.no_browser,
        window=options.window,
        begin=begin,
        ready=_announce,
    )


def _announce(address: str) -> None:
    say(f"MarkerMend at {address} (Ctrl+C stops it)")
    finish()
