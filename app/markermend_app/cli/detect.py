"""``markermend detect TAKE``: list gaps and artefacts."""

import argparse

from markermend import detection
from markermend_app.cli.common import kinds, print_json, read, take_argument


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
    take = read(options)
    found = detection.detect(take, options.detector, kinds=wanted)
    if options.json:
        print_json(
            {
                "version": 1,
                "take": options.take.name,
                "rate": take.rate,
                "n_frames": take.n_frames,
                "findings": [finding.to_json() for finding in found],
                "warnings": list(take.warnings),
            }
        )
        return
    width = max((len(f.marker) for f in found), default=6)
    print(f"{'marker':{width}}  kind   from s    to s  frames  score  {take.units:>6}")
    for f in found:
        size = "" if f.amplitude is None else f"{f.amplitude:6.1f}"
        print(
            f"{f.marker:{width}}  {f.kind:5}  {f.span.start / take.rate:6.2f}  "
            f"{f.span.stop / take.rate:6.2f}  {len(f.span):6}  {f.score:5.2f}  {size:>6}"
        )
    print(f"{len(found)} findings")
