"""The one table of shortcuts: what each key does, in the words of the help page.

The key listener's whitelist, the hints on buttons, the tooltips and the help are made from it.
"""

from dataclasses import dataclass


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
    """

    action: str
    keys: tuple[str, ...]
    does: str
    group: str
    repeats: bool = False

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
    Shortcut("kind_gap", ("1",), "it is a gap", "Decide"),
    Shortcut("kind_peak", ("2",), "it is a peak", "Decide"),
    Shortcut("kind_noise", ("3",), "it is noise", "Decide"),
    Shortcut("kind_step", ("4",), "it is a step", "Decide"),
    Shortcut("kind_slow", ("5",), "it is a slow change", "Decide"),
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
    Shortcut("raw_only", ("h",), "raw only, without repairs", "View"),
    Shortcut("view_next", ("v",), "next view: front, side, top", "View"),
    Shortcut("follow", ("w",), "follow the subject", "View"),
    Shortcut("undo", ("u", "Ctrl+z"), "undo", "Take"),
    Shortcut("redo", ("y", "Ctrl+Shift+z"), "redo", "Take"),
    Shortcut("export", ("Ctrl+s",), "export the repaired take", "Take"),
    Shortcut("help", ("?",), "this help", "Take"),
    Shortcut("close", ("Escape",), "close what is open", "Take"),
)
ACTION_OF_KEY = {key: s.action for s in SHORTCUTS for key in s.keys}
HINTS = {s.action: s.hint for s in SHORTCUTS}
