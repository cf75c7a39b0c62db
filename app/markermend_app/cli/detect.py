"""``markermend detect TAKE``: list gaps and artefacts."""

import argparse
from typing import Any

from markermend import detection
from markermend.model import Finding
from markermend_app.cli.common import json_text, kinds, read, take_argument
from markermend_app.cli.terminal import plain, put, say

FIELDS = ("id", "marker", "start", "stop", "kind", "score", "axes", "amplitude")
"""What stands of each finding in the JSON; other programs rely on it."""
WHERE_KNOWN = ("partner", "group")
"""What stands there too where it is known: the other marker of a swap, findings that combine."""


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
        record = {
            "version": 1,
            "take": options.take.name,
            "rate": take.rate,
            "n_frames": take.n_frames,
            "findings": [_record(finding) for finding in found],
            "warnings": list(take.warnings),
        }
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


def _record(finding: Finding) -> dict[str, Any]:
    whole = finding.to_json()
    return {name: whole[name] for name in (*FIELDS, *WHERE_KNOWN) if name in whole}
