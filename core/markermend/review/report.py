"""A report of a reviewed take: one HTML page that needs nothing else, with tables and pictures."""

from collections.abc import Iterable, Mapping
from datetime import datetime
from html import escape as escaped

import numpy as np

from markermend import curves
from markermend.errors import legible
from markermend.model import KINDS, Finding, FloatArray, Span, Take
from markermend.repairing import REPAIRS, Refusal, Repair
from markermend.review.session import Step
from markermend.review.state import Judgement, Review

MOST_PICTURES = 60
WIDTH, HEIGHT = 660, 120
COLOURS = {
    "gap": "#9A0088",
    "peak": "#B93004",
    "noise": "#A77F19",
    "step": "#38988D",
    "slow": "#674D83",
}
WORDS = {"accepted": "Accepted", "rejected": "False alarm", "deferred": "Set aside", None: "Open"}
STYLE = """
body{font:14px/1.45 system-ui,"Segoe UI",Roboto,sans-serif;color:#1a1d21;max-width:980px;
margin:32px auto;padding:0 20px}h1{font-size:24px;margin:0 0 4px}h2{font-size:17px;
margin:32px 0 8px}
p{margin:4px 0}.quiet{color:#4f5762}table{border-collapse:collapse;width:100%;
font-variant-numeric:tabular-nums}th{font-weight:400;color:#4f5762;font-size:12px}
h1,td,figcaption,p{unicode-bidi:isolate}
th,td{text-align:right;padding:5px 8px;border-bottom:1px solid #e2e5ea}
th:nth-child(-n+2),td:nth-child(-n+2){text-align:left}figure{margin:20px 0;break-inside:avoid}
figcaption{margin-bottom:4px}svg{background:#fff;border:1px solid #e2e5ea;max-width:100%}
i{display:inline-block;width:10px;height:10px;border-radius:2px;margin-right:6px}
"""


def report(
    take: Take,
    review: Review,
    findings: Iterable[Finding],
    repairs: Iterable[Repair],
    refusals: Iterable[Refusal] = (),
    *,
    name: str,
    written: Iterable[str] = (),
    decided: Mapping[str, Step] | None = None,
    at: datetime | None = None,
) -> str:
    """Give the report as HTML.

    Parameters
    ----------
    take
        As recorded.
    review, findings
        The decisions, and everything that there was to decide on.
    repairs, refusals
        What was computed for the accepted ones, and what no method could do.
    name
        Of the take, for the title.
    written
        Sentences on the file that was written, or none.
    decided
        Finding id -> the last step on it; see `ReviewSession.decided`.
    at
        When the report is made; by default now.
    """
    judged = [review.judgement(f) for f in findings]
    judged.sort(key=lambda j: (j.span, j.finding.marker))
    done = {(r.marker, r.span): r for r in repairs}
    steps = decided or {}
    made = (at or datetime.now().astimezone()).strftime("%Y-%m-%d %H:%M")
    facts = (
        f"{len(take.measured)} markers, {take.n_frames} frames at {take.rate:g} Hz "
        f"({take.duration_s:.1f} s)"
    )
    parts = [
        f"<h1>{escape(name)}</h1><p class='quiet'>{facts}. Report of {made}.</p>",
        *(f"<p>{escape(line)}</p>" for line in written),
        "<h2>Findings</h2>",
        _counts(judged),
        "<h2>Decisions</h2>",
        _decisions(take, judged, done, steps),
    ]
    refused = [f"{r.wish.marker} {r.wish.kind}: {r.reason}" for r in refusals]
    if refused:
        parts += ["<h2>Could not be repaired</h2>", *(f"<p>{escape(r)}</p>" for r in refused)]
    shown = [j for j in judged if (j.finding.marker, j.span) in done]
    if shown:
        parts.append("<h2>Repairs</h2>")
        parts += [_figure(take, j, done[j.finding.marker, j.span]) for j in shown[:MOST_PICTURES]]
    if len(shown) > MOST_PICTURES:
        parts.append(f"<p>{len(shown) - MOST_PICTURES} more repairs are in the table only.</p>")
    return (
        '<!doctype html><html lang="en"><head><meta charset="utf-8">'
        '<meta http-equiv="Content-Security-Policy" '
        "content=\"default-src 'none'; style-src 'unsafe-inline'\">"
        f"<title>{escape(name)}: review</title><style>{STYLE}</style></head>"
        f"<body>{''.join(parts)}</body></html>"
    )


def _counts(judged: list[Judgement]) -> str:
    rows = []
    for kind in KINDS:
        own = [j for j in judged if j.kind == kind]
        cells = [sum(j.decision.verdict == verdict for j in own) for verdict in WORDS]
        numbers = "".join(f"<td>{n}</td>" for n in (len(own), *cells))
        rows.append(f"<tr><td>{_dot(kind)}</td><td>{kind}</td>{numbers}</tr>")
    heads = "".join(f"<th>{word}</th>" for word in ("Found", *WORDS.values()))
    return f"<table><tr><th></th><th>Kind</th>{heads}</tr>{''.join(rows)}</table>"


def _decisions(
    take: Take,
    judged: list[Judgement],
    done: Mapping[tuple[str, Span], Repair],
    steps: Mapping[str, Step],
) -> str:
    rows = []
    for judgement in judged:
        decision, span = judgement.decision, judgement.span
        if decision.verdict is None and not decision.note:
            continue
        repair = done.get((judgement.finding.marker, span))
        method = REPAIRS.get(repair.method).title if repair else ""
        change = repair.largest_change(take) if repair else None
        step = steps.get(judgement.finding.id)
        who = f"{step.operator} {step.at.astimezone():%Y-%m-%d %H:%M}" if step else ""
        cells = (
            escape(judgement.finding.marker),
            judgement.kind,
            f"{span.start / take.rate:.2f}",
            f"{len(span)}",
            WORDS[decision.verdict],
            escape(method),
            _mm(change),
            _mm(repair.expected_mm if repair else None),
            escape(decision.note),
            escape(who),
        )
        rows.append("<tr>" + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>")
    heads = (
        "Marker", "Kind", "From, s", "Frames", "Verdict", "Repair", "Largest change, mm",
        "Expected error, mm", "Note", "By",
    )  # fmt: skip
    head = "".join(f"<th>{h}</th>" for h in heads)
    return f"<table><tr>{head}</tr>{''.join(rows)}</table>"


def _figure(take: Take, judgement: Judgement, repair: Repair) -> str:
    """Draw the axis on which the repair changes most, as recorded and as repaired."""
    span = repair.span
    wide = span.padded(max(len(span), 20), take.n_frames)
    own = take.positions[wide.frames, take.index(repair.marker)]
    mended = np.full(own.shape, np.nan)
    mended[span.start - wide.start : span.stop - wide.start] = repair.values
    either = np.where(np.isfinite(mended), mended, own)
    spread = np.zeros(take.n_dims)
    if np.isfinite(either).any():
        spread = np.nanmax(either, axis=0) - np.nanmin(either, axis=0)
    axis = int(np.argmax(spread))
    low, high = (
        (float(f(np.concatenate([own[:, axis], mended[:, axis]]))) for f in (np.nanmin, np.nanmax))
        if np.isfinite(either).any()
        else (0.0, 1.0)
    )
    x0, x1 = (_x(frame, wide) for frame in (span.start - 0.5, span.stop - 0.5))
    colour = COLOURS[judgement.kind]
    said = (
        f"{escape(repair.marker)} {judgement.kind}, {span.start / take.rate:.2f} to "
        f"{span.stop / take.rate:.2f} s: {escape(REPAIRS.get(repair.method).title)}. "
        f"{escape(repair.note)}"
    )
    return (
        f"<figure><figcaption>{_dot(judgement.kind)}{said}</figcaption>"
        f'<svg width="{WIDTH}" height="{HEIGHT}" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" '
        f'aria-label="{said}"><rect x="{x0:.1f}" y="0" width="{x1 - x0:.1f}" height="{HEIGHT}" '
        f'fill="{colour}" opacity=".12"/>'
        f'<path d="{_path(own[:, axis], low, high)}" fill="none" stroke="#1a1d21"/>'
        f'<path d="{_path(mended[:, axis], low, high)}" fill="none" stroke="#1f5fe0" '
        f'stroke-width="2"/><text x="6" y="14" font-size="11" fill="#4f5762">'
        f"{'xyz'[axis]}, {low:.0f} to {high:.0f} {take.units}</text></svg></figure>"
    )


def _x(frame: float, wide: Span) -> float:
    return float((frame - wide.start) / max(1, len(wide) - 1) * WIDTH)


def _path(values: FloatArray, low: float, high: float) -> str:
    at, thin = curves.thinned(values[:, None], 2 * WIDTH)
    pieces, pen = [], False
    for place, value in zip(at, thin[:, 0], strict=True):
        if not np.isfinite(value):
            pen = False
            continue
        x = place / max(1, len(values) - 1) * WIDTH
        y = HEIGHT - 10 - (value - low) / max(high - low, 1e-9) * (HEIGHT - 30)
        pieces.append(f"{'L' if pen else 'M'}{x:.1f} {y:.1f}")
        pen = True
    return "".join(pieces)


def _dot(kind: str) -> str:
    return f'<i style="background:{COLOURS[kind]}"></i>'


def _mm(value: float | None) -> str:
    return "–" if value is None else f"{value:.1f}" if value < 10 else f"{value:.0f}"


def escape(text: str) -> str:
    """Give a text that came from a file or an operator as HTML: no tag, nothing unseen."""
    return escaped(legible(text))
