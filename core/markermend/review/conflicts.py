"""Two wrote to the same review: both sides are kept, and the operator says which one stands."""

from typing import Literal, get_args

from sqlalchemy import insert, select

from markermend.errors import Conflict, UnknownName
from markermend.review.commands import Command, command_from_json
from markermend.review.schema import journal
from markermend.review.session import ReviewSession
from markermend.review.store import Entry

Way = Literal["mine", "theirs", "both"]
WAYS: tuple[Way, ...] = get_args(Way)
"""Do mine after theirs; leave mine; or put mine into a review of its own."""
APART = "apart"


def mine(conflict: Conflict) -> tuple[Command, ...]:
    """Give what was not written."""
    return tuple(command for command in conflict.mine if isinstance(command, Command))


def theirs(conflict: Conflict) -> tuple[Entry, ...]:
    """Give the lines that were written in between."""
    return tuple(entry for entry in conflict.theirs if isinstance(entry, Entry))


def sides(conflict: Conflict) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Say in one line each what was not written, and what was done in between and by whom."""
    others = []
    for entry in theirs(conflict):
        what = (
            command_from_json(entry.command).describe()
            if entry.command is not None
            else {"undo": "One step back", "redo": "One step on"}.get(entry.action, entry.action)
        )
        others.append(f"{entry.operator}: {what}")
    return tuple(command.describe() for command in mine(conflict)), tuple(others)


def resolve(session: ReviewSession, conflict: Conflict, way: Way) -> ReviewSession:
    """Settle a conflict in one of three ways; nothing that was written is lost in any.

    Parameters
    ----------
    session
        The session whose write was refused; it is brought up to date.
    conflict
        The refusal.
    way
        ``"mine"``: what I did is done after theirs, and stands where both decided on the same
        finding. ``"theirs"``: what I did is given up. ``"both"``: the review stays theirs, and
        mine becomes a review of its own, from the same beginning.

    Returns
    -------
    The session to go on with: the given one, or that of the new review.

    Raises
    ------
    BadInput
        If what I did makes no sense any more after theirs; settle it another way.
    Conflict
        If somebody wrote again in between.
    UnknownName
        If there is no such way.
    """
    if way not in WAYS:
        raise UnknownName.among("way to settle a conflict", str(way), WAYS)
    session.refresh()
    if way == "mine":
        review = session.review
        for command in mine(conflict):  # all of it must make sense before any is written
            review = command.apply(review)
        for command in mine(conflict):
            session.do(command)
    if way != "both":
        return session
    apart = _branch(session, conflict)
    for command in mine(conflict):
        apart.do(command)
    return apart


def _branch(session: ReviewSession, conflict: Conflict) -> ReviewSession:
    """Begin a review that has all lines from before the conflict, and none from after it."""
    store, record = session.store, session.record
    others = theirs(conflict)
    before = others[0].seq if others else 2**31
    taken = {one.purpose for one in store.reviews(record.take) if one.operator == session.operator}
    number = 1
    while (purpose := f"{record.purpose} {APART} {number}") in taken:
        number += 1
    fresh = store.review(record.take, session.operator, purpose)
    lines = select(journal).where(journal.c.review == record.id, journal.c.seq < before)
    rows = [{**row._asdict(), "review": fresh.id} for row in store.rows(lines)]
    if rows:
        with store.transaction() as connection:
            connection.execute(insert(journal), rows)
    return ReviewSession(store, fresh, session.operator)
