"""What opens above the desk: help, export, what a file does not say."""

from html import escape
from itertools import groupby

from markermend_app.keys import SHORTCUTS, printed
from markermend_app.state.desk import Desk
from markermend_app.state.exporting import Plan
from markermend_app.style.kinds import glyph
from markermend_app.views.markup import button, kbd, number

SHOWS = ("dialog", "plan", "asked", "busy")


def render(desk: Desk) -> str:
    """Give the dialog that is open, or nothing."""
    made = {"help": _help, "export": _export, "exported": _exported, "ask": _ask}.get(desk.dialog)
    if made is None:
        return ""
    return (
        '<div class="scrim"><div class="dialog" role="dialog" aria-modal="true" data-form>'
        f"{made(desk)}</div></div>"
    )


def _footer(*buttons: str) -> str:
    return f"<footer>{''.join(buttons)}</footer>"


def _close(label: str) -> str:
    return button("close", label, classes="deed")


def _help(desk: Desk) -> str:
    del desk
    sections = []
    for group, shortcuts in groupby(SHORTCUTS, key=lambda s: s.group):
        lines = "".join(
            f"<div><span>{' '.join(f'<kbd>{escape(printed(k))}</kbd>' for k in s.keys)}</span>"
            f"<span>{escape(s.does)}</span></div>"
            for s in shortcuts
        )
        sections.append(f"<section><h2>{group}</h2>{lines}</section>")
    return (
        "<header><h1>Keys</h1><p>Left hand decides, right hand moves. Nothing asks twice: "
        f"{kbd('undo')} takes anything back.</p></header>"
        f'<div class="body keys">{"".join(sections)}</div>' + _footer(_close("Close"))
    )


def _export(desk: Desk) -> str:
    plan = desk.plan
    assert plan is not None
    counts = plan.counts
    sums = "".join(
        f"<div><b>{value}</b>{word}</div>"
        for word, value in (
            ("accepted", counts.accepted),
            ("false alarms", counts.rejected),
            ("set aside", counts.deferred),
            ("open", counts.open),
        )
    )
    left = counts.open + counts.deferred
    notes = [f"{left} findings have no verdict; their data stays as it is."] if left else []
    notes += [f"{r.wish.marker} {r.wish.kind} stays: {r.reason}" for r in plan.refusals]
    shown = "".join(f'<p class="note">{escape(note)}</p>' for note in notes)
    share = 100 * plan.n_changed / max(1, plan.n_samples)
    return (
        f"<header><h1>Export {escape(plan.name)}</h1><p><b>{plan.n_changed:,}</b> of "
        f"{plan.n_samples:,} samples will change ({share:.2g} %). {escape(plan.promise)}</p>"
        "</header>"
        f'<div class="body two"><div><div class="sums">{sums}</div>{_changes(plan)}</div>'
        f'<div><label>File<input type="text" name="target" value="{escape(str(plan.target))}" '
        f'spellcheck="false" data-autofocus></label>'
        '<label class="check"><input type="checkbox" name="overwrite"> Replace the file if it is '
        'there</label><p class="quiet">The decisions go beside it as JSON.</p>'
        f"{shown}</div></div>"
        + _footer(
            '<span class="quiet">After writing, both files are read again and compared.</span>',
            '<span class="push"></span>',
            _close("Back"),
            button("export_write", "Export and verify", classes="deed primary", key=False,
                   disabled=bool(desk.busy)),
        )
    )  # fmt: skip


def _changes(plan: Plan) -> str:
    rows = "".join(
        f"<tr><td>{glyph(c.kind)}</td><td>{escape(c.marker)}</td><td>{c.start_s:.2f}–{c.stop_s:.2f}</td>"
        f"<td>{c.n_frames}</td><td>{escape(c.method)}</td><td>{number(c.largest_mm)}</td></tr>"
        for c in plan.changes
    )
    return (
        "<table><thead><tr><th></th><th>Marker</th><th>s</th><th>Frames</th><th>Repair</th>"
        f"<th>Largest change mm</th></tr></thead><tbody>{rows}</tbody></table>"
    )


def _exported(desk: Desk) -> str:
    plan = desk.plan
    assert plan is not None
    lines = "".join(f"<p>{escape(line)}</p>" for line in plan.verified)
    return (
        f"<header><h1>Exported and verified</h1><p>{escape(str(plan.target))}</p></header>"
        f'<div class="body" style="display:grid;gap:8px">{lines}</div>' + _footer(_close("Close"))
    )


def _ask(desk: Desk) -> str:
    asked = desk.asked
    assert asked is not None
    if asked.what == "units":
        choices = "".join(
            button("answer_units", unit, arg=unit, classes="deed", key=False)
            for unit in ("mm", "cm", "m")
        )
        return (
            "<header><h1>This file has no unit</h1>"
            f"<p>{escape(asked.path.name)}: choose m, cm or mm.</p></header>"
            f'<div class="body" style="display:flex;gap:8px">{choices}</div>'
            + _footer(_close("Cancel"))
        )
    return (
        "<header><h1>This file has no rate</h1>"
        f"<p>{escape(asked.path.name)}: how many frames a second?</p></header>"
        '<div class="body"><label>Hz<input type="text" name="rate" inputmode="decimal" '
        'data-autofocus></label></div>'
        + _footer(_close("Cancel"),
                  button("answer_rate", "Open", classes="deed primary", key=False))
    )  # fmt: skip
