"""``markermend detect TAKE``: list gaps and artefacts."""

import argparse

from markermend import detection
from markermend.detection.record import detection_record
from markermend_app.cli.common import json_text, kinds, read, take_argument
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
    parser.add_argument("--kinds", metavar="A,B", help="only these kinds, e.g. gap,peak")


def run(options: argparse.Namespace) -> None:
    """Print the findings, as a table or as JSON."""
    wanted = kinds(options.kinds) if options.kinds is not None else None
    detection.DETECTORS.get(options.detector)  # an unknown name is said before a long read
    take = read(options.take, options)
    found = detection.detect(take, options.detector, kinds=wanted)
    if options.json:
        put(json_text(detection_record(take, options.take.name, found)))
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
