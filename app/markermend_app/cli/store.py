"""``markermend store``: look after the store of reviews."""

import argparse
import sys
from pathlib import Path

from tqdm import tqdm

from markermend.errors import StoreError
from markermend_app.cli.common import warn
from markermend_app.cli.terminal import say


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    what = parser.add_subparsers(dest="what", metavar="WHAT", required=True)
    check = what.add_parser("check", help="read everything, and say whether it is whole")
    backup = what.add_parser("backup", help="copy the store while it is in use")
    backup.add_argument("file", metavar="FILE", type=Path, help="the copy; replaced if it is there")
    restore = what.add_parser("restore", help="go back to a backup; what was there is kept")
    restore.add_argument("file", metavar="FILE", type=Path, help="a backup")
    for one in (check, backup, restore):
        one.add_argument(
            "--store",
            metavar="PATH",
            help="the store (default: MARKERMEND_STORE, else in your data folder)",
        )


def run(options: argparse.Namespace) -> None:
    """Check, copy or restore."""
    if options.what == "restore":
        _restore(options)
        return
    from markermend.review.store import Store

    with Store(options.store) as store:
        if options.what == "backup":
            store.backup(options.file)
            say(f"{options.file}: a copy of {store.where}")
            return
        from markermend.review.upkeep import check

        with tqdm(desc="Reviews", disable=not sys.stderr.isatty(), leave=False) as bar:

            def move(done: int, total: int) -> None:
                bar.total = total
                bar.update(done - bar.n)

            health = check(store, move)
        say(
            f"{store.where}: {health.n_takes} takes, {health.n_reviews} reviews, "
            f"{health.n_lines} lines of journal, schema {health.schema}"
        )
        if health.faults:
            warn(health.faults)
            raise StoreError(
                f"The store {store.where} is not whole; go back to a backup with "
                "markermend store restore FILE."
            )
        say("All of it can be read.")


def _restore(options: argparse.Namespace) -> None:
    from markermend.review.database import locate, shown
    from markermend.review.upkeep import restore

    kept = restore(options.file, options.store)
    say(f"{shown(locate(options.store))} is as {options.file} was.")
    if kept is not None:
        say(f"What was there until now is in {kept}.")
