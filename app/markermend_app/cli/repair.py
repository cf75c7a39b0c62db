"""``markermend repair TAKE -o OUT``: repair and write back, nothing else changed."""

import argparse
import os
from pathlib import Path
from typing import Any

from markermend import detection, repairing
from markermend.errors import BadInput, CannotWrite
from markermend.io import Written
from markermend.io.disk import refuse_existing, write_whole
from markermend.model import Finding, Take
from markermend.review import Review
from markermend.review.decisions import read_decisions
from markermend.review.mending import Mended, accepted_all, decisions_path, mend, save
from markermend_app.cli.common import json_text, kinds, progress, read, take_argument, warn
from markermend_app.cli.terminal import say


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    take_argument(parser)
    parser.add_argument("-o", "--out", metavar="OUT", type=Path, required=True, help="new file")
    parser.add_argument(
        "--method",
        default="",
        metavar="NAME",
        help=f"one of {', '.join(repairing.REPAIRS.names())} (default: by kind)",
    )
    parser.add_argument(
        "--kinds", metavar="A,B", help="what to repair (default: gap); others are detected first"
    )
    parser.add_argument(
        "--decisions", metavar="FILE", type=Path, help="repair what was accepted in this file"
    )
    parser.add_argument("--report", metavar="FILE.json", type=Path, help="write what was done")
    parser.add_argument("--force", action="store_true", help="replace OUT if it is there")


def run(options: argparse.Namespace) -> None:
    """Repair inner gaps of measured markers, and whatever else was named or accepted."""
    if options.decisions is not None and (options.kinds is not None or options.method):
        raise BadInput("--decisions says what is repaired and how; leave out --kinds and --method.")
    wanted = kinds(options.kinds) if options.kinds is not None else ("gap",)
    if options.method:
        repairing.REPAIRS.get(options.method)
    _refuse_targets(options)
    decisions = None if options.decisions is None else read_decisions(options.decisions)
    take = read(options.take, options)
    stays: list[dict[str, Any]] = []
    if decisions is not None:
        decisions.wishes(take)  # refuses what was decided on another take
        review = decisions.review
    else:
        review, stays = _review(take, wanted, options.method)
    wishes = review.accepted()
    mended = mend(take, wishes, progress=progress(len(wishes), "Repairing"))
    stays += [
        {
            "marker": r.wish.marker,
            "start": r.wish.span.start,
            "stop": r.wish.span.stop,
            "kind": r.wish.kind,
            "reason": r.reason,
        }
        for r in mended.refusals
    ]
    decided = None if decisions is None else decisions.decided
    written, beside = save(mended, review, options.out, decided=decided, overwrite=options.force)
    warn(f"{s['marker']} {s['start']}-{s['stop']} stays: {s['reason']}" for s in stays)
    told = [written.why] if written.why else []
    warn(told)
    if options.report is not None:
        record = _record(options, take, mended, written, stays)
        record["warnings"] = [*take.warnings, *told]
        write_whole(options.report, json_text(record).encode("ascii"), overwrite=True)
    say(
        f"{options.out}: {len(mended.repairs)} spans repaired, {written.n_changed} samples "
        f"changed, {len(stays)} spans stay ({written.mode}); decisions in {beside.name}"
    )


def _refuse_targets(options: argparse.Namespace) -> None:
    """Refuse files that must not be written, before any work is done.

    Raises
    ------
    CannotWrite
        If two of the files are one, or a report would replace what is no report.
    """
    beside = decisions_path(options.out)
    read_ones = [("the source", options.take), ("the file of decisions", options.decisions)]
    for path in (options.out, options.report):
        for what, other in read_ones:
            if path is not None and other is not None and _one_file(path, other):
                raise CannotWrite(
                    f"{path} is {what}, which is never overwritten; choose another name."
                )
    if _one_file(beside, options.take):
        raise CannotWrite(
            f"{options.take} would be overwritten by the decisions beside {options.out}; choose "
            "another name."
        )
    for path in (options.out, beside):
        _refuse_existing(path, options.force)
    if options.report is None:
        return
    for other in (options.out, beside):
        if _one_file(options.report, other):
            raise CannotWrite(f"{options.report} is written already; give the report its own name.")
    # An earlier report may be replaced; a recording that was named by mistake may not.
    is_report = options.report.suffix.lower() == ".json"
    _refuse_existing(options.report, options.force or is_report)
    if not options.report.parent.is_dir():
        raise CannotWrite(
            f"The report {options.report} cannot be written: there is no such folder; make it."
        )


def _refuse_existing(path: Path, force: bool) -> None:
    refuse_existing(path, overwrite=True)  # what can never be replaced
    if path.exists() and not force:
        raise CannotWrite(f"{path} exists; choose another name or add --force.")


def _one_file(one: Path, other: Path) -> bool:
    """Whether two paths lead to one file, also by links; or would, once it is written."""
    try:
        return one.samefile(other)
    except OSError:
        return one.absolute() == other.absolute() or os.path.realpath(one) == os.path.realpath(
            other
        )


def _review(
    take: Take, wanted: tuple[str, ...], method: str
) -> tuple[Review, list[dict[str, Any]]]:
    """Accept everything of the kinds wanted; gaps at the ends and the like stay, with reasons."""
    stays = [] if "gap" not in wanted else _staying(take)
    found: list[Finding] = []
    if set(wanted) - {"gap"}:
        found = [f for f in detection.detect(take, kinds=wanted) if f.kind != "gap"]
    if "gap" in wanted:
        found += [
            f for f in detection.gaps(take) if f.span.start > 0 and f.span.stop < take.n_frames
        ]
    return accepted_all(found, method), stays


def _staying(take: Take) -> list[dict[str, Any]]:
    """List the gaps that are not filled, with the reason."""
    why = {
        "unlabelled": "an unlabelled trajectory is not filled",
        "model": "a model computed it; run the model again on the repaired markers",
    }
    listed = []
    for m, label in enumerate(take.labels):
        for span, inner in take.gaps(m):
            if len(span) == take.n_frames:
                reason = why.get(take.roles[m], "the marker is never seen")
            elif take.roles[m] != "measured":
                reason = why[take.roles[m]]
            elif not inner:
                end = "beginning" if span.start == 0 else "end"
                reason = f"a gap at the {end} of the take is not filled"
            else:
                continue
            listed.append(
                {
                    "marker": label,
                    "start": span.start,
                    "stop": span.stop,
                    "kind": "gap",
                    "reason": reason,
                }
            )
    return listed


def _record(
    options: argparse.Namespace,
    take: Take,
    mended: Mended,
    written: Written,
    stays: list[dict[str, Any]],
) -> dict[str, Any]:
    return {
        "version": 1,
        "take": options.take.name,
        "out": str(options.out),
        "rate": take.rate,
        "n_frames": take.n_frames,
        "repaired": [
            {
                "marker": done.marker,
                "start": done.span.start,
                "stop": done.span.stop,
                "method": done.method,
                "parameters": dict(done.parameters),
                "expected_mm": done.expected_mm,
                "note": done.note,
            }
            for done in mended.repairs
        ],
        "stays": stays,
        "written": written.to_json(),
    }
