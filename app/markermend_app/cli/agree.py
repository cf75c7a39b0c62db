"""``markermend agree DECISIONS DECISIONS…``: how far operators agree on one take."""

import argparse
import math
from pathlib import Path

from markermend import detection
from markermend.comparing import Agreement, PairAgreement, TableRow, agreement
from markermend.comparing.compared import SPAN_CLASSES
from markermend.errors import BadInput
from markermend.evaluate.matching import IOU
from markermend.model import Take
from markermend.review.decisions import Decisions, read_decisions
from markermend_app.cli.common import json_text, lacking, progress, read
from markermend_app.cli.crossed import crossed
from markermend_app.cli.review import refuse_without_the_extra, serve, serving
from markermend_app.cli.terminal import plain, put, say

SERVING = ("port", "window", "keys", "no_browser", "store")


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument(
        "decisions",
        metavar="DECISIONS",
        nargs="+",
        type=Path,
        help="two or more files of decisions on one take, as exports write them",
    )
    parser.add_argument(
        "--take",
        metavar="TAKE",
        type=Path,
        help="the take: adds differences in mm, and all markers to the samples",
    )
    lacking(parser)
    parser.add_argument(
        "--expert",
        metavar="DECISIONS",
        type=Path,
        help="the one of these files whose repairs are right: adds Table 2; needs --take",
    )
    parser.add_argument(
        "--iou",
        type=share,
        default=IOU,
        metavar="X",
        help="overlap from which two spans are about the same thing (default: %(default)s)",
    )
    parser.add_argument(
        "--detector",
        default=detection.DEFAULT,
        metavar="NAME",
        help="searches everybody's version for Table 2 (default: %(default)s)",
    )
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument(
        "--page",
        action="store_true",
        help="show the tables in the browser, and with --take adjudicate where they differ",
    )
    serving(parser)


def share(text: str) -> float:
    """Read a share above 0."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.0 < value <= 1.0:
        raise argparse.ArgumentTypeError(f"must be above 0 and at most 1; got {text!r}")
    return value


def run(options: argparse.Namespace) -> None:
    """Print the agreement, as tables or as JSON."""
    if len(options.decisions) < 2:
        raise BadInput("Agreement needs two or more files of decisions; give another one.")
    if options.expert is not None and options.take is None:
        raise BadInput("--expert needs the take that was reviewed; give it with --take.")
    detection.DETECTORS.get(options.detector)
    if options.page and options.json:
        raise BadInput("--json prints and --page shows; leave one of them out.")
    idle = [name for name in SERVING if getattr(options, name) and not options.page]
    if idle:
        raise BadInput(f"--{idle[0].replace('_', '-')} belongs to --page; leave it out.")
    files = [read_decisions(path) for path in options.decisions]
    names = _names(options.decisions, files)
    expert = None
    if options.expert is not None:
        places = [path.absolute() for path in options.decisions]
        if options.expert.absolute() not in places:
            raise BadInput(f"--expert {options.expert} is none of the files; name one of them.")
        expert = names[places.index(options.expert.absolute())]
    take = None if options.take is None else read(options.take, options)
    if options.page:
        _show(options, dict(zip(names, files, strict=True)), take, expert)
        return
    move = progress(len(files), "Repairing")
    result = agreement(
        dict(zip(names, files, strict=True)),
        take,
        iou=options.iou,
        expert=expert,
        detector=options.detector,
        progress=lambda done, total: move(done),
    )
    if options.json:
        put(json_text(result.to_json()))
    else:
        _print(result)


def _show(
    options: argparse.Namespace,
    reviews: dict[str, Decisions],
    take: Take | None,
    expert: str | None,
) -> None:
    refuse_without_the_extra()
    for decisions in reviews.values():
        if take is not None:
            decisions.wishes(take)  # refuses another take here and not on the page
    from markermend_app.state.compared import Material

    material = Material(reviews, take, options.iou, options.detector)
    paths = () if options.take is None else (options.take.absolute(),)
    serve(options, paths, lambda desk: desk.show_agreement(material, expert))


def _names(paths: list[Path], files: list[Decisions]) -> list[str]:
    """Name everybody by the operator in the file where that is one and tells them apart."""
    names = []
    for path, decisions in zip(paths, files, strict=True):
        operators = {decided.operator for decided in decisions.findings if decided.operator}
        names.append(operators.pop() if len(operators) == 1 else path.name)
    if len(set(names)) < len(names):
        names = [path.name for path in paths]
    if len(set(names)) < len(names):
        names = [str(path) for path in paths]
    if len(set(names)) < len(names):
        raise BadInput("The same file was given twice; give reviews of different people.")
    return names


def _print(result: Agreement) -> None:
    for pair in result.pairs:
        _print_pair(pair)
    if len(result.names) > 2:
        say(f"all {len(result.names)}:")
    say(
        f"  Krippendorff's alpha  {_number(result.alpha_samples)} over samples, "
        f"{_number(result.alpha_spans)} over spans"
    )
    differ = [thing for thing in result.things if not thing.agreed]
    say(f"  {len(result.things)} things judged, {len(differ)} differently")
    for thing in differ:
        words = ", ".join(word or "open" for word in thing.said)
        away = "" if thing.apart_mm is None else f"  {thing.apart_mm:.1f} mm apart"
        say(f"    {plain(thing.marker)} {thing.span.start}-{thing.span.stop}: {words}{away}")
    if result.table2 is None:
        say("own verdicts on what the detector showed:")
        _print_table(result.own)
    else:
        say("the detector on everybody's version, held against the expert's:")
        _print_table(result.table2)


def _print_pair(pair: PairAgreement) -> None:
    say(f"{pair.names[0]} and {pair.names[1]}:")
    both = "" if pair.found_by_both is None else f" ({pair.found_by_both:.0%} of all)"
    edges = "" if pair.iou is None else f", edges agree to {pair.iou:.0%}"
    say(
        f"  accepted {pair.accepted[0]} and {pair.accepted[1]}; both {pair.both}{both}, "
        f"{pair.same_kind} as the same kind{edges}"
    )
    say(
        f"  Cohen's kappa         {_number(pair.kappa_samples)} over samples, "
        f"{_number(pair.kappa_spans)} over spans"
    )
    say(f"  things by class, {pair.names[0]} down, {pair.names[1]} across:")
    for line in crossed(SPAN_CLASSES, SPAN_CLASSES, pair.spans):
        say(f"    {line}")
    apart = pair.difference
    if apart is not None and apart.mean_mm is not None and apart.where is not None:
        marker, frame = apart.where
        say(
            f"  repaired trajectories {apart.mean_mm:.2f} mm apart over {apart.samples} samples, "
            f"at most {apart.largest_mm:.1f} mm ({plain(marker)} at frame {frame}); "
            f"{apart.only_one} filled by one alone"
        )


def _print_table(rows: tuple[TableRow, ...]) -> None:
    width = max(8, *(len(plain(row.operator)) for row in rows))
    say(f"  {'operator':{width}}  human  algorithm  approved  rejected  missed")
    for row in rows:
        say(
            f"  {plain(row.operator):{width}}  {row.human:5}  {row.algorithm:9}  "
            f"{row.approved:8}  {row.rejected:8}  {row.missed:6}"
        )


def _number(value: float | None) -> str:
    return "  - " if value is None else f"{value:.3f}"
