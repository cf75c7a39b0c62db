"""What may be asked of a desk that practises and compares, by name."""

from collections.abc import Callable, Mapping
from typing import Any

from markermend_app.state.compared import MOST_PEOPLE
from markermend_app.state.desk import Desk
from markermend_app.state.second_review import Comparing

Fields = Mapping[str, Any]
Act = Callable[[Comparing, Any, Fields], None]


def _on(act: Act) -> Callable[[Desk, Any, Fields], None]:
    """Ask it of a desk that can do it; a desk that cannot has no such buttons."""

    def asked(desk: Desk, arg: Any, fields: Fields) -> None:
        if isinstance(desk, Comparing):
            act(desk, arg, fields)

    return asked


def _begin(desk: Comparing, _: Any, fields: Fields) -> None:
    desk.choose_exercise(
        str(fields.get("level", "")),
        str(fields.get("trainee", "")),
        hidden=bool(fields.get("hidden")),
    )


def _finish(desk: Comparing, _: Any, __: Fields) -> None:
    if desk.dialog == "finish":
        desk.finish()
    elif desk.dialog:
        return
    elif desk.second:
        desk.finish_second()
    else:
        desk.ask_finish()


def _follow(person: int) -> Act:
    return lambda desk, arg, fields: desk.follow(person)


def _look(desk: Comparing, arg: Any, _: Fields) -> None:
    if str(arg).isdigit():
        desk.look(int(str(arg)))


EXERCISE_INTENTIONS: Mapping[str, Callable[[Desk, Any, Fields], None]] = {
    name: _on(act)
    for name, act in {
        "practise": lambda desk, arg, fields: desk.ask_practice(),
        "practise_begin": _begin,
        "practise_next": lambda desk, arg, fields: desk.next_exercise(),
        "practise_help": lambda desk, arg, fields: desk.toggle_help(),
        "practise_leave": lambda desk, arg, fields: desk.leave_exercise(),
        "finish": _finish,
        "feedback": lambda desk, arg, fields: desk.show_feedback(),
        "feedback_look": _look,
        "second": lambda desk, arg, fields: desk.ask_second(),
        "second_begin": lambda desk, arg, fields: desk.review_blind(
            str(fields.get("operator", ""))
        ),
        "agreement": lambda desk, arg, fields: desk.compare(),
        "agreement_expert": lambda desk, arg, fields: desk.compare(str(arg)),
        "adjudicate": lambda desk, arg, fields: desk.adjudicate(),
        **{f"opinion_{i + 1}": _follow(i) for i in range(MOST_PEOPLE)},
    }.items()
}
WITH_EXERCISE_DIALOG = {
    "practise_begin", "practise_next", "finish", "feedback_look", "second_begin", "second_request",
    "agreement_expert", "adjudicate",
}  # fmt: skip
