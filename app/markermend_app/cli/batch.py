"""``markermend batch FOLDER``: detection, and repair by an explicit policy, over an archive."""

import argparse
import os
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from tqdm import tqdm

from markermend import detection
from markermend.batch.hand import TIME_LIMIT_S
from markermend.batch.policy import read_policy
from markermend.batch.settings import Settings
from markermend.errors import BadInput
from markermend.io.disk import write_whole
from markermend.io.jsontext import json_text
from markermend.model import KINDS
from markermend_app.cli.common import kinds, lacking, positive, warn, whole
from markermend_app.cli.recipe import recipe_arguments, recipe_asked_for
from markermend_app.cli.terminal import put, say

PAGE = "summary.html"
MOST_SAID = 20


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument(
        "folder", metavar="FOLDER", type=Path, help="an archive; folders in it are entered"
    )
    lacking(parser)
    parser.add_argument(
        "--jobs",
        type=whole(1, 1024),
        metavar="N",
        help="takes that are worked on at once (default: one per core)",
    )
    parser.add_argument(
        "--dask",
        metavar="ADDRESS",
        help="use the Dask cluster with this scheduler instead, e.g. tcp://host:8786",
    )
    parser.add_argument(
        "--repair",
        metavar="POLICY",
        help="repair too: kinds, e.g. gap,peak, or a policy file.json, or with --recipe the word "
        "recipe (default: nothing)",
    )
    parser.add_argument(
        "--most-mm",
        type=positive("mm"),
        metavar="MM",
        help="with --repair: make no repair that is expected to be further off",
    )
    parser.add_argument(
        "--out",
        metavar="DIR",
        type=Path,
        help=f"where findings, repaired takes, summary.json and {PAGE} go",
    )
    recipe_arguments(parser, "where results are kept")
    parser.add_argument(
        "--detector",
        default=detection.DEFAULT,
        metavar="NAME",
        help=f"one of {', '.join(detection.DETECTORS.names())} (default: %(default)s)",
    )
    parser.add_argument("--kinds", metavar="A,B", help="only these kinds, e.g. gap,peak")
    parser.add_argument(
        "--time-limit",
        type=positive("s"),
        default=TIME_LIMIT_S,
        metavar="S",
        help="a take that takes longer has failed (default: %(default)g)",
    )
    parser.add_argument("--json", action="store_true", help="print the summary as JSON")


def run(options: argparse.Namespace) -> int:
    """Run the batch; exit code 1 if a take failed."""
    if options.most_mm is not None and options.repair is None:
        raise BadInput("--most-mm limits repairs; say with --repair what is repaired.")
    if options.dask is not None and options.jobs is not None:
        raise BadInput("--jobs is for this machine, --dask for a cluster; leave one of them out.")
    wanted = KINDS if options.kinds is None else kinds(options.kinds)
    recipe = recipe_asked_for(options)
    by_recipe = recipe is not None and options.repair == "recipe"
    if by_recipe and options.most_mm is not None:
        raise BadInput("The recipe has limits of its own; leave out --most-mm, or give a policy.")
    settings = replace(
        Settings(options.detector) if recipe is None else recipe.settings(repair=by_recipe),
        units=options.units,
        rate=options.rate,
        ignore_residuals=options.ignore_residuals,
    )
    if recipe is None or options.kinds is not None:
        settings = replace(settings, kinds=tuple(kind for kind in KINDS if kind in wanted))
    if options.repair is not None and not by_recipe:
        settings = replace(settings, policy=read_policy(options.repair, options.most_mm))
    from markermend.batch.overview import overview
    from markermend.batch.run import run as run_batch
    from markermend.review.store import Store
    from markermend_app.plots.archive_page import archive_page

    with Store(options.store) as store, _Bar() as bar:
        outcome = run_batch(
            options.folder,
            settings,
            store,
            out=options.out,
            jobs=options.jobs or _cores(),
            dask=options.dask,
            limit_s=options.time_limit,
            progress=bar.move,
        )
        if options.out is not None:
            seen = overview(store, options.folder)
            assert seen is not None
            page = archive_page(seen).encode("utf-8", "replace")
            write_whole(options.out / PAGE, page, overwrite=True)
    record = outcome.to_json()
    if options.json:
        put(json_text(record))
    for word in ("failed", "refused"):
        _warn(word, record[word])
    where = "" if options.out is None else f"; see {options.out}"
    if not options.json:
        say(
            f"{len(outcome.lines)} takes: {len(record['done'])} done"
            f"{f' ({outcome.resumed} of them before)' if outcome.resumed else ''}, "
            f"{len(record['refused'])} refused, {len(record['failed'])} failed{where}"
        )
    return 1 if record["failed"] else 0


def _warn(word: str, entries: Sequence[dict[str, str]]) -> None:
    for entry in entries[:MOST_SAID]:
        reason = entry["reason"].removeprefix(f"{Path(entry['take']).name}: ")
        warn([f"{entry['take']} {word}: {reason}"])
    if len(entries) > MOST_SAID:
        warn([f"{len(entries) - MOST_SAID} more were {word}; the summary names them all."])


def _cores() -> int:
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # only Linux says which of them we may use
        return os.cpu_count() or 1


class _Bar:
    """A progress bar on a terminal, and nothing elsewhere; it appears once the total is known."""

    def __init__(self) -> None:
        self._bar: tqdm | None = None

    def __enter__(self) -> "_Bar":
        return self

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.close()

    def move(self, done: int, total: int) -> None:
        """Show how many takes are through."""
        if self._bar is None:
            self._bar = tqdm(
                total=total,
                initial=done,
                desc="Takes",
                unit="take",
                disable=not sys.stderr.isatty(),
            )
        self._bar.update(done - self._bar.n)
