"""The one table of shortcuts: what each key does, in the words of the help page.

The key listener's whitelist, the hints on buttons, the tooltips and the help are made from it.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from markermend.errors import BadInput, UnknownName


@dataclass(frozen=True)
class Shortcut:
    """One intention of the operator.

    Attributes
    ----------
    action
        Name of the intention, as the desk knows it.
    keys
        Names of keys as browsers report them; ``Ctrl+`` and ``Shift+`` before a name.
    does
        What it does, for the help.
    group
        Heading under which the help lists it.
    repeats
        Whether holding the key down repeats it.
    at_once
        Whether the browser does it by itself, without asking.
    """

    action: str
    keys: tuple[str, ...]
    does: str
    group: str
    repeats: bool = False
    at_once: bool = False

    @property
    def hint(self) -> str:
        """The key as it is printed on a button."""
        return printed(self.keys[0])


def printed(key: str) -> str:
    """Write the name of a key as it stands on keyboards."""
    names = {" ": "Space", "ArrowLeft": "←", "ArrowRight": "→", "Escape": "Esc"}
    *modifiers, name = key.split("+") if len(key) > 1 else [key]
    return "+".join([*modifiers, names.get(name, name.upper() if len(name) == 1 else name)])


SHORTCUTS: tuple[Shortcut, ...] = (
    Shortcut("accept", ("a",), "accept the chosen repair", "Decide"),
    Shortcut("reject", ("f",), "false alarm: keep the data as recorded", "Decide"),
    Shortcut("leave", ("g",), "leave as a gap", "Decide"),
    Shortcut("defer", ("s",), "set aside", "Decide"),
    Shortcut("similar", ("x",), "decide similar ones together", "Decide"),
    Shortcut("note", ("n",), "note", "Decide"),
    Shortcut("kind_gap", ("1",), "it is a gap", "What and where"),
    Shortcut("kind_peak", ("2",), "it is a peak", "What and where"),
    Shortcut("kind_noise", ("3",), "it is noise", "What and where"),
    Shortcut("kind_step", ("4",), "it is a step", "What and where"),
    Shortcut("kind_slow", ("5",), "it is a slow change", "What and where"),
    Shortcut("edge_start", ("[",), "the span starts at the playhead", "What and where"),
    Shortcut("edge_stop", ("]",), "the span ends at the playhead", "What and where"),
    Shortcut("add_begin", ("i",), "a missed span begins here", "What and where"),
    Shortcut("add_end", ("o",), "the missed span ends here: add it", "What and where"),
    Shortcut("split", ("b",), "split at the playhead", "What and where"),
    Shortcut("merge", ("m",), "merge with the next of this marker", "What and where"),
    Shortcut("method_next", ("d",), "next repair", "Repair", repeats=True),
    Shortcut("method_previous", ("e",), "previous repair", "Repair", repeats=True),
    Shortcut("method_default", ("r",), "the recommended repair", "Repair"),
    Shortcut("next", ("j",), "next open finding", "Move", repeats=True),
    Shortcut("previous", ("k",), "previous open finding", "Move", repeats=True),
    Shortcut("play", (" ",), "play, pause", "Move"),
    Shortcut("frame_back", (",", "ArrowLeft"), "one frame back", "Move", repeats=True),
    Shortcut("frame_on", (".", "ArrowRight"), "one frame on", "Move", repeats=True),
    Shortcut("loop", ("l",), "loop around the span, or the whole take", "View"),
    Shortcut("zoom", ("z",), "zoom: span, 5 s, take", "View"),
    Shortcut("relative", ("q",), "without the neighbours’ motion, or with it", "View"),
    Shortcut("signal_next", ("c",), "next evidence", "View"),
    Shortcut("raw_only", ("h",), "raw only, without repairs", "View"),
    Shortcut("view_next", ("v",), "next view: front, side, top", "View"),
    Shortcut("follow", ("w",), "follow the subject", "View"),
    Shortcut(
        "filter", ("/",), "filter by marker; Enter or Esc leaves the field", "Take", at_once=True
    ),
    Shortcut("thresholds", ("t",), "thresholds of the detector", "Take"),
    Shortcut("undo", ("u", "Ctrl+z"), "undo", "Take"),
    Shortcut("redo", ("y", "Ctrl+Shift+z"), "redo", "Take"),
    Shortcut("takes", ("Ctrl+o",), "open a take", "Take"),
    Shortcut("export", ("Ctrl+s",), "summary and export", "Take"),
    Shortcut("commands", ("p",), "find a command", "Take"),
    Shortcut("help", ("?",), "this help", "Take"),
    Shortcut("close", ("Escape",), "close what is open", "Take"),
    Shortcut("finish", ("Ctrl+Enter",), "finish the exercise, or a second review", "Together"),
    Shortcut("opinion_1", ("6",), "adjudicate: decide as the first reviewer did", "Together"),
    Shortcut("opinion_2", ("7",), "adjudicate: decide as the second reviewer did", "Together"),
    Shortcut("opinion_3", ("8",), "adjudicate: decide as the third reviewer did", "Together"),
)
COMMANDS: dict[str, str] = {
    "history": "history of decisions: read it and walk in it",
    "reopen": "take the verdict back and stay",
    "remove": "remove a span that was added by hand",
    "adding": "add a missed span by dragging over a lane",
    "filter_clear": "clear all filters",
    "bones": "bones by the labels, or inferred",
    "slow_reach": "how small a slow change would be found here, by marker",
    "learning": "order by earlier decisions, or not",
    "report": "write a report of this take",
    "archive": "the archive as a whole: worst takes, markers that fail",
    "theme": "light or dark",
    "practise": "practise: an exercise whose truth is known",
    "practise_help": "exercise: answers after each decision, or at the end",
    "practise_next": "exercise: the next one, for the weakest kind",
    "practise_leave": "exercise: leave it without a grade",
    "feedback": "exercise: what was right and what was not",
    "second": "second review of this take, blinded: ask for one, or make it",
    "agreement": "compare all reviews of this take",
    "adjudicate": "adjudicate the reviews that were compared",
}
"""What the command palette lists beside the shortcuts."""


def remapped(
    shortcuts: tuple[Shortcut, ...], changes: Mapping[str, Sequence[str]]
) -> tuple[Shortcut, ...]:
    """Give the table with other keys.

    Parameters
    ----------
    shortcuts
        The table.
    changes
        Name of the intention -> its keys.

    Raises
    ------
    BadInput
        If there is no such intention, or two intentions would have the same key.
    """
    known = {s.action: s for s in shortcuts}
    for action in changes:
        if action not in known:
            raise UnknownName.among("command with a key", action, known)
    table = tuple(
        replace(s, keys=tuple(changes[s.action])) if s.action in changes else s for s in shortcuts
    )
    taken: dict[str, str] = {}
    for shortcut in table:
        for key in shortcut.keys:
            if key in taken and taken[key] != shortcut.action:
                raise BadInput(
                    f"The key {printed(key)} is given to {taken[key]} and to {shortcut.action}; "
                    "give one of them another key."
                )
            taken[key] = shortcut.action
    return table


def read_keys(path: Path) -> tuple[Shortcut, ...]:
    """Read a file of keys: JSON, name of the intention -> key or list of keys.

    Raises
    ------
    BadInput
        If the file is no such thing, or keys conflict.
    """
    try:
        given = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise BadInput(
            f"The keys in {path} cannot be read ({error}); write them as "
            '{"accept": "Enter", "reject": ["f", "x"]}.'
        ) from None
    if not isinstance(given, dict) or not all(_is_keys(keys) for keys in given.values()):
        raise BadInput(
            f'{path} must be an object of keys by command, such as {{"accept": "Enter"}}.'
        )
    return remapped(
        SHORTCUTS, {name: [k] if isinstance(k, str) else k for name, k in given.items()}
    )


def _is_keys(value: Any) -> bool:
    return isinstance(value, str) or (
        isinstance(value, list) and all(isinstance(key, str) and key for key in value)
    )


class Keys:
    """The shortcuts in force, for everything that shows or hears keys."""

    def __init__(self, shortcuts: tuple[Shortcut, ...] = SHORTCUTS) -> None:
        self.shortcuts = shortcuts
        self.hints = {s.action: s.hint for s in shortcuts if s.keys}
        self.actions = {key: s.action for s in shortcuts for key in s.keys if not s.at_once}
        self.at_once = {key: s.action for s in shortcuts for key in s.keys if s.at_once}
        self.repeating = [key for s in shortcuts if s.repeats for key in s.keys]


def in_force() -> Keys:
    """Give the shortcuts that this process uses."""
    return _IN_FORCE[0]


def use(shortcuts: tuple[Shortcut, ...]) -> None:
    """Use other keys from now on, on pages opened after."""
    _IN_FORCE[0] = Keys(shortcuts)


_IN_FORCE = [Keys()]
