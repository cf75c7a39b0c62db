"""``markermend evaluate li`` and ``evaluate kamali``: the papers on the recovery of gaps."""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from markermend.model import Take
from markermend_app.cli.common import lacking, read, whole
from markermend_app.cli.experiments.shared import (
    bar,
    numbers,
    print_table,
    whole_numbers,
    words,
    work_arguments,
    write_json,
)
from markermend_app.cli.picture import picture_argument, write_picture
from markermend_app.cli.terminal import say

TREADMILLS = ("treadmill-slow", "treadmill", "treadmill-fast")


def arguments(experiments: Any) -> None:
    """Add both experiments to the sub-commands of ``evaluate``."""
    li = experiments.add_parser(
        "li", help="gaps and blackouts filled from a training set, beside methods that learn none"
    )
    li.add_argument("takes", metavar="TAKE", type=Path, nargs="+", help="takes of the same markers")
    li.add_argument(
        "--training",
        type=Path,
        nargs="+",
        default=(),
        metavar="FILE",
        help="takes to learn from (default: what is left of TAKE)",
    )
    li.add_argument("--dims", type=whole_numbers, default=(3, 2), metavar="3,2")
    li.add_argument(
        "--markers", type=whole(0, 300), default=15, metavar="N", help="in 3D; 0 takes all"
    )
    li.add_argument(
        "--pieces", type=whole(1, 10000), default=20, metavar="N", help="of 200 frames each"
    )
    li.add_argument(
        "--figures", type=words, default=(), metavar="A,B", help='only these, e.g. "Table 1"'
    )
    work_arguments(li)
    picture_argument(li)
    lacking(li)

    kamali = experiments.add_parser(
        "kamali", help="gaps in periodic gait filled by low rank and sparsity"
    )
    kamali.add_argument("takes", metavar="TAKE", type=Path, nargs="*", help="further takes")
    kamali.add_argument(
        "--scenarios",
        type=words,
        default=TREADMILLS,
        metavar="A,B",
        help=f"simulated takes (default: {', '.join(TREADMILLS)}; '' for none)",
    )
    kamali.add_argument("--markers", type=whole_numbers, default=(37, 11), metavar="N,N")
    kamali.add_argument("--methods", type=words, default=(), metavar="A,B")
    kamali.add_argument(
        "--weights", type=numbers, default=(), metavar="W,W", help="values of lambda to try"
    )
    kamali.add_argument("--masks", type=whole(1, 9999), default=20, metavar="N")
    kamali.add_argument(
        "--sweep-masks", type=whole(1, 9999), default=5, metavar="N", help="to choose lambda on"
    )
    kamali.add_argument("--cycles", type=whole(2, 1000), default=10, metavar="N", help="at most")
    kamali.add_argument(
        "--cycle", type=float, metavar="S", help="length of a cycle (default: estimated)"
    )
    work_arguments(kamali)
    picture_argument(kamali)
    lacking(kamali)


def run_li(options: argparse.Namespace) -> None:
    """Run the experiment of Li et al. and print its tables."""
    from markermend.evaluate.li import li

    result = li(
        [read(path, options) for path in options.takes],
        [read(path, options) for path in options.training],
        dims=options.dims,
        markers=options.markers,
        pieces=options.pieces,
        figures=options.figures,
        jobs=options.jobs,
        seed=options.seed,
        progress=bar("Filling"),
    )
    _show(result.tables())
    if result.projected:
        say(f"Two dimensions: {result.projected}.")
    write_json(options.json, result.to_json())
    if options.picture:
        from markermend_app.plots import completion

        source = ", ".join(path.name for path in options.takes)
        write_picture(options.picture, completion.li(result, source))


def run_kamali(options: argparse.Namespace) -> None:
    """Run the experiment of Kamali et al. and print its tables."""
    from markermend.evaluate.kamali import METHODS, WEIGHTS, kamali
    from markermend.simulate import simulate

    takes: dict[str, Take] = {name: simulate(name, options.seed) for name in options.scenarios}
    for path in options.takes:
        takes[path.name if path.name not in takes else str(path)] = read(path, options)
    result = kamali(
        takes,
        markers=options.markers,
        methods=options.methods or METHODS,
        weights=options.weights or WEIGHTS,
        masks=options.masks,
        sweep_masks=options.sweep_masks,
        cycles=options.cycles,
        cycle_s=options.cycle,
        jobs=options.jobs,
        seed=options.seed,
        progress=bar("Filling"),
    )
    _show(result.tables())
    write_json(options.json, result.to_json())
    if options.picture:
        from markermend_app.plots import gait

        write_picture(options.picture, gait.kamali(result))


def _show(tables: Sequence[tuple[str, Sequence[str], Sequence[Sequence[str]]]]) -> None:
    for title, columns, rows in tables:
        say(title)
        print_table(columns, rows)
        say("")
