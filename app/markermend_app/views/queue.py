"""The queue: open findings worst first, settled ones below; of any length."""

from collections.abc import Mapping
from html import escape
from pathlib import Path
from typing import Any

import param
from panel.custom import JSComponent

from markermend import curves
from markermend.model import Finding, short
from markermend_app.state.desk import Desk
from markermend_app.style.kinds import KIND_STYLES, glyph
from markermend_app.style.sheet import STYLESHEET
from markermend_app.views.markup import button, icon, number, spark
from markermend_app.views.part import Intent

HEAD_SHOWS = ("findings", "review", "kinds", "opened")
VERDICT_WORDS = {"accepted": "Accepted", "rejected": "False alarm", "deferred": "Set aside"}


def head(desk: Desk) -> str:
    """Give the head of the queue: how many are open, and a filter by kind."""
    queue = [f for f in desk.findings if not desk.review.decision(f).settled]
    of_kind = dict.fromkeys(KIND_STYLES, 0)
    for finding in queue:
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
    count = f"{len(queue)} open" if desk.opened else ""
    return (
        f'<div class="head"><h2>Findings</h2><span class="num quiet">{count}</span>'
        '<span class="push quiet">Worst first</span></div>'
        f'<div class="chips" role="group" aria-label="Filter by kind">{chips}</div>'
        '<div class="columns"><span></span><span>Marker</span><span>Shape</span><span>mm</span>'
        "<span>s</span><span>Damage</span></div>"
        f"{_empty(desk, len(queue))}"
    )


def _empty(desk: Desk, n_open: int) -> str:
    if desk.opened is None or desk.busy:
        return ""
    if not desk.findings:
        return '<div class="empty">Nothing found in this take.</div>'
    if not n_open:
        done = f"All {len(desk.findings)} findings are settled."
        return f'<div class="empty">{done}{button("export", "Export…", classes="tool boxed")}</div>'
    if not desk.queue:
        kind = next(iter(desk.kinds))
        clear = button("filter_kind", "Clear filter", classes="tool boxed", arg=kind, key=False)
        return f'<div class="empty">No open {kind} findings.{clear}</div>'
    return ""


def _marker(finding: Finding, aside: str = "") -> str:
    whole, name = escape(finding.marker), escape(short(finding.marker))
    return f'<span class="marker" title="{whole}">{name}{aside}</span>'


class Queue(JSComponent):
    """The list; rows are made once per finding and only sent when they change."""

    rows: list[dict[str, Any]] = param.List(default=[])
    selected = param.String(default="")

    _esm = Path(__file__).with_name("queue.js")
    _stylesheets = [STYLESHEET]  # noqa: RUF012  (Panel's own convention)

    def __init__(self, desk: Desk, intent: Intent, **params: Any) -> None:
        self._desk, self._intent = desk, intent
        self._shapes: dict[tuple[str, int, int], str] = {}
        super().__init__(rows=self._rows(), selected=desk.selected, **params)
        desk.param.watch(self._refill, ["findings", "review", "kinds"])
        desk.param.watch(self._reselect, ["selected"])

    def _refill(self, *_: object) -> None:
        rows = self._rows()
        if rows != self.rows:
            self.rows = rows

    def _reselect(self, *_: object) -> None:
        self.selected = self._desk.selected

    def _rows(self) -> list[dict[str, Any]]:
        desk = self._desk
        queue, settled = desk.queue, desk.settled
        worst = max((desk.damage(f) for f in queue), default=0.0) or 1.0
        rows = [self._open_row(f, desk.damage(f) / worst) for f in queue]
        if settled:
            rows.append({"id": "-", "divider": True, "html": f"Settled {len(settled)}"})
            rows += [self._settled_row(f) for f in settled]
        return rows

    def _open_row(self, finding: Finding, share: float) -> dict[str, Any]:
        judged = self._desk.judged(finding)
        assert self._desk.opened is not None
        seconds = len(judged.span) / self._desk.opened.take.rate
        aside = icon("deferred", 12) if judged.decision.verdict == "deferred" else ""
        html = (
            f"{glyph(judged.kind)}{_marker(finding, aside)}"
            f"{self._shape(judged.as_judged)}"
            f'<span class="value">{number(finding.amplitude)}</span>'
            f'<span class="value">{seconds:.2f}</span>'
            f'<span class="damage"><i style="width:{max(3, 100 * share**0.5):.0f}%"></i></span>'
        )
        return {"id": finding.id, "html": html, "settled": False}

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
        return {"id": finding.id, "html": html, "settled": True}

    def _shape(self, finding: Finding) -> str:
        key = (finding.id, finding.span.start, finding.span.stop)
        if key not in self._shapes:
            assert self._desk.opened is not None
            outline = curves.shape(self._desk.opened.take, finding.marker, finding.span)
            self._shapes[key] = spark(*outline, finding.kind)
        return self._shapes[key]

    def _handle_msg(self, msg: Mapping[str, Any]) -> None:
        self._intent(str(msg["do"]), msg.get("arg"), {})
