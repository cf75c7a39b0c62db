"""How far a detector has come, for those who wait."""

from collections.abc import Callable

Progress = Callable[[int, int], None]
"""Called with how much is done, and of how much."""


def unheard(done: int, total: int) -> None:
    """Tell nobody."""
