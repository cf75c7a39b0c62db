"""Who is at a take: claimed while somebody reviews it, by a lease that has to be renewed.

A claim keeps others from deciding, never from looking. It ends when it is released, when somebody
takes it over, or by itself soon after its owner fell silent. Only the clock of the store counts.
"""

from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Any

from sqlalchemy import Row, delete, insert, select, update
from sqlalchemy.exc import IntegrityError

from markermend.errors import StoreError, Taken
from markermend.review.schema import claims
from markermend.review.store import ReviewRecord, Store

LEASE_S = 90.0
"""How long a claim stands without being renewed."""
HEARTBEAT_S = 30.0
"""How often it should be renewed."""
FIRST = "review"
"""The seat of whoever reviews a take; a blinded second review has a seat of its own."""


@dataclass(frozen=True)
class Claim:
    """One person at one take.

    Attributes
    ----------
    take, seat
        What is claimed: a take has one seat for its review, and one for each second review.
    review
        Id of the review that is worked on, which may be somebody else's that was taken over.
    operator, session
        Who, and in which session.
    since, until
        When it began, and when it ends unless it is renewed.
    """

    take: str
    seat: str
    review: int
    operator: str
    session: str
    since: datetime
    until: datetime


def second_seat(operator: str) -> str:
    """Name the seat of a second review, which any number of people may make at once."""
    return f"second review of {operator}"


def claim(
    store: Store,
    record: ReviewRecord,
    operator: str,
    session: str,
    *,
    seat: str = FIRST,
    take_over: bool = False,
    lease_s: float = LEASE_S,
) -> Claim:
    """Claim a take, go on with a claim of one's own, or take one over.

    A claim that the same person made in another session passes to this one.

    Parameters
    ----------
    store
        Where it is kept.
    record
        The review that will be worked on.
    operator, session
        Who claims it, and in which session.
    seat
        `FIRST`, or a `second_seat`.
    take_over
        Claim it although somebody else has it.
    lease_s
        How long it stands without being renewed, in s.

    Raises
    ------
    Taken
        If somebody else has it.
    """
    now = store.now()
    place = (claims.c.take == record.take) & (claims.c.seat == seat)
    values: dict[str, Any] = {
        "review": record.id,
        "operator": operator,
        "session": session,
        "until": now + timedelta(seconds=lease_s),
    }
    mine = update(claims).where(place, claims.c.operator == operator, claims.c.until >= now)
    free = update(claims).where(place, claims.c.until < now)
    anyhow = update(claims).where(place)
    for _ in range(3):
        with store.transaction() as connection:
            if connection.execute(mine.values(**values)).rowcount:
                break
            open_to_me = anyhow if take_over else free
            if connection.execute(open_to_me.values(since=now, **values)).rowcount:
                break
            holder = connection.execute(select(claims).where(place)).one_or_none()
        if holder is not None:
            raise Taken(_sentence(_claim(holder)), holder.operator)
        if _inserted(store, take=record.take, seat=seat, since=now, **values):
            break
    found = store.rows(select(claims).where(place))
    if not found or found[0].session != session:
        raise Taken("Somebody else was faster; open the take again.", "somebody else")
    return _claim(found[0])


def _inserted(store: Store, **values: Any) -> bool:
    """Insert a claim, unless somebody else came in between."""
    try:
        with store.transaction() as connection:
            connection.execute(insert(claims).values(**values))
    except StoreError as error:
        if isinstance(error.__cause__, IntegrityError):
            return False
        raise
    return True


def renew(store: Store, held: Claim, lease_s: float = LEASE_S) -> Claim:
    """Say that one is still there; call it every `HEARTBEAT_S`.

    Raises
    ------
    Taken
        If somebody else has the take by now.
    """
    record = ReviewRecord(held.review, held.take, held.operator, "", "", held.since)
    return claim(store, record, held.operator, held.session, seat=held.seat, lease_s=lease_s)


def release(store: Store, held: Claim) -> None:
    """Give a take free; a claim that has passed to another session stays."""
    with store.transaction() as connection:
        connection.execute(
            delete(claims).where(
                claims.c.take == held.take,
                claims.c.seat == held.seat,
                claims.c.session == held.session,
            )
        )


def claimed(store: Store, take: str | None = None) -> tuple[Claim, ...]:
    """Give the claims that stand now, of one take or of all, the oldest first."""
    query = select(claims).where(claims.c.until >= store.now()).order_by(claims.c.since)
    if take is not None:
        query = query.where(claims.c.take == take)
    return tuple(_claim(row) for row in store.rows(query))


def _claim(row: Row[Any]) -> Claim:
    return Claim(**row._asdict())


def _sentence(held: Claim) -> str:
    return (
        f"{held.operator} has been reviewing this take since {held.since.astimezone():%H:%M}; look "
        "on, or take it over."
    )
