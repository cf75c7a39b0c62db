"""Dialogs about takes: open one, say what a file does not, export."""

from html import escape

from markermend.model import short
from markermend_app.state.desk import Desk
from markermend_app.state.exporting import Plan
from markermend_app.state.places import Place
from markermend_app.style.kinds import glyph
from markermend_app.views.markup import button, closing, footer, icon, number


def choose(desk: Desk) -> str:
    """Give what can be opened, and a field for anything else."""
    takes = desk.takes
    assert takes is not None
    sections = "".join(
        f"<h2>{words}</h2>{''.join(_place(place, desk) for place in places)}"
        for words, places in (
            ("Second review asked for", takes.asked),
            ("Work list", takes.given),
            ("In the same folder", takes.beside),
            ("Opened before", takes.recent),
        )
        if places
    )
    return (
        '<header><h1 id="dialog-title">Open a take</h1><p>Choose one, give its path, or drop a '
        "file on the page.</p></header>"
        '<div class="body"><input type="text" class="field" name="path" data-autofocus '
        'aria-label="Path of a recording" placeholder="Path of a recording" spellcheck="false">'
        f'<div class="list">{sections}</div></div>'
        + footer(
            _to_archive(desk),
            closing("Cancel"),
            button("open", "Open", classes="deed primary", key=False),
        )
    )


def _to_archive(desk: Desk) -> str:
    if desk.workspace.archive is None:
        return ""
    return button("archive", "The whole archive", classes="deed", key=False)


def _place(place: Place, desk: Desk) -> str:
    here = desk.opened.take.source if desk.opened else None
    now = here is not None and here.path == place.path
    return button(
        "open",
        f"<span>{escape(place.path.name)}</span>"
        f'<span class="quiet">{escape(place.why or str(place.path.parent))}</span>',
        classes="",
        arg=str(place.path),
        key=False,
        title=str(place.path),
        current=now,
    )


def export(desk: Desk) -> str:
    """Give exactly what an export would change, and what is left open."""
    plan = desk.plan
    if plan is None:
        return ""
    counts = plan.counts
    left_gaps = sum(c.left for c in plan.changes)
    sums = "".join(
        f"<div><b>{value}</b><span>{icon(sign, 13) if sign else ''}{word}</span></div>"
        for value, word, sign in (
            (counts.accepted - left_gaps, "repaired", "accepted"),
            (left_gaps, "left as gap", "left"),
            (counts.rejected, "false alarms", "rejected"),
            (counts.deferred, "set aside", "deferred"),
            (counts.open, "open", ""),
        )
    )
    notes = [_stays(counts.open, "open"), _stays(counts.deferred, "set aside")]
    notes += [f"{r.wish.marker} {r.wish.kind} stays: {r.reason}" for r in plan.refusals]
    shown = "".join(f'<p class="note">{escape(note)}</p>' for note in notes if note)
    share = 100 * plan.n_changed / max(1, plan.n_samples)
    kept = "" if plan.n_changed else " Nothing is accepted yet: the export would be a copy."
    return (
        f'<header><h1 id="dialog-title">Export {escape(plan.name)}</h1>'
        f"<p><b>{plan.n_changed:,}</b> of {plan.n_samples:,} samples will change "
        f"({share:.2g} %). {escape(plan.promise)}{kept}</p></header>"
        f'<div class="body two" tabindex="0"><div><div class="sums">{sums}</div>{_changes(plan)}'
        f'</div><div><label>File<input type="text" name="target" value="{escape(str(plan.target))}"'
        ' spellcheck="false" data-autofocus></label>'
        '<label class="check"><input type="checkbox" name="overwrite"> Replace the file if it is '
        'there</label><label class="check"><input type="checkbox" name="report" checked> Report, '
        "one HTML page with tables and pictures</label>"
        f'<p class="quiet">The decisions go beside it as JSON.</p>{shown}</div></div>'
        + footer(
            '<span class="quiet">After writing, both files are read again and compared.</span>',
            '<span class="push"></span>',
            closing("Back"),
            button(
                "export_write",
                "Export and verify<kbd>↵</kbd>",
                classes="deed primary",
                key=False,
                disabled=bool(desk.busy),
            ),
        )
    )


def _stays(n: int, what: str) -> str:
    if not n:
        return ""
    finding, its = ("finding is", "its") if n == 1 else ("findings are", "their")
    return f"{n} {finding} {what}; {its} data stays as it is."


def _changes(plan: Plan) -> str:
    rows = "".join(
        f"<tr><td>{glyph(c.kind)}</td><td>{escape(short(c.marker))}</td><td>{c.start_s:.2f}</td>"
        f"<td>{c.n_frames}</td><td>{escape(c.method)}</td>"
        f"<td>{'filled' if c.largest_mm is None and not c.left else number(c.largest_mm)}</td>"
        f"<td>{number(c.expected_mm)}</td></tr>"
        for c in plan.changes
    )
    return (
        "<table><thead><tr><th></th><th>Marker</th><th>From, s</th><th>Samples</th><th>Repair</th>"
        "<th>Largest change, mm</th><th>Expected error, mm</th></tr></thead>"
        f"<tbody>{rows}</tbody></table>"
    )


def exported(desk: Desk) -> str:
    """Give what the verification found."""
    plan = desk.plan
    if plan is None:
        return ""
    lines = "".join(f"<p>{escape(line)}</p>" for line in plan.verified)
    return (
        '<header><h1 id="dialog-title">Exported and verified</h1>'
        f"<p>{escape(str(plan.target))}</p></header>"
        f'<div class="body" style="display:grid;gap:8px">{lines}</div>' + footer(closing("Close"))
    )


def ask(desk: Desk) -> str:
    """Ask for what the file does not say."""
    asked = desk.asked
    if asked is None:
        return ""
    name = escape(asked.path.name)
    if asked.what == "units":
        choices = "".join(
            button("answer_units", unit, arg=unit, classes="deed", key=False)
            for unit in ("mm", "cm", "m")
        )
        return (
            '<header><h1 id="dialog-title">This file has no unit</h1>'
            f"<p>{name}: choose m, cm or mm.</p></header>"
            f'<div class="body" style="display:flex;gap:8px">{choices}</div>'
            + footer(closing("Cancel"))
        )
    return (
        '<header><h1 id="dialog-title">This file has no rate</h1>'
        f"<p>{name}: how many frames a second?</p></header>"
        '<div class="body"><label>Hz<input type="text" name="rate" inputmode="decimal" '
        "data-autofocus></label></div>"
        + footer(
            closing("Cancel"), button("answer_rate", "Open", classes="deed primary", key=False)
        )
    )
