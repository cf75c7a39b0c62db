"""What opens above the desk: the frame of every dialog, help and commands."""

from html import escape
from itertools import groupby

from markermend_app.keys import COMMANDS, in_force, printed
from markermend_app.state.desk import Desk
from markermend_app.views import dialogs_archive, dialogs_findings, dialogs_takes, exercise
from markermend_app.views.markup import button, closing, footer, kbd

SHOWS = (
    "dialog", "plan", "asked", "busy", "takes", "similar", "expected", "thresholds", "findings",
    "review", "learning", "chosen", "message", "slow_reach",
)  # fmt: skip
NARROW = ("note", "ask", "commands", "history", "slow_reach", *exercise.DIALOGS)


def render(desk: Desk) -> str:
    """Give the dialog that is open, or nothing."""
    made = {
        "help": _help,
        "commands": _commands,
        "export": dialogs_takes.export,
        "exported": dialogs_takes.exported,
        "ask": dialogs_takes.ask,
        "open": dialogs_takes.choose,
        "archive": dialogs_archive.overview,
        "note": dialogs_findings.note,
        "similar": dialogs_findings.similar,
        "thresholds": dialogs_findings.thresholds,
        "slow_reach": dialogs_findings.slow_reach,
        "history": dialogs_findings.history,
        **exercise.DIALOGS,
    }.get(desk.dialog)
    if made is None:
        return ""
    size = "dialog narrow" if desk.dialog in NARROW else "dialog"
    size = "dialog wide" if desk.dialog == "archive" else size
    said = f'<p class="note" role="alert">{escape(desk.message)}</p>' if desk.message else ""
    return (
        f'<div class="scrim"><div class="{size}" role="dialog" aria-modal="true" tabindex="-1" '
        f'aria-labelledby="dialog-title" data-form data-dialog="{desk.dialog}">'
        f"{made(desk)}{said}</div></div>"
    )


def _help(desk: Desk) -> str:
    del desk
    sections = []
    for group, shortcuts in groupby(in_force().shortcuts, key=lambda s: s.group):
        lines = "".join(
            f"<div><span>{' '.join(f'<kbd>{escape(printed(k))}</kbd>' for k in s.keys)}</span>"
            f"<span>{escape(s.does)}</span></div>"
            for s in shortcuts
        )
        sections.append(f"<section><h2>{group}</h2>{lines}</section>")
    return (
        '<header><h1 id="dialog-title">Keys</h1><p>Left hand decides, right hand moves. Nothing '
        f"asks twice: {kbd('undo')} takes anything back.</p></header>"
        f'<div class="body keys" tabindex="0">{"".join(sections)}</div>' + footer(closing("Close"))
    )


def _commands(desk: Desk) -> str:
    del desk
    entries = [(s.action, s.does) for s in in_force().shortcuts if not s.at_once]
    entries += list(COMMANDS.items())
    listed = "".join(
        button(
            "run",
            f"<span>{escape(does[:1].upper() + does[1:])}</span>"
            f'<span class="quiet">{kbd(action)}</span>',
            classes="",
            arg=action,
            key=False,
        )
        for action, does in entries
        if action not in ("close", "commands")
    )
    return (
        '<header><h1 id="dialog-title">Commands</h1></header><div class="body">'
        '<input type="text" class="field" name="words" data-narrows data-autofocus '
        'aria-label="Words of a command" placeholder="Words of a command, then Enter" '
        'autocomplete="off" spellcheck="false">'
        f'<div class="list narrowed">{listed}</div></div>' + footer(closing("Close"))
    )
