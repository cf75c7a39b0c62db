"""Dialogs about findings: note, similar ones, thresholds, what would be found, history."""

from html import escape
from math import isfinite

from markermend.model import short
from markermend_app.state.desk import Desk
from markermend_app.state.intents import LEAST_FACTOR, MOST_FACTOR
from markermend_app.style.kinds import KIND_STYLES, glyph
from markermend_app.views.markup import button, closing, footer, number

MOST_ROWS = 200


def note(desk: Desk) -> str:
    """Give the field for a note."""
    finding = desk.current
    if finding is None:
        return ""
    judged = desk.judged(finding)
    name = escape(f"{short(finding.marker)} {judged.kind}")
    return (
        f'<header><h1 id="dialog-title">Note on {name}</h1><p>It goes into the decision file and '
        "the report.</p></header>"
        '<div class="body"><textarea name="note" data-autofocus data-enter aria-label="Note" '
        f'maxlength="2000">{escape(judged.decision.note)}</textarea></div>'
        + footer(
            closing("Cancel"),
            button("note_keep", "Keep note<kbd>Enter</kbd>", classes="deed primary", key=False),
        )
    )


def similar(desk: Desk) -> str:
    """Give what one decision on all similar findings would touch."""
    found, current = desk.similar, desk.current
    if desk.opened is None or current is None:
        return ""
    rate = desk.opened.take.rate
    kind = desk.judged(current).kind
    title = next((p.title for p in desk.previews if p.name == desk.chosen), "the default repair")
    known = [e for e in desk.expected.values() if isfinite(e)]
    said = f"{len(found)} similar {kind} findings would get {_in_sentence(title)}"
    if known:
        of = "" if len(desk.expected) == len(found) else f" of {len(desk.expected)} measured"
        said += f"; the largest expected error{of} is {number(max(known))} mm"
    rows = "".join(
        f"<tr><td>{glyph(desk.judged(f).kind)}</td><td>{escape(short(f.marker))}</td>"
        f"<td>{desk.judged(f).span.start / rate:.2f}</td>"
        f"<td>{len(desk.judged(f).span) / rate:.2f}</td><td>{number(f.amplitude)}</td>"
        f"<td>{_expected(desk.expected.get(f.id))}</td></tr>"
        for f in found[:MOST_ROWS]
    )
    more = f"<p>and {len(found) - MOST_ROWS} more</p>" if len(found) > MOST_ROWS else ""
    return (
        f'<header><h1 id="dialog-title">{len(found)} similar findings</h1>'
        f"<p>{escape(said)}. One step to undo.</p></header>"
        '<div class="body" tabindex="0"><table><thead><tr><th></th><th>Marker</th><th>From, s</th>'
        f"<th>Length, s</th><th>mm</th><th>Expected error, mm</th></tr></thead><tbody>{rows}"
        f"</tbody></table>{more}</div>"
        + footer(
            closing("Back"),
            button("similar_decide", "False alarms", arg="reject", classes="deed", key=False),
            button("similar_decide", "Set aside", arg="defer", classes="deed", key=False),
            button(
                "similar_decide",
                f"Accept {_in_sentence(escape(title))} for {len(found)}",
                arg="accept",
                classes="deed primary",
                key=False,
                disabled=not desk.chosen,
            ),
        )
    )


def _expected(value: float | None) -> str:
    if value is None:
        return "…"
    return number(value) if isfinite(value) else "–"


def _in_sentence(title: str) -> str:
    return title if title[:2].isupper() else title[0].lower() + title[1:]


def thresholds(desk: Desk) -> str:
    """Give a slider for each kind, with what it finds and how often that was right."""
    cells = (
        '<span class="h"></span><span class="h">Kind</span><span class="h">Fewer findings to the '
        'right</span><span class="h">Factor</span><span class="h">Found</span>'
        '<span class="h">Right so far, your decisions</span>'
    )
    for kind, style in KIND_STYLES.items():
        factor = desk.thresholds[kind]
        real, decided = desk.precision[kind]
        right = f"{real} of {decided} ({100 * real / decided:.0f} %)" if decided else "–"
        slider = (
            f'<input type="range" min="{LEAST_FACTOR}" max="{MOST_FACTOR}" step="0.05" '
            f'value="{factor}" data-do="threshold_{kind}" '
            f'aria-label="Threshold of {style.title.lower()} findings">'
        )
        if kind == "gap":
            slider, shown = '<span class="quiet">every gap is listed</span>', "–"
        else:
            shown = f"{factor:.2f}"
        cells += (
            f"<span>{glyph(kind)}</span><span>{style.title}</span><span>{slider}</span>"
            f"<span>{shown}</span><span>{desk.candidates(kind)}</span><span>{right}</span>"
        )
    n = desk.triage.n_decisions
    learning = (
        '<label class="check"><input type="checkbox" data-do="learning"'
        f"{' checked' if desk.learning else ''}> Order the queue by {n} earlier decisions as well "
        "as by damage; nothing is hidden</label>"
        if n
        else '<p class="quiet">Once takes have been decided on, their decisions can order the next.'
        "</p>"
    )
    return (
        '<header><h1 id="dialog-title">Thresholds</h1><p>The count follows at once; 1.00 is as '
        "designed. What is decided already stays.</p></header>"
        f'<div class="body"><div class="thresholds">{cells}</div><br>{learning}</div>'
        + footer(
            button(
                "run",
                "Slow changes that would be found",
                classes="deed",
                arg="slow_reach",
                key=False,
            ),
            closing("Close"),
        )
    )


def slow_reach(desk: Desk) -> str:
    """Give how small a slow change may be and still be found, the hardest markers first."""
    table = sorted(desk.slow_reach or (), key=lambda row: -row.fast_mm)
    rows = "".join(
        f"<tr><td>{escape(short(row.marker))}</td><td>{number(row.usual_mm)}</td>"
        f"<td>{number(row.fast_mm)}</td></tr>"
        for row in table
    )
    shown = (
        '<table class="named"><thead><tr><th>Marker</th><th>Half of the time, mm</th>'
        f"<th>Nine tenths, mm</th></tr></thead><tbody>{rows}</tbody></table>"
        if rows
        else '<p class="quiet">No marker here has enough others that keep their distance to it; '
        "slow changes cannot be told from movement.</p>"
    )
    return (
        '<header><h1 id="dialog-title">Slow changes that would be found</h1><p>The least amplitude '
        "of half a second, by marker: where a marker is easy to predict, and nearly "
        "everywhere. What is smaller stays unseen.</p></header>"
        f'<div class="body" tabindex="0">{shown}</div>' + footer(closing("Close"))
    )


def history(desk: Desk) -> str:
    """Give all that was done, the latest first; each line leads back to it."""
    if desk.session is None:
        return ""
    past = desk.session.history
    lines = [
        button(
            "history_go",
            f'<span class="{"" if at <= past.position else "undone"}">'
            f"{escape(step.command.describe())}</span>"
            f'<span class="quiet num">{step.at.astimezone():%H:%M:%S} '
            f"{escape(step.operator)}</span>",
            classes="",
            arg=str(at),
            key=False,
            current=at == past.position,
        )
        for at, step in list(enumerate(past.steps, 1))[::-1][:MOST_ROWS]
    ]
    lines.append(
        button(
            "history_go", "<span>As it was opened first</span>", classes="", arg="0", key=False,
            current=past.position == 0,
        )
    )  # fmt: skip
    return (
        '<header><h1 id="dialog-title">History</h1><p>Choose a line to go back to it, or on. What '
        "was undone is grey until something new is decided.</p></header>"
        f'<div class="body list" tabindex="0">{"".join(lines)}</div>' + footer(closing("Close"))
    )
