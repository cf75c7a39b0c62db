"""The queue: which findings are listed, in which order, and how far the operator has come."""

import time
from collections.abc import Mapping
from contextlib import closing
from itertools import pairwise
from statistics import median
from typing import Any

import param

from markermend.model import KINDS, Finding, Kind, short
from markermend.review.queue import damage, worst_first
from markermend.review.triage import NOTHING_LEARNT, Triage
from markermend_app.state import previews
from markermend_app.state.jobs import Ticket
from markermend_app.state.offering import REST_S, Offering

PAUSE_S = 120.0
"""A decision that took longer was interrupted and does not count for the pace."""
FILTERS = ("accepted", "rejected", "deferred")


class Queueing(Offering):
    """What is listed and how the operator moves in it."""

    kinds: frozenset[Kind] = param.Parameter(frozenset(KINDS), doc="Kinds that the queue lists.")
    text: str = param.String("", doc="Part of a marker's name that the queue lists.")
    verdict: str = param.Selector(default="", objects=["", *FILTERS], doc="Settled ones listed.")
    by: str = param.String("", doc="Whose verdicts are listed, or empty for everybody's.")
    triage: Triage = param.Parameter(NOTHING_LEARNT, doc="What earlier decisions teach.")
    learning: bool = param.Boolean(True, doc="Whether the order takes earlier decisions in.")

    def __init__(self, *given: Any, **values: Any) -> None:
        super().__init__(*given, **values)
        self._ordered: tuple[Any, tuple[Finding, ...]] = ((), ())
        self._damages: tuple[tuple[Any, ...], Any, tuple[Finding, ...]] = ((None,) * 4, None, ())
        self._arrived: set[str] = set()
        self._authors: tuple[Any, dict[str, str]] = (None, {})

    @property
    def queue(self) -> tuple[Finding, ...]:
        """Open findings that pass the filters, worst first; those set aside come last."""
        if self.opened is None:
            return ()
        state = (self.review, self.findings, self.kinds, self.text, self.triage, self.learning)
        if len(self._ordered[0]) != len(state) or any(
            a is not b for a, b in zip(self._ordered[0], state, strict=True)
        ):
            self._ordered = (state, self._sorted())
        return self._ordered[1]

    def _sorted(self) -> tuple[Finding, ...]:
        judged = [(f, self.judged(f).decision) for f in self._by_damage()]
        listed = [(f, d.verdict) for f, d in judged if not d.settled and self.lists(f)]
        aside = [f for f, verdict in listed if verdict == "deferred"]
        return (*(f for f, verdict in listed if verdict != "deferred"), *aside)

    def _by_damage(self) -> tuple[Finding, ...]:
        """Order all findings; a verdict changes nothing in it, another kind or span does."""
        assert self.opened is not None
        moved = [
            (key, judgement.decision.kind, judgement.decision.span)
            for key, judgement in self.review.judgements.items()
            if judgement.decision.kind is not None or judgement.decision.span is not None
        ]
        state = (self.opened, self.findings, self.triage, self.learning)
        known = self._damages
        if known[1] != moved or any(a is not b for a, b in zip(known[0], state, strict=True)):
            take = self.opened.take
            order = worst_first(
                self.review, self.findings, take.rate, n_frames=take.n_frames, weight=self.weight
            )
            self._damages = known = (state, moved, order)
        return known[2]

    def weight(self, finding: Finding) -> float:
        """How likely the operator is to accept a finding, by what was decided before."""
        return self.triage.real(finding) if self.learning else 1.0

    def lists(self, finding: Finding) -> bool:
        """Whether a finding passes the filters by kind and by name."""
        wanted = self.text.strip().lower()
        return self.judged(finding).kind in self.kinds and (
            not wanted or wanted in short(finding.marker).lower()
        )

    @property
    def settled(self) -> tuple[Finding, ...]:
        """Findings with a verdict that pass the filters, in the order of decision."""
        order = {key: i for i, key in enumerate(self.review.judgements)}
        done = [
            f
            for f in self.findings
            if f.id in order
            and (
                self.review.decision(f).verdict == self.verdict
                if self.verdict
                else self.review.decision(f).settled
            )
            and self.lists(f)
            and self.by in ("", self.author(f))
        ]
        return tuple(sorted(done, key=lambda f: order[f.id]))

    def author(self, finding: Finding) -> str:
        """Name of who decided on a finding last, or empty."""
        if self.session is None:
            return ""
        if self._authors[0] is not self.review:
            decided = self.session.decided
            self._authors = self.review, {key: step.operator for key, step in decided.items()}
        return self._authors[1].get(finding.id, "")

    @property
    def authors(self) -> tuple[str, ...]:
        """Everybody who has decided on a finding of this take."""
        found = {self.author(f) for f in self.findings if self.review.decision(f).verdict}
        return tuple(sorted(found - {""}))

    @property
    def filtered(self) -> bool:
        """Whether something is hidden from the list."""
        return bool(self.text.strip() or self.verdict or self.by) or self.kinds != frozenset(KINDS)

    def damage(self, finding: Finding) -> float:
        """Expected damage in mm s, the order of the queue."""
        assert self.opened is not None
        return damage(self.judged(finding).as_judged, self.opened.take.rate)

    def select(self, finding: Finding | str | None) -> None:
        """Put a finding at hand: centred, zoomed, its repairs computed."""
        wanted = finding.id if isinstance(finding, Finding) else finding or ""
        found = self.find(wanted)
        if found is None or self.opened is None:
            self.jobs.cancel("preview")
            self.jobs.cancel("compare")
            self.jobs.cancel("prepare")
            self.param.update(
                selected="", previews=(), chosen="", best="", why="", comparing="", repair=None
            )
            return
        judged = self.judged(found)
        self._arrived.discard(found.id)
        with param.parameterized.batch_call_watchers(self):
            self.param.update(
                selected=found.id,
                marker=found.marker,
                zoom="span",
                relative=None,
                # Exchanged labels show in the lengths to what is beside them.
                signal="distance" if found.partner else "residual",
                frame=judged.span.start + len(judged.span) // 2,
                previews=(),
                best="",
                why="",
                comparing="",
                repair=None,
                chosen=judged.decision.method,
            )
            self._fit_window()
            self._offer()

    def select_marker(self, marker: int) -> None:
        """Put a marker at hand, with its finding that is nearest to the playhead if it has one."""
        if self.opened is None or not 0 <= marker < self.opened.take.n_markers:
            return
        label = self.opened.take.labels[marker]
        own = [f for f in self.findings if f.marker == label]
        if own:
            self.select(min(own, key=lambda f: abs(f.span.start - self.frame)))
        else:
            self.select(None)
            self.marker = label
            self._fit_window()

    def next(self) -> None:
        """Go to the next open finding."""
        self._step(1)

    def previous(self) -> None:
        """Go to the previous open finding."""
        self._step(-1)

    def _step(self, by: int) -> None:
        queue = self.queue
        if not queue:
            return
        ids = [f.id for f in queue]
        at = ids.index(self.selected) + by if self.selected in ids else 0
        self.select(queue[at % len(queue)])

    def _first_open(self) -> Finding | None:
        queue = self.queue
        return queue[0] if queue else None

    def toggle_kind(self, kind: Kind) -> None:
        """List only this kind, or all again."""
        only = frozenset({kind})
        self.kinds = frozenset(KINDS) if self.kinds == only else only

    def clear_filters(self) -> None:
        """List everything again."""
        self.param.update(kinds=frozenset(KINDS), text="", verdict="", by="")

    def _prepare(self) -> None:
        """Compare the next findings, as they will be once the one at hand is accepted."""
        opened, current = self.opened, self.current
        ids = [f.id for f in self.queue]
        if opened is None or current is None or current.id not in ids:
            return
        at = ids.index(current.id) + 1
        mine = (current.marker, self.judged(current).span)
        todo = []
        for finding in self.queue[at : at + self.workspace.ahead]:
            judged = self.judged(finding)
            masked = tuple({*self._masked(finding.id), mine})
            key = self._key(judged, masked)
            if key not in self._known:
                todo.append((key, judged, masked))

        def work(ticket: Ticket) -> None:
            for key, judged, masked in todo:
                time.sleep(REST_S)
                if not ticket.valid():
                    return
                rows = previews.at_hand(opened.take, judged, masked, self.workspace.methods)
                names = previews.quick(rows)
                with closing(self._computed(opened, judged, masked, names)) as computed:
                    for offer in previews.compared(computed, judged, rows, len(names)):
                        if not ticket.valid():
                            return
                        if offer.complete:
                            ticket.tell(lambda k=key, o=offer: self._remember(k, o))  # type: ignore[misc]

        if todo:
            self.jobs.run("prepare", work, lambda _: None)

    @property
    def pace_s(self) -> float | None:
        """Median time per decision, or None before there are three to tell it by."""
        if self.session is None:
            return None
        history = self.session.history
        times = [
            step.at
            for step in history.steps[: history.position][-200:]
            if step.command.name in ("accept", "reject", "defer")
        ]
        took = [(b - a).total_seconds() for a, b in pairwise(times)]
        took = [s for s in took if s < PAUSE_S]
        return median(took) if len(took) > 1 else None

    @property
    def precision(self) -> Mapping[Kind, tuple[int, int]]:
        """Of each kind: accepted, and accepted or rejected; the operator's own decisions."""
        counts = {kind: [0, 0] for kind in KINDS}
        for finding in self.findings:
            decision = self.review.decision(finding)
            if finding.detector != "operator" and decision.settled:
                counts[finding.kind][1] += 1
                counts[finding.kind][0] += decision.verdict == "accepted"
        return {kind: (real, all_) for kind, (real, all_) in counts.items()}
