"""How large a take may be, so that a hostile file is refused before it fills the memory."""

from markermend.errors import UnreadableTake

MOST_SAMPLES = 100_000_000
"""Frames times points: 2.4 GB of positions, 60 markers at 100 Hz for four and a half hours."""

MOST_POINTS = 20_000


def check_size(n_frames: int, n_points: int) -> None:
    """Refuse what is beyond the limits.

    Raises
    ------
    UnreadableTake
        If there are too many points or samples.
    """
    if n_points > MOST_POINTS or n_frames * n_points > MOST_SAMPLES:
        raise UnreadableTake(
            f"{n_frames} frames of {n_points} points are more than the {MOST_SAMPLES:.0e} samples "
            f"of {MOST_POINTS} points that one take may have; cut the recording into parts."
        )
