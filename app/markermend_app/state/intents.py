"""What may be asked of a desk, by name: buttons and keys say nothing else."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from markermend.model import KINDS, Kind
from markermend_app.state.curves import is_relative
from markermend_app.state.desk import SIGNALS, VIEWS, Desk
from markermend_app.state.exercise_intents import EXERCISE_INTENTIONS, WITH_EXERCISE_DIALOG
from markermend_app.state.people import Right
from markermend_app.state.queueing import FILTERS
from markermend_app.state.together import TEAM_INTENTIONS

Fields = Mapping[str, Any]
LEAST_FACTOR, MOST_FACTOR = 0.5, 4.0
Intention = Callable[[Desk, Any, Fields], None]


def _reclassify(kind: Kind) -> Intention:
    return lambda desk, arg, fields: desk.reclassify(kind)


def _toggle(name: str) -> Intention:
    return lambda desk, arg, fields: setattr(desk, name, not getattr(desk, name))


def _theme(desk: Desk, _: Any, __: Fields) -> None:
    desk.theme = "light" if desk.theme == "dark" else "dark"


def _prefer_dark(desk: Desk, _: Any, __: Fields) -> None:
    desk.theme = "dark"


def _view(desk: Desk, arg: Any, _: Fields) -> None:
    if arg in VIEWS:
        desk.view = arg


def _view_next(desk: Desk, _: Any, __: Fields) -> None:
    at = VIEWS.index(desk.view) if desk.view in VIEWS else -1
    desk.view = VIEWS[(at + 1) % len(VIEWS)]


def _speed(desk: Desk, arg: Any, _: Fields) -> None:
    desk.speed = min(4.0, max(0.1, float(arg)))


def _filter(desk: Desk, arg: Any, _: Fields) -> None:
    if arg in KINDS:
        desk.toggle_kind(arg)


def _text(desk: Desk, arg: Any, _: Fields) -> None:
    desk.text = str(arg or "")[:80]


def _verdict(desk: Desk, arg: Any, _: Fields) -> None:
    desk.verdict = str(arg) if arg in FILTERS else ""


def _by(desk: Desk, arg: Any, _: Fields) -> None:
    desk.by = str(arg) if arg in desk.authors else ""


def _bones(desk: Desk, _: Any, __: Fields) -> None:
    """Draw bones by the labels, or by what keeps its distance."""
    if desk.bones == "template":
        desk.bones = "inferred"
    elif desk.opened is not None and desk.opened.skeleton is not None:
        desk.bones = "template"
    else:
        desk.fail("These labels name no set of markers that is known; bones stay as inferred.")


def _threshold(kind: Kind) -> Intention:
    def change(desk: Desk, arg: Any, _: Fields) -> None:
        desk.set_threshold(kind, min(MOST_FACTOR, max(LEAST_FACTOR, float(arg))))

    return change


def _open(desk: Desk, arg: Any, fields: Fields) -> None:
    path = str(arg or fields.get("path", "")).strip().strip('"')
    if path:
        desk.open(Path(path))
    else:
        desk.fail("Give the path of a recording.")


def _archive(desk: Desk, _: Any, __: Fields) -> None:
    archive = desk.workspace.archive
    if archive is None:
        desk.fail("No batch has looked at this folder; markermend batch FOLDER does it.")
        return
    archive.look()
    desk.show("archive")


def _span(act: Callable[[Desk, int, int], None]) -> Intention:
    def moved(desk: Desk, arg: Any, _: Fields) -> None:
        start, stop = arg if isinstance(arg, list | tuple) and len(arg) == 2 else (0, 0)
        if int(start) < int(stop):
            act(desk, int(start), int(stop))

    return moved


def _signal(desk: Desk, arg: Any, _: Fields) -> None:
    if arg in SIGNALS:
        desk.signal = arg


def _relative(desk: Desk, _: Any, __: Fields) -> None:
    desk.relative = not is_relative(desk)


def _run(desk: Desk, arg: Any, fields: Fields) -> None:
    """Do what was chosen in the command palette."""
    name = str(arg or "")
    desk.close_dialog()
    if name in INTENTIONS and name != "run":
        INTENTIONS[name](desk, None, fields)


def _write(desk: Desk, _: Any, fields: Fields) -> None:
    target = str(fields.get("target", "")).strip()
    if not target:
        desk.fail("Give the export a file name.")
        return
    desk.export(
        Path(target),
        overwrite=bool(fields.get("overwrite")),
        report=bool(fields.get("report")),
    )


def _units(desk: Desk, arg: Any, _: Fields) -> None:
    if desk.asked is not None:
        desk.open(desk.asked.path, units=str(arg), rate=desk.asked.rate)


def _rate(desk: Desk, _: Any, fields: Fields) -> None:
    if desk.asked is None:
        return
    try:
        rate = float(str(fields.get("rate", "")).replace(",", "."))
    except ValueError:
        desk.fail("The rate must be a number of frames a second, such as 100.")
        return
    desk.open(desk.asked.path, units=desk.asked.units, rate=rate)


INTENTIONS: Mapping[str, Intention] = {
    "accept": lambda desk, arg, fields: desk.accept(),
    "reject": lambda desk, arg, fields: desk.reject(),
    "leave": lambda desk, arg, fields: desk.leave(),
    "defer": lambda desk, arg, fields: desk.defer(),
    **{f"kind_{kind}": _reclassify(kind) for kind in KINDS},
    "choose": lambda desk, arg, fields: desk.choose(str(arg)),
    "method_next": lambda desk, arg, fields: desk.choose_by(1),
    "method_previous": lambda desk, arg, fields: desk.choose_by(-1),
    "method_default": lambda desk, arg, fields: desk.choose_recommended(),
    "select": lambda desk, arg, fields: desk.select(str(arg)),
    "next": lambda desk, arg, fields: desk.next(),
    "previous": lambda desk, arg, fields: desk.previous(),
    "filter_kind": _filter,
    "filter_text": _text,
    "filter_verdict": _verdict,
    "filter_by": _by,
    "bones": _bones,
    "filter_clear": lambda desk, arg, fields: desk.clear_filters(),
    "learning": _toggle("learning"),
    "note": lambda desk, arg, fields: desk.show("note") if desk.current else None,
    "note_keep": lambda desk, arg, fields: desk.annotate(str(fields.get("note", ""))),
    "reopen": lambda desk, arg, fields: desk.reopen(),
    "edge_start": lambda desk, arg, fields: desk.start_here(),
    "edge_stop": lambda desk, arg, fields: desk.stop_here(),
    "edges": _span(Desk.move_edges),
    "split": lambda desk, arg, fields: desk.split(),
    "merge": lambda desk, arg, fields: desk.merge(),
    "add_begin": lambda desk, arg, fields: desk.begin_span(),
    "add_end": lambda desk, arg, fields: desk.end_span(),
    "add": _span(Desk.add_span),
    "adding": _toggle("adding"),
    "remove": lambda desk, arg, fields: desk.remove_added(),
    "similar": lambda desk, arg, fields: desk.show_similar(),
    "similar_decide": lambda desk, arg, fields: desk.decide_similar(str(arg)),
    "try_slow": lambda desk, arg, fields: desk.try_slow(str(arg)),
    "refused": _toggle("refused_shown"),
    "thresholds": lambda desk, arg, fields: desk.show("thresholds") if desk.opened else None,
    **{f"threshold_{kind}": _threshold(kind) for kind in KINDS},
    "slow_reach": lambda desk, arg, fields: desk.show_slow_reach(),
    "signal": _signal,
    "signal_next": lambda desk, arg, fields: desk.signal_next(),
    "relative": _relative,
    "play": _toggle("playing"),
    "frame_back": lambda desk, arg, fields: desk.step_frame(-1),
    "frame_on": lambda desk, arg, fields: desk.step_frame(1),
    "speed": _speed,
    "loop": _toggle("looping"),
    "zoom": lambda desk, arg, fields: desk.zoom_next(),
    "raw_only": _toggle("raw_only"),
    "view": _view,
    "view_next": _view_next,
    "follow": _toggle("following"),
    "undo": lambda desk, arg, fields: desk.undo(),
    "redo": lambda desk, arg, fields: desk.redo(),
    "theme": _theme,
    "prefer_dark": _prefer_dark,
    "help": lambda desk, arg, fields: desk.show("help"),
    "commands": lambda desk, arg, fields: desk.show("commands"),
    "run": _run,
    "history": lambda desk, arg, fields: desk.show("history") if desk.session else None,
    "history_go": lambda desk, arg, fields: desk.go_to(int(arg)),
    "takes": lambda desk, arg, fields: desk.show_takes(),
    "archive": _archive,
    "open": _open,
    "cancel": lambda desk, arg, fields: desk.cancel(),
    "export": lambda desk, arg, fields: desk.plan_export(),
    "report": lambda desk, arg, fields: desk.report(),
    "export_write": _write,
    "answer_units": _units,
    "answer_rate": _rate,
    "close": lambda desk, arg, fields: desk.close_dialog(),
    "dismiss": lambda desk, arg, fields: desk.dismiss(),
    **EXERCISE_INTENTIONS,
    **TEAM_INTENTIONS,
}
WITH_DIALOG = {
    "close",
    "archive",
    "note_keep",
    "similar_decide",
    *(f"threshold_{kind}" for kind in KINDS),
    "learning",
    "run",
    "history_go",
    "open",
    "cancel",
    "dismiss",
    "export_write",
    "answer_units",
    "answer_rate",
    "theme",
    "prefer_dark",
    *WITH_EXERCISE_DIALOG,
}


NEEDS: Mapping[str, Right] = dict.fromkeys(
    [name for name in INTENTIONS if name.startswith(("agreement", "adjudicate", "opinion_"))],
    "adjudicate",
)
"""What not everybody in a lab may ask for."""


def perform(desk: Desk, name: str, arg: Any = None, fields: Fields | None = None) -> None:
    """Do what a button or key asks for; while a dialog is open, only what belongs to it."""
    if name not in INTENTIONS or (desk.dialog and name not in WITH_DIALOG):
        return
    if name in NEEDS and not desk.person.may(NEEDS[name]):
        desk.fail(
            f"That is for reviewers, and {desk.person.name} is {desk.person.role} here; ask one."
        )
        return
    INTENTIONS[name](desk, arg, fields or {})
