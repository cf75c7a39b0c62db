"""The page on which several reviews of one take are compared."""

from collections.abc import Sequence
from html import escape

from markermend.comparing import Agreement, PairAgreement, TableRow
from markermend.comparing.compared import SPAN_CLASSES
from markermend.model import short
from markermend_app.state.compared import MOST_PEOPLE, Compared
from markermend_app.state.second_review import Comparing
from markermend_app.style.kinds import KIND_STYLES, glyph
from markermend_app.views.markup import button, closing, number

MOST_ROWS = 200


def agreement(desk: Comparing) -> str:
    """Give the sheet."""
    shown = desk.compared
    if shown is None:
        return ""
    found = shown.agreement
    differ = [thing for thing in found.things if not thing.agreed]
    names = " and ".join(found.names) if len(found.names) == 2 else ", ".join(found.names)
    lead = (
        f"{len(found.things)} things were judged, {len(differ)} of them differently. "
        f"Krippendorff’s alpha is {_coefficient(found.alpha_spans)} over spans and "
        f"{_coefficient(found.alpha_samples)} over samples."
    )
    return (
        f'<header><div><h1 id="sheet-title">{escape(names)}</h1><p>{lead}</p></div>'
        f'<div class="deeds">{closing("Close")}{_adjudicate(shown)}</div></header>'
        f'<div class="columns-2"><div>{"".join(_pair(p) for p in found.pairs)}'
        f"{_table2(shown)}</div><div>{_things(found, shown)}</div></div>"
    )


def _adjudicate(shown: Compared) -> str:
    material = shown.material
    possible = material.take is not None and len(material.reviews) <= MOST_PEOPLE
    why = (
        "Needs the take: give it with --take"
        if material.take is None
        else f"At most {MOST_PEOPLE} reviews stand side by side"
    )
    return button(
        "adjudicate",
        "Adjudicate…",
        classes="deed primary",
        key=False,
        disabled=not possible,
        title="Make a new review of both" if possible else why,
    )


def _pair(pair: PairAgreement) -> str:
    one, other = (escape(name) for name in pair.names)
    both = "" if pair.found_by_both is None else f" ({pair.found_by_both:.0%} of all)"
    rows = [
        (f"Accepted by {one}, by {other}", f"{pair.accepted[0]}, {pair.accepted[1]}"),
        ("Accepted by both", f"{pair.both}{both}"),
        ("of these as the same kind", f"{pair.same_kind}"),
        ("Their edges agree to", "–" if pair.iou is None else f"{pair.iou:.0%}"),
        ("Cohen’s kappa over spans", _coefficient(pair.kappa_spans)),
        ("Cohen’s kappa over samples", _coefficient(pair.kappa_samples)),
    ]
    apart = pair.difference
    if apart is not None:
        if apart.mean_mm is not None and apart.where is not None:
            marker, frame = apart.where
            rows += [
                ("Repaired trajectories apart, mean", f"{number(apart.mean_mm)} mm"),
                (
                    f"at most, at {escape(short(marker))} in frame {frame}",
                    f"{number(apart.largest_mm)} mm",
                ),
            ]
        rows.append(("Samples that either changed", f"{apart.samples:,}"))
        rows.append(("Samples that one alone filled", f"{apart.only_one:,}"))
    listed = "".join(f"<tr><th>{word}</th><td>{value}</td></tr>" for word, value in rows)
    return (
        f"<section><h2>{one} and {other}</h2><table class=facts>{listed}</table>"
        f"<h3>What {one} called it (down) and {other} (across)</h3>"
        f"{cross(SPAN_CLASSES, SPAN_CLASSES, pair.spans)}</section>"
    )


def cross(rows: Sequence[str], columns: Sequence[str], counts: Sequence[Sequence[int]]) -> str:
    """Give a table of counts: what agrees lies on the diagonal and is set bold."""
    head = "".join(f"<th>{_word(name)}</th>" for name in columns)
    body = "".join(
        f"<tr><th>{_word(row)}</th>"
        + "".join(
            f'<td class="{"same" if row == column else ""}{"" if n else " none"}">{n}</td>'
            for column, n in zip(columns, line, strict=True)
        )
        + "</tr>"
        for row, line in zip(rows, counts, strict=True)
    )
    return (
        f"<table class=cross><thead><tr><th></th>{head}</tr></thead><tbody>{body}</tbody></table>"
    )


def _word(name: str) -> str:
    for kind, style in KIND_STYLES.items():
        if kind == name:
            return f'<span class="kind">{glyph(kind)}{style.title}</span>'
    return escape(name.capitalize())


def _table2(shown: Compared) -> str:
    found = shown.agreement
    if found.table2 is None:
        rows, said = (
            found.own,
            ("Everybody’s own verdicts on what the detector showed on the take as recorded."),
        )
    else:
        rows, said = (
            found.table2,
            (f"The detector on everybody’s repaired version, held against that of {shown.expert}."),
        )
    choices = ""
    if shown.material.take is not None:
        choices = "".join(
            button(
                "agreement_expert", f"Against {escape(name)}", classes="", arg=name, key=False,
                pressed=name == shown.expert,
                title=f"Take the version of {name} for right: this searches every version",
            )
            for name in found.names
        )  # fmt: skip
        choices = f'<span class="choice" role="group" aria-label="Reference">{choices}</span>'
    head = f"<h2>Human and algorithm</h2><p>{escape(said)} {choices}</p>"
    return f"<section>{head}{_rows(rows)}</section>"


def _rows(rows: Sequence[TableRow]) -> str:
    body = "".join(
        f"<tr><th>{escape(r.operator)}</th><td>{r.human}</td><td>{r.algorithm}</td>"
        f"<td>{r.approved}</td><td>{r.rejected}</td><td>{r.missed}</td></tr>"
        for r in rows
    )
    return (
        "<table class=wide><thead><tr><th>Operator</th><th>Human</th><th>Algorithm</th>"
        f"<th>Approved</th><th>Rejected</th><th>Missed</th></tr></thead><tbody>{body}</tbody></table>"
    )


def _things(found: Agreement, shown: Compared) -> str:
    take = shown.material.take
    head = "".join(f"<th>{escape(name)}</th>" for name in found.names)
    ordered = sorted(found.things, key=lambda thing: (thing.agreed, -(thing.apart_mm or 0.0)))
    body = "".join(
        f'<tr class="{"agreed" if thing.agreed else ""}"><th>{escape(short(thing.marker))}</th>'
        f"<td>{_when(thing.span.start, thing.span.stop, None if take is None else take.rate)}</td>"
        + "".join(f"<td>{_word(said) if said else 'open'}</td>" for said in thing.said)
        + f"<td>{'–' if thing.apart_mm is None else number(thing.apart_mm)}</td></tr>"
        for thing in ordered[:MOST_ROWS]
    )
    more = len(ordered) - MOST_ROWS
    return (
        "<section><h2>Everything that was judged</h2><p>What differs comes first, the farthest "
        "apart at the top.</p><table class=wide><thead><tr><th>Marker</th><th>"
        f"{'Frames' if take is None else 'Seconds'}</th>{head}<th>mm apart</th></tr></thead>"
        f"<tbody>{body}</tbody></table>{f'<p>and {more} more</p>' if more > 0 else ''}</section>"
    )


def _when(start: int, stop: int, rate: float | None) -> str:
    if rate is None:
        return f"{start}–{stop - 1}"
    return f"{start / rate:.2f}–{stop / rate:.2f}"


def _coefficient(value: float | None) -> str:
    return "–" if value is None else f"{value:.2f}"
