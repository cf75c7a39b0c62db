"""A check without any model: one marker's distances jump while its mates keep theirs.

Recordings that are called clean are not always. Where the distances from one marker to its mates
change from one frame to the next, and the distances among the mates do not, no movement of the body
has done it. The check shows beside false alarms how many of them are none.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from markermend.detection.likelihood.filling import interpolated
from markermend.detection.likelihood.neighbours import steadiest
from markermend.model import Finding, FloatArray, Take

_MATES = 5
_RATIO = 4.0  # how much larger the marker's change must be than that among its mates
_VISIBLE = 0.25  # of an artefact's amplitude, from which a jump counts as its own
_SEVERAL = 3
_LAG = 2  # frames on each side that say how distances change anyway


@dataclass(frozen=True)
class StarJump:
    """All distances of one marker jump just before `frame`.

    Attributes
    ----------
    marker, frame
        Where.
    jump_mm
        Median over the mates of how much the distance to them jumps.
    mates_mm
        The same among the mates themselves.
    """

    marker: str
    frame: int
    jump_mm: float
    mates_mm: float


def star_jumps(take: Take, least_mm: float = 1.0) -> tuple[StarJump, ...]:
    """Find single-frame jumps of one marker against mates that keep their mutual distances.

    Parameters
    ----------
    take
        The take; its measured markers that are ever seen.
    least_mm
        Smallest jump that counts.
    """
    shown = [int(m) for m in take.measured if take.seen[:, m].any()]
    if len(shown) < 4 or take.n_frames < 2 * _LAG + 2:
        return ()
    seen = take.seen[:, shown]
    points = interpolated(take.positions[:, shown], seen)
    mates = steadiest(points, seen, _MATES)
    certain = seen.copy()
    for lag in range(1, _LAG + 2):
        certain[lag:] &= seen[:-lag]
        certain[:-lag] &= seen[lag:]
    found = []
    for m, near in enumerate(mates):
        own = np.median([_jumps(points[:, m], points[:, j]) for j in near], axis=0)
        pairs = combinations(near.tolist(), 2)
        among = np.median([_jumps(points[:, i], points[:, j]) for i, j in pairs], axis=0)
        hot = (own >= least_mm) & (own > _RATIO * among) & certain[:, m]
        found += [
            StarJump(take.labels[shown[m]], int(t), float(own[t]), float(among[t]))
            for t in np.flatnonzero(hot)
        ]
    return tuple(found)


def confirmed(findings: Iterable[Finding], jumps: Iterable[StarJump]) -> frozenset[str]:
    """Give the ids of the findings that jumps of their marker confirm.

    A peak is confirmed by a jump at it, a step by one at either edge, heavy noise by several in its
    span; a jump counts from a quarter of the finding's amplitude, since the mates see it at an
    angle. A slow change does not jump, so that this check can never confirm one.
    """
    by_marker: dict[str, list[StarJump]] = {}
    for jump in jumps:
        by_marker.setdefault(jump.marker, []).append(jump)
    return frozenset(f.id for f in findings if _jumps_there(f, by_marker.get(f.marker, ())))


def _jumps_there(finding: Finding, jumps: Iterable[StarJump]) -> bool:
    start, stop = finding.span.start, finding.span.stop
    least = _VISIBLE * (finding.amplitude or 0.0)
    frames = [jump.frame for jump in jumps if jump.jump_mm >= least]
    if finding.kind == "noise":
        return sum(start <= t <= stop for t in frames) >= _SEVERAL
    if finding.kind in ("peak", "step"):
        return any(min(abs(t - start), abs(t - stop)) <= 1 for t in frames)
    return False


def _jumps(a: FloatArray, b: FloatArray) -> FloatArray:
    """(n_frames,) mm: change of a distance before each frame, beyond its change around."""
    step = np.diff(np.sqrt(((a - b) ** 2).sum(1)))
    out = np.zeros(len(a))
    inner = step[_LAG:-_LAG]
    before, after = step[: -2 * _LAG], step[2 * _LAG :]
    out[_LAG + 1 : len(a) - _LAG] = np.minimum(np.abs(inner - before), np.abs(inner - after))
    return out
