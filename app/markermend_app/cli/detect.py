"""``markermend detect TAKE``: list gaps and artefacts."""

import argparse
from dataclasses import asdict

from markermend import detection
from markermend.detection.record import detection_record
from markermend_app.cli.common import json_text, kinds, read, take_argument
from markermend_app.cli.experiments.shared import bar
from markermend_app.cli.recipe import recipe_arguments, recipe_asked_for
from markermend_app.cli.terminal import plain, put, say


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    take_argument(parser)
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument(
        "--detector",
        default=detection.DEFAULT,
        metavar="NAME",
        help=f"one of {', '.join(detection.DETECTORS.names())} (default: %(default)s)",
    )
    parser.add_argument(
        "--reach",
        action="store_true",
        help="also how small a slow change may be and still be found, marker by marker",
    )
    parser.add_argument("--kinds", metavar="A,B", help="only these kinds, e.g. gap,peak")
    recipe_arguments(parser)


def run(options: argparse.Namespace) -> None:
    """Print the findings, as a table or as JSON."""
    wanted = kinds(options.kinds) if options.kinds is not None else None
    detection.DETECTORS.get(options.detector)  # an unknown name is said before a long read
    recipe = recipe_asked_for(options)
    take = read(options.take, options)
    if recipe is None:
        found = detection.detect(take, options.detector, kinds=wanted, progress=bar("Detecting"))
    else:
        everything = recipe.detect(take, bar("Detecting"))
        found = tuple(f for f in everything if wanted is None or f.kind in wanted)
    reach: tuple[detection.Reach, ...] = ()
    if options.reach:
        reach = detection.smallest_slow_changes(take, progress=bar("Looking how small"))
    if options.json:
        record = detection_record(take, options.take.name, found)
        if options.reach:
            record["reach"] = [asdict(row) for row in reach]
        put(json_text(record))
        return
    width = max((len(plain(f.marker)) for f in found), default=6)
    say(f"{'marker':{width}}  kind   from s    to s  frames  score  {take.units:>6}")
    for f in found:
        size = "" if f.amplitude is None else f"{f.amplitude:6.1f}"
        say(
            f"{plain(f.marker):{width}}  {f.kind:5}  {f.span.start / take.rate:6.2f}  "
            f"{f.span.stop / take.rate:6.2f}  {len(f.span):6}  {f.score:5.2f}  {size:>6}"
        )
    say(f"{len(found)} findings")
    for row in reach:
        say(
            f"{plain(row.marker):{width}}  a slow change is seen from {row.usual_mm:.1f} "
            f"{take.units}, where hard to predict from {row.fast_mm:.1f} {take.units}"
        )
