"""Who works on a page, and what that person may do."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, get_args

from markermend.errors import BadInput
from markermend.review.store import default_operator

Role = Literal["operator", "reviewer", "teacher"]
Right = Literal["decide", "adjudicate", "groups"]
ROLES: tuple[Role, ...] = get_args(Role)
RIGHTS: Mapping[Role, frozenset[Right]] = {
    "operator": frozenset({"decide"}),
    "reviewer": frozenset({"decide", "adjudicate"}),
    "teacher": frozenset({"decide", "adjudicate", "groups"}),
}
"""An operator decides on takes; a reviewer also settles what two operators decided differently; a
teacher also sees how the members of a group did."""


@dataclass(frozen=True)
class Person:
    """Who works on a page.

    Attributes
    ----------
    name
        Under which decisions are kept.
    role
        What the person is in the lab.
    signed_in
        Whether by a login, which can be ended.
    """

    name: str
    role: Role = "operator"
    signed_in: bool = False

    def may(self, what: Right) -> bool:
        """Say whether the role allows something."""
        return what in RIGHTS[self.role]


def alone() -> Person:
    """Give the person at a machine of its own, who may do everything there."""
    return Person(default_operator(), "teacher")


def as_role(given: object, who: str) -> Role:
    """Read a role.

    Raises
    ------
    BadInput
        If there is no such role.
    """
    for role in ROLES:
        if given == role:
            return role
    raise BadInput(f"{who} has the role {given!r}; roles are {', '.join(ROLES)}.")
