"""Second reviews that were asked for: who should look at a take once more, and what came of it."""

from dataclasses import dataclass
from datetime import datetime
from typing import Any

from sqlalchemy import Row, or_, select, update

from markermend.errors import BadInput, StoreError
from markermend.review.schema import reviews, second_reviews
from markermend.review.store import Store

LONGEST = 2000


@dataclass(frozen=True)
class Request:
    """A second review that was asked for.

    Attributes
    ----------
    id, take
        Its number, and the content hash of the take.
    asked_by, asked_of
        Who asked, and whom; None means anybody else.
    blinded
        Whether the first review is hidden until the second one is finished.
    note
        Why, in the words of the one who asked.
    at, ended
        When it was asked for, and when it was answered or taken back; None while it is open.
    ended_by, review
        Who ended it, and the review that answers it; None where it was taken back.
    """

    id: int
    take: str
    asked_by: str
    asked_of: str | None
    blinded: bool
    note: str
    at: datetime
    ended: datetime | None
    ended_by: str | None
    review: int | None


def ask(
    store: Store,
    take: str,
    asked_by: str,
    asked_of: str | None = None,
    *,
    blinded: bool = True,
    note: str = "",
) -> Request:
    """Ask for a second review of a take; asked again while it is open, the request stays one.

    Raises
    ------
    BadInput
        If nobody else is asked, or the note is too long.
    StoreError
        If the store does not know the take.
    """
    if asked_of is not None and asked_of == asked_by:
        raise BadInput(f"A second review needs somebody else; {asked_by} asks for it.")
    if len(note) > LONGEST:
        raise BadInput(f"A note has at most {LONGEST} characters; got {len(note)}.")
    if store.take(take) is None:
        raise StoreError(f"The store {store.where} does not know the take {take[:12]}; open it.")
    for known in requests(store, take=take):
        if (known.asked_by, known.asked_of, known.blinded) == (asked_by, asked_of, blinded):
            return known
    number = store.add_row(
        second_reviews,
        take=take,
        asked_by=asked_by,
        asked_of=asked_of,
        blinded=blinded,
        note=note,
        at=store.now(),
    )
    return _request(store.rows(select(second_reviews).where(second_reviews.c.id == number))[0])


def requests(
    store: Store, *, take: str | None = None, operator: str | None = None, ended: bool = False
) -> tuple[Request, ...]:
    """Give the requests, the oldest first.

    Parameters
    ----------
    store
        Where they are kept.
    take
        Only those for this take.
    operator
        Only those that this person may answer: asked of that person or of anybody, by another.
    ended
        Give those that were answered or taken back too.
    """
    table = second_reviews.c
    query = select(second_reviews).order_by(table.at, table.id)
    if take is not None:
        query = query.where(table.take == take)
    if operator is not None:
        query = query.where(
            or_(table.asked_of == operator, table.asked_of.is_(None)), table.asked_by != operator
        )
    if not ended:
        query = query.where(table.ended.is_(None))
    return tuple(_request(row) for row in store.rows(query))


def answer(store: Store, request: Request, review: int) -> None:
    """Note which review answers a request.

    Raises
    ------
    BadInput
        If it is a review of another take, or by the one who asked.
    StoreError
        If the request was ended before.
    """
    found = store.rows(select(reviews.c.take, reviews.c.operator).where(reviews.c.id == review))
    if not found or found[0].take != request.take:
        raise BadInput(f"Review {review} is none of this take; finish the one that was asked for.")
    if found[0].operator == request.asked_by:
        raise BadInput(f"{request.asked_by} asked for this review; somebody else has to make it.")
    _end(store, request, found[0].operator, review)


def take_back(store: Store, request: Request, operator: str) -> None:
    """Ask no longer.

    Raises
    ------
    BadInput
        If somebody else had asked.
    StoreError
        If the request was ended before.
    """
    if operator != request.asked_by:
        raise BadInput(f"{request.asked_by} asked for this review, and may take it back.")
    _end(store, request, operator, None)


def _end(store: Store, request: Request, by: str, review: int | None) -> None:
    now = store.now()
    with store.transaction() as connection:
        done = connection.execute(
            update(second_reviews)
            .where(second_reviews.c.id == request.id, second_reviews.c.ended.is_(None))
            .values(ended=now, ended_by=by, review=review)
        )
        if not done.rowcount:
            raise StoreError("This request has been answered or taken back; look at the list anew.")


def _request(row: Row[Any]) -> Request:
    return Request(**row._asdict())
