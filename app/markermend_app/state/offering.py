"""What is offered for the finding at hand: repairs, their expected errors, the recommended one."""

import time
from collections import OrderedDict
from collections.abc import Generator
from contextlib import closing
from typing import Any

import param

from markermend.model import Span
from markermend.repairing import Repair, Wish
from markermend.repairing.compare import Row
from markermend.review import Choose, Judgement
from markermend_app.state import computing, previews
from markermend_app.state.jobs import Ticket
from markermend_app.state.looking import Looking
from markermend_app.state.previews import Offer, Preview
from markermend_app.state.workspace import Opened

REFRESH_S = 0.3
"""How often the table of repairs is drawn anew while it fills."""
REST_S = 0.15
"""An operator who goes on sooner than this is not kept waiting by comparisons."""
KEPT = 24
"""Findings whose comparison is remembered."""
Key = tuple[str, Span, str, tuple[tuple[str, Span], ...]]


class Offering(Looking):
    """The table of repairs and the choice in it."""

    previews: tuple[Preview, ...] = param.Parameter((), doc="Repairs of the selected.")
    chosen: str = param.String("", doc="Name of the repair chosen for the selected finding.")
    repair: Repair | None = param.Parameter(doc="The chosen repair, once it is computed.")
    best: str = param.String("", doc="Name of the repair that is recommended here.")
    why: str = param.String("", doc="Why it is recommended, in a sentence.")
    comparing: str = param.String("", doc="Name of the method being compared, or empty.")
    mended: dict[Any, Repair] = param.Parameter({}, doc="Accepted repairs that are computed.")
    refused_shown: bool = param.Boolean(False, doc="Whether methods that do not apply are listed.")

    def __init__(self, *given: Any, **values: Any) -> None:
        super().__init__(*given, **values)
        self._known: OrderedDict[Key, Offer] = OrderedDict()
        self.param.watch(lambda *_: self._mend(), ["review"])

    def _forget(self) -> None:
        """Let go of what was offered of another take."""
        self._known.clear()
        self._undecided.clear()
        self.mended = {}

    def _masked(self, but: str) -> tuple[tuple[str, Span], ...]:
        return tuple(
            (judgement.finding.marker, judgement.span)
            for key, judgement in self.review.judgements.items()
            if key != but and judgement.decision.verdict == "accepted" and not judgement.replaced_by
        )

    def _key(self, judged: Judgement, masked: tuple[tuple[str, Span], ...]) -> Key:
        assert self.opened is not None
        here = f"{self.opened.take.content_hash} {judged.finding.id}"
        return here, judged.span, judged.kind, tuple(sorted(masked))

    def _offer(self) -> None:
        """Begin to fill the table for the finding at hand; what is known is there at once."""
        opened, current = self.opened, self.current
        self.jobs.cancel("compare")
        self.jobs.cancel("prepare")
        if opened is None or current is None:
            return
        judged, masked = self.judged(current), self._masked(current.id)
        key = self._key(judged, masked)
        known = self._known.get(key)
        if known is not None:
            self._known.move_to_end(key)
            self._offered(known)
            self._prepare()
            return

        def first(_: Ticket) -> Offer:
            rows = previews.at_hand(opened.take, judged, masked, self.workspace.methods)
            return previews.recommended(rows, judged, complete=False)

        def begin(offer: Offer) -> None:
            self._offered(offer)
            names = previews.quick(offer.rows)
            self._compare(opened, judged, masked, offer.rows, names)

        self.jobs.run("preview", first, begin, patience_s=self.workspace.patience_s)

    def _compare(
        self,
        opened: Opened,
        judged: Judgement,
        masked: tuple[tuple[str, Span], ...],
        rows: tuple[Preview, ...],
        names: tuple[str, ...],
    ) -> None:
        key = self._key(judged, masked)

        def work(ticket: Ticket) -> Offer | None:
            time.sleep(REST_S)
            if not ticket.valid():
                return None
            shown, offer = time.monotonic(), None
            with closing(self._computed(opened, judged, masked, names)) as computed:
                for offer in previews.compared(computed, judged, rows, len(names)):
                    if not ticket.valid():
                        return None
                    if time.monotonic() - shown > REFRESH_S and not offer.complete:
                        shown = time.monotonic()
                        ticket.tell(lambda offer=offer: self._offered(offer))  # type: ignore[misc]
            return offer

        def done(offer: Offer | None) -> None:
            self.comparing = ""
            if offer is not None:
                self._remember(key, offer)
                self._offered(offer)
                self._prepare()

        self.comparing = names[0] if len(names) == 1 else "all"
        self.jobs.run("compare", work, done)

    def _computed(
        self,
        opened: Opened,
        judged: Judgement,
        masked: tuple[tuple[str, Span], ...],
        names: tuple[str, ...],
    ) -> Generator[Row]:
        """Give what each method does, computed beside the server."""
        worker = self.workspace.worker
        return worker.stream(computing.rows, worker.lend(opened.take), judged.wish, masked, names)

    def fail(self, sentence: str) -> None:
        """Say what went wrong; nothing is being compared any more."""
        self.comparing = ""
        super().fail(sentence)

    def try_slow(self, method: str) -> None:
        """Compute and compare a method that takes long, because the operator asks for it."""
        row = next((p for p in self.previews if p.name == method and p.slow), None)
        if row is None or self.current is None or self.opened is None or self.comparing:
            return
        judged, masked = self.judged(self.current), self._masked(self.selected)
        self._compare(self.opened, judged, masked, self.previews, (method,))

    def _prepare(self) -> None:
        """Compare what comes next while the operator looks; the queue says what that is."""

    def _remember(self, key: Key, offer: Offer) -> None:
        self._known[key] = offer
        while len(self._known) > KEPT:
            self._known.popitem(last=False)

    def _offered(self, offer: Offer) -> None:
        if self.current is None:
            return
        ready = {p.name for p in offer.rows if p.repair is not None}
        mine = self.judged(self.current).decision.method
        # While errors are still being measured, what was chosen at first stays: nothing changes
        # under the hand that is about to accept it.
        stays = mine if mine in ready else (self.chosen if not offer.complete else "")
        chosen = stays if stays in ready else offer.best or self.chosen
        with param.parameterized.batch_call_watchers(self):
            self.param.update(previews=offer.rows, best=offer.best, why=offer.why, chosen=chosen)
            self._pick_repair()

    def _pick_repair(self) -> None:
        """Say which repair is shown, only where that changes."""
        chosen = next((p.repair for p in self.previews if p.name == self.chosen), None)
        if chosen is not self.repair:
            self.repair = chosen

    def _mend(self) -> None:
        """Compute what was accepted, for the eye; an export computes everything anew."""
        opened = self.opened
        if opened is None:
            return
        wishes = {_wished(wish): wish for wish in self.review.accepted() if wish.method != "leave"}
        kept = {key: done for key, done in self.mended.items() if key in wishes}
        if kept != self.mended:
            self.mended = kept
        todo = [wish for key, wish in wishes.items() if key not in kept]
        if not todo:
            self.jobs.cancel("mend")
            return
        masked = self.accepted

        def work(ticket: Ticket) -> dict[Any, Repair]:
            worker, shown, mended = self.workspace.worker, time.monotonic(), {}
            for wish in todo:
                if not ticket.valid():
                    break
                done = worker.call(computing.mended, worker.lend(opened.take), wish, masked)
                if done is None:
                    continue
                mended[_wished(wish)] = done
                if time.monotonic() - shown > REFRESH_S:
                    shown, sofar = time.monotonic(), dict(mended)
                    ticket.tell(lambda sofar=sofar: self._mended(sofar))  # type: ignore[misc]
            return mended

        self.jobs.run("mend", work, self._mended)

    def _mended(self, done: dict[Any, Repair]) -> None:
        if done:
            self.mended = self.mended | done

    def choose(self, method: str) -> None:
        """Choose a repair for the finding at hand; the choice is kept."""
        if self.current is None or not any(p.name == method and p.repair for p in self.previews):
            return
        self.chosen = method
        self._pick_repair()
        self.do(Choose((self.current,), method))

    def choose_by(self, step: int) -> None:
        """Choose the next or previous repair that is ready."""
        ready = [p.name for p in self.previews if p.repair is not None]
        if ready:
            at = ready.index(self.chosen) + step if self.chosen in ready else 0
            self.choose(ready[at % len(ready)])

    def choose_recommended(self) -> None:
        """Choose the repair that is recommended here."""
        if self.best:
            self.choose(self.best)


def _wished(wish: Wish) -> tuple[str, Span, str]:
    return wish.marker, wish.span, wish.method
