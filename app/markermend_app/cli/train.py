"""``markermend train``: an exercise with known truth, its grade, and what becomes of it over time.

The truth goes into the store of reviews and into no other file. Without --out, --grade, --report
and --group, the exercise is done here and now, in the browser.
"""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from tqdm import tqdm

from markermend import io
from markermend.errors import BadInput, CannotWrite
from markermend.io.disk import refuse_existing, write_whole
from markermend.model import Take
from markermend.review.decisions import read_decisions
from markermend.review.session import ReviewSession
from markermend.review.store import Store, default_operator
from markermend.train import (
    COLUMNS,
    FAST,
    LEVELS,
    ROWS,
    Grade,
    Request,
    archive,
    grade,
    group_table,
    next_exercise,
    prepare,
    report,
)
from markermend_app.cli.common import json_text, kinds, lacking, read, whole
from markermend_app.cli.crossed import crossed
from markermend_app.cli.review import refuse_without_the_extra, serve, serving
from markermend_app.cli.terminal import plain, put, say

if TYPE_CHECKING:
    from markermend_app.state.second_review import Comparing


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument(
        "take",
        metavar="TAKE",
        nargs="?",
        type=Path,
        help="a take without artefacts to put some into (default: a simulated person); with "
        "--grade, where the exercise lies now",
    )
    lacking(parser)
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--out", metavar="DIR", type=Path, help="write an exercise into this folder")
    what.add_argument(
        "--grade",
        metavar="DECISIONS",
        nargs="?",
        const="",
        help="grade this file of decisions; without a file, the review of TAKE in the store",
    )
    what.add_argument("--report", metavar="FILE.html", type=Path, help="write a trainee's report")
    what.add_argument("--group", action="store_true", help="say where every trainee stands")
    levels = "; ".join(f"{level.number} {level.title.lower()}" for level in LEVELS)
    parser.add_argument(
        "--level",
        type=whole(1, len(LEVELS)),
        metavar="N",
        help=f"{levels} (default: what the trainee needs next)",
    )
    parser.add_argument(
        "--seed", type=whole(0, 2**32 - 1), metavar="S", help="default: another one each time"
    )
    parser.add_argument("--kinds", metavar="A,B", help="only these, e.g. step,slow")
    parser.add_argument("--amplitude", type=float, metavar="MM", help="mean size")
    parser.add_argument("--density", type=float, metavar="N", help="artefacts a minute")
    parser.add_argument(
        "--hidden", action="store_true", help="the trainee finds everything without a detector"
    )
    parser.add_argument(
        "--expert",
        metavar="DECISIONS",
        type=Path,
        help="an expert's decisions on TAKE are the truth; nothing is put in",
    )
    parser.add_argument(
        "--quick", action="store_true", help="grade without comparing repairs with other methods"
    )
    parser.add_argument(
        "--trainee",
        "--operator",
        dest="trainee",
        metavar="NAME",
        help="default: MARKERMEND_OPERATOR, or you",
    )
    serving(parser)
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument("--force", action="store_true", help="replace a file that is there")


def run(options: argparse.Namespace) -> None:
    """Do one of the five things."""
    _refuse_idle(options)
    if options.out is not None:
        _hand_out(options)
    elif options.grade is not None:
        _grade(options)
    elif options.report is not None:
        _report(options)
    elif options.group:
        _group(options)
    else:
        _practise(options)


def _refuse_idle(options: argparse.Namespace) -> None:
    """Refuse options that would do nothing."""
    making = ("level", "seed", "kinds", "amplitude", "density", "expert")
    given = [name for name in making if getattr(options, name) is not None]
    given += ["hidden"] if options.hidden else []
    makes = options.out is not None or not (
        options.grade is not None or options.report or options.group
    )
    if not makes and given:
        raise BadInput(f"--{given[0]} belongs to an exercise that is made; leave it out.")
    if makes and options.out is None:
        idle = [name for name in ("json", "force") if getattr(options, name)]
        if idle:
            raise BadInput(f"--{idle[0]} belongs to what prints or writes; leave it out.")
    else:
        idle = [name for name in ("port", "window", "keys", "no_browser") if getattr(options, name)]
        if idle:
            raise BadInput(
                f"--{idle[0].replace('_', '-')} belongs to practice in the browser; leave it out."
            )
    if options.quick and options.grade is None:
        raise BadInput("--quick belongs to --grade; leave it out.")
    if options.take is not None and not makes and options.grade is None:
        raise BadInput("A report needs no take; leave it out.")
    if options.expert is None:
        return
    if options.take is None:
        raise BadInput("--expert needs the take that the expert reviewed; give it.")
    if unused := [name for name in given if name not in ("expert", "hidden")]:
        raise BadInput(f"With --expert nothing is put in; leave out --{unused[0]}.")


def _hand_out(options: argparse.Namespace) -> None:
    if not options.out.is_dir():
        raise CannotWrite(f"There is no folder {options.out}; make it, or name another.")
    request = _request(options)
    with Store(options.store) as store:
        made, why = prepare(request, archive.results(store, _trainee(options)))
        if options.take is not None and made.level == 0:
            name = f"exercise-{options.take.stem}.c3d"
        else:
            name = f"exercise-{made.level}-{made.seed}.c3d"
        path = options.out / name
        number, handed = archive.hand_out(store, made, path, overwrite=options.force)
    if options.json:
        put(json_text({"version": 1, "exercise": number, "file": str(path), **handed.to_json()}))
        return
    say(f"{path}: exercise {number}, level {made.level}, seed {made.seed}. {why}".rstrip())
    say(f"Review it with: markermend review {path}")
    say(f"Then grade it with: markermend train {path} --grade")


def _request(options: argparse.Namespace) -> Request:
    wanted = None if options.kinds is None else kinds(options.kinds)
    take = None if options.take is None else read(options.take, options)
    expert = None
    if options.expert is not None and take is not None:
        decisions = read_decisions(options.expert)
        decisions.wishes(take)  # refuses what was decided on another take
        expert = decisions.review
    return Request(
        take, options.level, options.seed, wanted, options.amplitude, options.density,
        options.hidden, expert,
    )  # fmt: skip


def _practise(options: argparse.Namespace) -> None:
    """Do the exercise in the browser; a page that is loaded again goes on with it."""
    refuse_without_the_extra()
    request = _request(options)
    from markermend_app.state.training import Trainer

    store = Store(options.store)
    made = prepare(request, archive.results(store, _trainee(options)))
    trainer = Trainer(store, request, made)

    def begin(desk: "Comparing") -> None:
        desk.rename(_trainee(options))
        desk.trainer = trainer
        desk.practise()

    serve(options, (), begin, store)


def _trainee(options: argparse.Namespace) -> str:
    return str(options.trainee or default_operator())


def _grade(options: argparse.Namespace) -> None:
    with Store(options.store) as store:
        if options.grade:
            decisions = read_decisions(options.grade)
            take = _handed_out(options, store, decisions.sha256)
            decisions.wishes(take)
            review, decided = decisions.review, decisions.decided
            names = {step.operator for step in decided.values() if step.operator}
            trainee = options.trainee or (names.pop() if len(names) == 1 else default_operator())
        elif options.take is None:
            raise BadInput("--grade needs a file of decisions, or the exercise as TAKE; give one.")
        else:
            take, trainee = read(options.take, options), _trainee(options)
            known = [r for r in store.reviews(take.content_hash) if r.operator == trainee]
            if not known:
                raise BadInput(
                    f"{trainee} has not reviewed {options.take} in the store {store.where}; "
                    "review it first, or give --trainee."
                )
            session = ReviewSession(store, known[0])
            review, decided = session.review, session.decided
        number = archive.find(store, take.content_hash)
        exercise = archive.unseal(store, number, take)
        result = grade(
            exercise,
            review,
            decided=decided,
            methods=() if options.quick else FAST,
            progress=_progress("Grading"),
        )
        archive.record(store, number, result, trainee)
        upcoming = next_exercise(archive.results(store, trainee))
    if options.json:
        put(json_text({**result.to_json(), "exercise": number, "trainee": trainee}))
        return
    _print(result, take)
    say(f"Next: level {upcoming.level}, {', '.join(upcoming.kinds)}. {upcoming.why}")


def _handed_out(options: argparse.Namespace, store: Store, sha256: str) -> Take:
    """Read the file of an exercise: the one named, else where it was last seen."""
    if options.take is not None:
        return read(options.take, options)
    archive.find(store, sha256)  # says so where there is no such exercise
    known = store.take(sha256)
    if known is None or known.path is None or not known.path.exists():
        raise BadInput("The exercise is no longer where it was; give its file as TAKE.")
    return io.read(known.path)


def _progress(what: str) -> Callable[[int, int], None]:
    bar = tqdm(desc=what, disable=None, leave=False)

    def move(done: int, total: int) -> None:
        bar.total = total
        bar.update(done - bar.n)
        if done >= total:
            bar.close()

    return move


def _print(result: Grade, take: Take) -> None:
    say(result.verdict)
    if result.seconds_per_finding is not None:
        say(f"{result.seconds_per_finding:.0f} s between two decisions.")
    say("kind    found  right  of  invented or misnamed     MCC  edges  error mm   best  advised")
    for kind, score in result.kinds.items():
        numbers = (
            f"{_number(score.mcc, 6, 2)}  {_number(score.iou, 5, 2)}  "
            f"{_number(score.error_mm, 8, 1)}  {_number(score.best_mm, 5, 1)}  "
            f"{_number(score.recommended_mm, 7, 1)}"
        )
        say(
            f"{kind:6}  {score.found:5}  {score.right:5}  {score.true:2}  "
            f"{f'{score.wrong} of {score.called}':>20}  {numbers}"
        )
    say("what it was, down, and what it was called, across:")
    for line in crossed(ROWS, COLUMNS, result.matrix):
        say(f"  {line}")
    for mark in result.marks:
        say(
            f"{mark.outcome:13} {plain(mark.marker)} {mark.kind} at "
            f"{mark.span.start / take.rate:.2f} s: {mark.why}"
        )
    for reason in result.refused:
        say(f"A repair was refused: {reason}")


def _number(value: float | None, width: int, digits: int) -> str:
    return f"{'-':>{width}}" if value is None else f"{value:{width}.{digits}f}"


def _report(options: argparse.Namespace) -> None:
    refuse_existing(options.report, overwrite=options.force)
    trainee = _trainee(options)
    with Store(options.store) as store:
        found = archive.results(store, trainee)
    if not found:
        raise BadInput(f"No exercise of {trainee} was graded yet; name another with --trainee.")
    write_whole(options.report, report(found).encode("utf-8"), overwrite=options.force)
    say(f"{options.report}: {len(found)} exercises of {trainee}")


def _group(options: argparse.Namespace) -> None:
    with Store(options.store) as store:
        found = archive.results(store, options.trainee)
    table = group_table(found)
    if options.json:
        put(json_text({"version": 1, "trainees": [one.to_json() for one in table]}))
        return
    width = max((len(plain(one.trainee)) for one in table), default=7)
    say(f"{'trainee':{width}}  exercises  level  left worse  next")
    for one in table:
        found_words = ", ".join(f"{k} {s.right}/{s.of}" for k, s in one.found.items())
        say(
            f"{plain(one.trainee):{width}}  {one.exercises:9}  {one.level:5}  "
            f"{f'{one.worse.right} of {one.worse.of}':>10}  {one.upcoming.why} ({found_words})"
        )
    say(f"{len(table)} trainees")
