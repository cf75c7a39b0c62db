"""``markermend info TAKE``: what a take holds."""

import argparse
from typing import Any

from markermend import io
from markermend.model import Take, runs
from markermend_app.cli.common import json_text, take_argument, warn
from markermend_app.cli.terminal import put, say


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    take_argument(parser)
    parser.add_argument("--json", action="store_true", help="print JSON")


def run(options: argparse.Namespace) -> None:
    """Print size, rate, unit and gaps; what the file does not say is null and no error."""
    contents = io.open_contents(options.take, ignore_residuals=options.ignore_residuals)
    units, rate = options.units or contents.units, options.rate or contents.rate
    # Gaps need neither unit nor rate; anything stands in for what is lacking.
    stand_in = "mm" if contents.positions.shape[2] == 3 else "px"
    take = contents.take(units=units or stand_in, rate=rate or 1.0)
    warnings = [*take.warnings]
    if units is None:
        warnings.append("The file does not say its unit; give it with --units mm|cm|m.")
    if rate is None:
        warnings.append("The file does not say its rate; give it with --rate HZ.")
    record: dict[str, Any] = {
        "n_frames": take.n_frames,
        "n_markers": len(take.measured),
        "n_points": take.n_markers,
        "rate": rate,
        "units": units,
        "labels": [take.labels[m] for m in take.measured],
        "gaps": _gaps(take),
        "warnings": warnings,
    }
    warn(warnings)
    if options.json:
        put(json_text(record))
        return
    inner = [gap for gap in record["gaps"] if gap["inner"]]
    longest = max((gap["stop"] - gap["start"] for gap in inner), default=0)
    never = sum(1 for gap in record["gaps"] if gap["stop"] - gap["start"] == take.n_frames)
    missing = 1 - take.seen[:, take.measured].mean() if take.measured.size else 0.0
    say(options.take.name)
    say(f"  frames   {take.n_frames}" + (f" ({take.duration_s:.2f} s)" if rate else ""))
    say(f"  markers  {len(take.measured)} of {take.n_markers} points")
    say(f"  rate     {f'{rate:g} Hz' if rate else 'not said'}")
    say(f"  units    {units or 'not said'}")
    say(f"  missing  {100 * missing:.2f} %")
    say(f"  gaps     {len(inner)} inner, the longest {longest} frames; {never} markers never seen")


def _gaps(take: Take) -> list[dict[str, Any]]:
    return [
        {
            "marker": take.labels[m],
            "start": span.start,
            "stop": span.stop,
            "inner": span.start > 0 and span.stop < take.n_frames,
        }
        for m in take.measured
        for span in runs(~take.seen[:, m])
    ]
