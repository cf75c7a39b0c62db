"""Several people on one archive: who has the take, what is not saved yet, and who decided what."""

from collections.abc import Callable, Mapping
from functools import partial
from threading import Event, Thread
from typing import Any

import param

from markermend.errors import Conflict, MarkerMendError, StoreError, Taken
from markermend.review.claims import FIRST, HEARTBEAT_S, Claim, claim, claimed, release, renew
from markermend.review.conflicts import Way, resolve, sides
from markermend.review.requests import Request, answer, ask, requests
from markermend.review.session import Change, ReviewSession
from markermend.review.store import new_token
from markermend.review.triage import Triage
from markermend_app.state.desk import Asked, Desk
from markermend_app.state.second_review import Comparing
from markermend_app.state.workspace import Opened

BEAT_S = 5.0
"""How often what is unsaved is tried again, in s."""


class Together(Comparing):
    """The desk of somebody who is not alone at the store.

    A take that somebody else has claimed may be looked at as that person decides, read-only, or
    taken over; until either is chosen, one's own review of it is on the desk.
    """

    holder: str = param.String("", doc="Who has claimed the take at hand, if somebody else.")
    looking_on: bool = param.Boolean(False, doc="Whether the holder's review is shown, read-only.")
    conflict: Conflict | None = param.Parameter(doc="What two did at once, until it is settled.")
    unsaved: tuple[str, ...] = param.Parameter((), doc="Decisions that no store has yet.")

    def __init__(self, *given: Any, **values: Any) -> None:
        super().__init__(*given, **values)
        self._token = new_token()
        self._claim: Claim | None = None
        self._ended = Event()
        self._heart: Thread | None = None

    def _opened(self, result: tuple[Opened, Triage] | Asked | str) -> None:
        ready = isinstance(result, tuple)
        ordinary = ready and self._how is None and not self._blind
        if ready:
            self._leave()
            self.param.update(holder="", looking_on=False, conflict=None, unsaved=())
        super()._opened(result)
        if ordinary and self.session is not None and self._sit(self.session):
            self._tell_of_requests(self.session)

    def _sit(self, session: ReviewSession, *, take_over: bool = False) -> bool:
        """Claim the take of a session; say who has it where somebody else has."""
        try:
            self._claim = claim(
                session.store,
                session.record,
                self.person.name,
                self._token,
                seat=FIRST,
                take_over=take_over,
            )
        except Taken as taken:
            self.holder = taken.by
            self.fail(" ".join(part for part in (str(taken), self.message) if part))
            return False
        except StoreError as error:
            self.fail(str(error))
            return False
        if self._heart is None:
            self._heart = Thread(target=self._beat, name="markermend-claim", daemon=True)
            self._heart.start()
        return True

    def _leave(self) -> None:
        """Give the take free that was at hand."""
        held, self._claim = self._claim, None
        if held is not None:
            try:
                release(self.workspace.store, held)
            except StoreError:
                return  # it ends by itself, soon

    def _beat(self) -> None:
        """Renew the claim and save what is unsaved, until the page is closed."""
        beats = 0
        while not self._ended.wait(BEAT_S):
            beats += 1
            held = self._claim
            if self.unsaved:
                self.jobs.tell(self.save)
            if held is None or beats * BEAT_S < HEARTBEAT_S:
                continue
            beats = 0
            try:
                renew(self.workspace.store, held)
            except Taken as taken:
                self._claim = None
                self.jobs.tell(partial(self._lost, taken.by, str(taken)))
            except StoreError:
                continue  # told when the next decision meets the same

    def _lost(self, by: str, sentence: str) -> None:
        self.holder = by
        self.fail(sentence)

    # second reviews

    def ask_second(self) -> None:
        """Ask who reviews this take once more; begin at once where this person was asked to."""
        if self.opened is None or self._stays():
            return
        if self._asked_of_me(self.opened.take.content_hash):
            self._hide_first()
        else:
            super().ask_second()

    def request_second(self, asked_of: str = "", note: str = "") -> None:
        """Ask somebody, or anybody else, to review the take at hand once more, blinded."""
        if self.opened is None:
            return
        self.close_dialog()
        take, name = self.opened.take.content_hash, asked_of.strip()[:80]
        try:
            ask(self.workspace.store, take, self.person.name, name or None, note=note.strip())
        except MarkerMendError as refusal:
            self.fail(str(refusal))
            return
        self.fail(f"{name or 'Everybody else'} will see that a second review is asked for.")

    def _tell_of_requests(self, session: ReviewSession) -> None:
        asked = self._asked_of_me(session.record.take)
        if asked and not self.message:
            why = f" ({asked[0].note})" if asked[0].note else ""
            self.fail(
                f"{asked[0].asked_by} asks for a second review of this take{why}; the command "
                "“second review” begins it, and hides the first until yours is finished."
            )

    def _asked_of_me(self, take: str) -> tuple[Request, ...]:
        return requests(self.workspace.store, take=take, operator=self.person.name)

    def finish_second(self) -> None:
        """Finish the second review, and with it the requests for it."""
        session = self.session if self.second else None
        super().finish_second()
        if session is None:
            return
        store, record = session.store, session.record
        try:
            for request in requests(store, take=record.take, operator=record.operator):
                answer(store, request, record.id)
        except MarkerMendError as refusal:
            self.fail(str(refusal))

    # deciding

    def _commit(self, move: Callable[[], Change | None]) -> Change | None:
        session = self.session
        assert session is not None
        if self.looking_on:
            self.fail(f"{self.holder} has this take; you look on. Take it over to decide.")
            return None

        def watched() -> Change | None:
            try:
                return move()
            except Conflict as conflict:
                self.conflict = conflict if conflict.mine else None
                raise
            except Taken as taken:
                self.holder = taken.by
                raise

        change = super()._commit(watched)
        self.unsaved = tuple(command.describe() for command in session.unsaved)
        if change is not None:
            self.conflict = None
        elif self.conflict is not None:
            own, others = sides(self.conflict)
            self.fail(
                f"{self.message} Meanwhile: {'; '.join(others)}. Yours: {'; '.join(own)}. "
                "Keep yours, take theirs, or keep both apart."
            )
        return change

    def settle(self, way: Way) -> None:
        """Settle a conflict: ``"mine"``, ``"theirs"`` or ``"both"``."""
        conflict, session = self.conflict, self.session
        if conflict is None or session is None:
            return
        try:
            after = resolve(session, conflict, way)
        except MarkerMendError as refusal:
            self.fail(str(refusal))
            return
        self.session = after
        self.param.update(conflict=None, message="")
        self._show()
        if after is not session:
            self.fail("Yours is a review of its own now; theirs is as it was.")
        self.select(self.selected or None)

    def save(self) -> None:
        """Save what was decided while the store did not answer."""
        session = self.session
        if session is not None and session.unsaved and self._commit(session.save) is not None:
            self.message = ""

    # other people

    def look_on(self) -> None:
        """See the take as the one decides who has it, read-only."""
        self._join(lambda session: None, looking_on=True)

    def take_over(self) -> None:
        """Go on with the review of the one who has the take; that person hears of it."""
        self._join(lambda session: self._sit(session, take_over=True), looking_on=False)

    def _join(self, then: Callable[[ReviewSession], object], *, looking_on: bool) -> None:
        opened, store = self.opened, self.workspace.store
        if opened is None or not self.holder or self.second:
            return
        try:
            take = opened.take.content_hash
            theirs = {one.review for one in claimed(store, take) if one.seat == FIRST}
            known = [one for one in store.reviews(take) if one.id in theirs]
            if not known:
                self.param.update(holder="", looking_on=False)
                self.fail("Nobody has this take any more; go on with your review.")
                return
            session = ReviewSession(store, known[0], self.person.name)
        except MarkerMendError as refusal:
            self.fail(str(refusal))
            return
        if then(session) is False:
            return
        self.session = session
        holder = self.holder if looking_on else ""
        self.param.update(looking_on=looking_on, holder=holder, message="", conflict=None)
        self._show()
        self.select(self._first_open())

    def close(self) -> None:
        """Stop work under way and give the take free."""
        self._ended.set()
        self._leave()
        super().close()


Fields = Mapping[str, Any]
Act = Callable[[Together, Fields], None]


def _on(act: Act) -> Callable[[Desk, Any, Fields], None]:
    """Ask it of a desk that is not alone."""

    def asked(desk: Desk, _: Any, fields: Fields) -> None:
        if isinstance(desk, Together):
            act(desk, fields)

    return asked


TEAM_INTENTIONS: Mapping[str, Callable[[Desk, Any, Fields], None]] = {
    "settle_mine": _on(lambda desk, fields: desk.settle("mine")),
    "settle_theirs": _on(lambda desk, fields: desk.settle("theirs")),
    "settle_both": _on(lambda desk, fields: desk.settle("both")),
    "save": _on(lambda desk, fields: desk.save()),
    "look_on": _on(lambda desk, fields: desk.look_on()),
    "second_request": _on(
        lambda desk, fields: desk.request_second(
            str(fields.get("operator", "")), str(fields.get("note", ""))
        )
    ),
    "take_over": _on(lambda desk, fields: desk.take_over()),
}
