"""The queue: open findings worst first, settled ones below; of any length."""

from collections.abc import Callable, Mapping
from html import escape
from pathlib import Path
from typing import Any

import param

from markermend import curves
from markermend.model import Finding, short
from markermend_app.state.desk import Desk
from markermend_app.style.kinds import KIND_STYLES, glyph
from markermend_app.style.sheet import STYLESHEET
from markermend_app.views.component import Component
from markermend_app.views.javascript import joined
from markermend_app.views.markup import button, icon, kbd, number, spark
from markermend_app.views.part import Intent

HEAD_SHOWS = (
    "findings",
    "searching",
    "review",
    "kinds",
    "opened",
    "text",
    "verdict",
    "by",
    "learning",
    "adding",
    "begun",
)
VERDICT_WORDS = {"accepted": "Accepted", "rejected": "False alarm", "deferred": "Set aside"}


def head(desk: Desk) -> str:
    """Give the head of the queue: how many are open, and the filters."""
    left = [f for f in desk.findings if not desk.review.decision(f).settled]
    of_kind = dict.fromkeys(KIND_STYLES, 0)
    for finding in left:
        of_kind[desk.judged(finding).kind] += 1
    chips = "".join(
        button(
            "filter_kind",
            f'{glyph(kind)}<span class="num">{of_kind[kind]}</span>',
            classes="chip",
            arg=kind,
            pressed=len(desk.kinds) == 1 and kind in desk.kinds,
            title=f"Only {style.title.lower()} findings",
            key=False,
        )
        for kind, style in KIND_STYLES.items()
    )
    count = f"{len(left)} open" if desk.opened else ""
    verdicts = "".join(
        f'<option value="{value}"{" selected" if value == desk.verdict else ""}>{word}</option>'
        for value, word in (("", "All settled"), *VERDICT_WORDS.items())
    )
    authors = ""
    if len(desk.authors) > 1 or desk.by:
        names = "".join(
            f'<option value="{escape(name)}"{" selected" if name == desk.by else ""}>'
            f"{escape(name)}</option>"
            for name in desk.authors
        )
        authors = (
            '<select data-do="filter_by" aria-label="Whose verdicts are listed">'
            f'<option value="">By everybody</option>{names}</select>'
        )
    learning = ""
    if desk.triage.n_decisions:
        learning = button(
            "learning",
            "Worst first" if not desk.learning else "Worst, likely first",
            title=f"Order by {desk.triage.n_decisions} earlier decisions too, or only by damage",
            pressed=desk.learning,
            key=False,
        )
    return (
        f'<div class="head"><h2>Findings</h2><span class="num quiet">{count}</span>'
        f'<span class="push quiet">{learning or "Worst first"}</span></div>'
        f'<div class="chips" role="group" aria-label="Filter by kind">{chips}</div>'
        '<div class="filter"><input type="text" name="filter" data-do="filter_text" '
        f'value="{escape(desk.text)}" aria-label="Filter by marker" placeholder="Marker" '
        f'spellcheck="false" autocomplete="off">{kbd("filter")}'
        f'<select data-do="filter_verdict" aria-label="Verdicts listed">{verdicts}</select>'
        f"{authors}</div>"
        '<div class="columns" aria-hidden="true"><span></span><span>Marker</span>'
        "<span>Shape</span><span>mm</span><span>s</span><span>Damage</span></div>"
        f"{_empty(desk, len(left))}"
    )


def foot(desk: Desk) -> str:
    """Give what can be done with the list as a whole."""
    if desk.opened is None:
        return '<div class="foot"></div>'
    add = "Drag over a lane" if desk.adding else "Add span"
    if desk.begun is not None:
        at = desk.begun / desk.opened.take.rate
        add = f"Begun at {at:.2f} s"
    return (
        '<div class="foot">'
        + button("adding", f"{add}{kbd('add_begin')}{kbd('add_end')}", key=False,
                 pressed=desk.adding, classes="tool on" if desk.adding else "tool",
                 title="Drag over a lane, or press I where a span begins and O where it ends")
        + button("thresholds", "Thresholds")
        + "</div>"
    )  # fmt: skip


def _empty(desk: Desk, n_open: int) -> str:
    if desk.opened is None:
        return "" if desk.busy else _no_take()
    if desk.searching and not n_open:
        return '<div class="empty"><b>Still looking.</b></div>'
    if not desk.findings and desk.empty:
        return f'<div class="empty">{escape(desk.empty)}</div>'
    if not desk.findings:
        return (
            '<div class="empty"><b>Nothing found at these thresholds.</b>'
            f"{button('thresholds', 'Thresholds', classes='tool boxed')}</div>"
        )
    if not n_open:
        done = f"<b>All {len(desk.findings)} findings are settled.</b>"
        return (
            f'<div class="empty">{done}<span>Look through what will change, then export.</span>'
            f"{button('export', 'Summary and export…', classes='tool boxed')}</div>"
        )
    if desk.queue or not desk.filtered:
        return ""
    what = f"{next(iter(desk.kinds))} " if len(desk.kinds) == 1 else ""
    where = f" at {escape(desk.text.strip())}" if desk.text.strip() else ""
    clear = button("filter_clear", "Clear filter", classes="tool boxed", key=False)
    return f'<div class="empty">No open {what}findings{where}.{clear}</div>'


def _no_take() -> str:
    return (
        '<div class="empty"><b>No take is open.</b><span>Drop a recording here, or choose one.'
        f"</span>{button('takes', 'Open…', classes='tool boxed')}</div>"
    )


def _marker(finding: Finding, aside: str = "") -> str:
    whole, name = escape(finding.marker), escape(short(finding.marker))
    return f'<span class="marker" title="{whole}">{name}{aside}</span>'


def _difference(
    old: list[str], new: list[str], changed: Mapping[str, dict[str, Any]]
) -> dict[str, Any]:
    """Give what a page that shows `old` has to know to show `new`: mostly one row that moves."""
    before, after = set(old), set(new)
    gone = [id_ for id_ in old if id_ not in after or id_ in changed]
    come = {id_: at for at, id_ in enumerate(new) if id_ not in before or id_ in changed}
    left = set(gone)
    if [i for i in old if i not in left] != [i for i in new if i not in come]:
        return {"ids": new, "changed": changed}
    return {"gone": gone, "come": come, "changed": changed}


class Queue(Component):
    """The list; a row is made once and sent when it changes."""

    table = param.Dict(default={"ids": [], "changed": {}}, doc="The list as it was at first.")
    selected = param.String(default="")

    _esm = joined(Path(__file__).with_name("queue.js"))
    _stylesheets = [STYLESHEET]  # noqa: RUF012  (Panel's own convention)

    def __init__(self, desk: Desk, intent: Intent, **params: Any) -> None:
        self._desk, self._intent = desk, intent
        self._shapes: dict[tuple[str, int, int], str] = {}
        self._made: dict[str, tuple[Any, dict[str, Any]]] = {}
        self._worst: tuple[Any, float] = (None, 0.0)
        rows = self._rows()
        self._sent = rows
        first = {"ids": list(rows), "changed": rows}
        super().__init__(table=first, selected=desk.selected, **params)
        desk.param.watch(
            self._refill,
            ["findings", "review", "kinds", "text", "verdict", "by", "learning", "opened"],
        )
        desk.param.watch(self._reselect, ["selected"])

    def _refill(self, *events: Any) -> None:
        if any(event.name == "opened" for event in events):
            self._shapes.clear()
            self._made.clear()
        rows, sent = self._rows(), self._sent
        changed = {key: row for key, row in rows.items() if sent.get(key) is not row}
        if changed or list(rows) != list(sent):
            self._sent = rows
            # What came in by itself; all else is an answer to the operator, who looks for it.
            late = [event.name for event in events] == ["findings"]
            self._send_msg(_difference(list(sent), list(rows), changed) | {"late": late})

    def _reselect(self, *_: object) -> None:
        self.selected = self._desk.selected

    def _rows(self) -> dict[str, dict[str, Any]]:
        desk = self._desk
        if desk.opened is None:
            return {}
        queue, settled = desk.queue, desk.settled
        if self._worst[0] is not desk.found:
            self._worst = desk.found, max((desk.damage(f) for f in desk.found), default=0.0)
        worst = self._worst[1] or 1.0
        rows = {f.id: self._row(f, lambda f: self._open_row(f, worst)) for f in queue}
        if settled:
            rows["-"] = self._divider(f"Settled {len(settled)}")
            rows |= {f.id: self._row(f, self._settled_row) for f in settled}
        return rows

    def _row(self, finding: Finding, make: Callable[[Finding], dict[str, Any]]) -> dict[str, Any]:
        """Give the row of a finding, made anew only if its decision has changed."""
        state = self._desk.review.judgements.get(finding.id)
        known = self._made.get(finding.id)
        if known is None or known[0] is not state:
            known = self._made[finding.id] = (state, make(finding))
        return known[1]

    def _divider(self, words: str) -> dict[str, Any]:
        known = self._made.get("-")
        if known is None or known[0] != words:
            known = self._made["-"] = (words, {"html": words, "divider": True, "settled": False})
        return known[1]

    def _open_row(self, finding: Finding, worst: float) -> dict[str, Any]:
        share = min(1.0, self._desk.damage(finding) / worst)
        judged = self._desk.judged(finding)
        assert self._desk.opened is not None
        seconds = len(judged.span) / self._desk.opened.take.rate
        aside = icon("deferred", 12) if judged.decision.verdict == "deferred" else ""
        aside += icon("note", 11) if judged.decision.note else ""
        html = (
            f"{glyph(judged.kind)}{_marker(finding, aside)}"
            f"{self._shape(judged.as_judged)}"
            f'<span class="value">{number(finding.amplitude)}</span>'
            f'<span class="value">{seconds:.2f}</span>'
            f'<span class="damage"><i style="width:{max(3, 100 * share**0.5):.0f}%"></i></span>'
        )
        return {"html": html, "divider": False, "settled": False}

    def _settled_row(self, finding: Finding) -> dict[str, Any]:
        judged = self._desk.judged(finding)
        verdict = judged.decision.verdict or ""
        word, sign = VERDICT_WORDS[verdict], verdict
        if judged.decision.method == "leave" and verdict == "accepted":
            word, sign = "Left as gap", "left"
        html = (
            f"{glyph(judged.kind)}{_marker(finding)}"
            f'<span class="verdict">{word}{icon(sign, 13)}</span>'
        )
        return {"html": html, "divider": False, "settled": True}

    def _shape(self, finding: Finding) -> str:
        key = (finding.id, finding.span.start, finding.span.stop)
        if key not in self._shapes:
            assert self._desk.opened is not None
            outline = curves.shape(self._desk.opened.take, finding.marker, finding.span)
            self._shapes[key] = spark(*outline, finding.kind)
        return self._shapes[key]

    def _handle_msg(self, msg: Mapping[str, Any]) -> None:
        self._intent(str(msg["do"]), msg.get("arg"), {})
