"""What may be asked of a desk, by name: buttons and keys say nothing else."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from markermend.model import KINDS, Kind
from markermend_app.state.desk import VIEWS, Desk

Fields = Mapping[str, Any]
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


def _write(desk: Desk, _: Any, fields: Fields) -> None:
    target = str(fields.get("target", "")).strip()
    if not target:
        desk.fail("Give the export a file name.")
        return
    desk.export(Path(target), overwrite=bool(fields.get("overwrite")))


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
    "play": _toggle("playing"),
    "frame_back": lambda desk, arg, fields: desk.step_frame(-1),
    "frame_on": lambda desk, arg, fields: desk.step_frame(1),
    "seek": lambda desk, arg, fields: desk.seek(float(arg)),
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
    "help": lambda desk, arg, fields: desk.show_help(),
    "export": lambda desk, arg, fields: desk.plan_export(),
    "export_write": _write,
    "answer_units": _units,
    "answer_rate": _rate,
    "close": lambda desk, arg, fields: desk.close_dialog(),
    "dismiss": lambda desk, arg, fields: desk.dismiss(),
}
WITH_DIALOG = {
    "close",
    "dismiss",
    "export_write",
    "answer_units",
    "answer_rate",
    "theme",
    "prefer_dark",
}


def perform(desk: Desk, name: str, arg: Any = None, fields: Fields | None = None) -> None:
    """Do what a button or key asks for; while a dialog is open, only what belongs to it."""
    if name not in INTENTIONS or (desk.dialog and name not in WITH_DIALOG):
        return
    INTENTIONS[name](desk, arg, fields or {})
