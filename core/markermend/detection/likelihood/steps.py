"""Steps: two opposite one-frame jumps of one marker, with a level between them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import fft
from scipy.ndimage import maximum_filter1d

from markermend.detection.likelihood import templates
from markermend.detection.likelihood.sharp import (
    LEAST,
    MATE_SHARE,
    Candidate,
    local_scale,
    mates_of,
)
from markermend.detection.likelihood.whitening import Whitened
from markermend.model import BoolArray, FloatArray

SHORTEST = 4  # frames between the edges
LONGEST = 300  # the same at 100 Hz; `pace` is the rate over 100 Hz
_HALF = 6
_REACH = 16  # frames around an edge that its own answer is taken out of
_SIDE = 8  # frames in which nothing much may be left
_SIDE_SHARE = 1.0
_NEAR = 3
_CLEARER = 1.4  # how much more one frame must explain to rule an edge out
_MISMATCH = 0.6  # most of |J1 + J2| / (|J1| + |J2|)
_MOST_EDGES = 24  # per marker, the strongest ones


@dataclass(frozen=True, eq=False)
class Jumps:
    """Jumps between consecutive frames, on one set of series.

    Attributes
    ----------
    N
        (n_markers, 3, n_frames): sums over a jump just before each frame.
    q
        (n_markers, 3): energies.
    usual
        (n_markers, n_frames): local scale of the score, at least 1.
    answer
        (n_markers, 3, 2 * reach + 1): what a jump by 1 adds to ``N`` around it.
    single
        (n_markers, n_frames): squared score of one frame, not normalised.
    """

    N: FloatArray
    q: FloatArray
    usual: FloatArray
    answer: FloatArray
    single: FloatArray

    def squared(self) -> FloatArray:
        """(n_markers, n_frames): squared scores, not normalised."""
        result: FloatArray = (self.N**2 / self.q[..., None]).sum(1)
        return result

    def score(self) -> FloatArray:
        """(n_markers, n_frames): normalised scores."""
        return np.sqrt(self.squared()) / self.usual


def jumps(whitened: Whitened, valid: BoolArray, pace: float = 1.0) -> Jumps:
    """Score a jump before every frame, seen over a few frames on both sides."""
    N = templates.jumps(templates.sums(whitened), _HALF)
    template = templates.jump_template(_HALF)
    q = whitened.energy(template)
    # What a lasting step adds, not one that ends with the template.
    centred = np.roll(np.pad(template, (0, whitened.size - len(template))), -_HALF)
    lasting = np.zeros(whitened.size)
    lasting[: whitened.size // 2] = 1.0
    spread = fft.irfft(
        whitened.weight * fft.rfft(lasting) * np.conj(fft.rfft(centred)), whitened.size
    )
    answer = np.concatenate((spread[:, -_REACH:], spread[:, : _REACH + 1]), axis=1)
    n_markers = len(valid)
    return Jumps(
        N.reshape(n_markers, 3, -1),
        q.reshape(n_markers, 3),
        local_scale(templates.score(N, q), valid, pace),
        answer.reshape(n_markers, 3, -1),
        templates.score(whitened.g, whitened.energy(np.ones(1))) ** 2,
    )


@dataclass(frozen=True, eq=False)
class Edge:
    """One jump that stands out: its frame, score and what each witness says of it (3,) mm."""

    frame: int
    score: float
    sizes: tuple[FloatArray, FloatArray]


def find_steps(
    own: Jumps,
    residual: Jumps,
    neighbours: NDArray[np.intp],
    free: BoolArray,
    threshold: float,
    pace: float = 1.0,
) -> list[Candidate]:
    """Pair opposite jumps on which both witnesses agree.

    Parameters
    ----------
    own, residual
        Jumps of the marker's own path and of its residual, peaks and noise taken out.
    neighbours
        (n_markers, k): steadiest first.
    free
        (n_markers, n_frames): frames at which an edge may lie.
    threshold
        Score that the weaker edge has to pass.
    pace
        Rate over 100 Hz.
    """
    longest = max(2 * SHORTEST, round(LONGEST * pace))
    own_score = own.score()
    mates = mates_of(own_score, free, neighbours)
    share = free / np.maximum(1.0, MATE_SHARE * mates)
    # Where one frame alone explains more than a jump does, there is no edge.
    single = maximum_filter1d(own.single + residual.single, 2 * _NEAR + 1, axis=1)
    peaked = _CLEARER * (own.squared() + residual.squared()) < single
    agreed = np.minimum(own_score, residual.score()) * share
    found = []
    for m in np.flatnonzero((agreed > LEAST * threshold).sum(1) >= 2):
        edges = _edges(own, residual, int(m), share[m], LEAST * threshold)
        edges = [edge for edge in edges if not peaked[m, edge.frame]]
        pairs = []
        for i, a in enumerate(edges):
            for b in edges[i + 1 :]:
                if SHORTEST <= b.frame - a.frame <= longest:
                    mismatch = min(map(_mismatch, a.sizes, b.sizes))
                    if mismatch < _MISMATCH:
                        weaker = min(a.score, b.score)
                        pairs.append((weaker * (1.0 - 0.5 * mismatch), weaker, a.frame, b.frame))
        taken: list[tuple[int, int]] = []
        for _, weaker, start, stop in sorted(pairs, reverse=True):
            if all(stop < c or start > d for c, d in taken):
                taken.append((start, stop))
                found.append(Candidate("step", int(m), start, stop, weaker / threshold, weaker))
    return found


def _edges(own: Jumps, residual: Jumps, marker: int, share: FloatArray, least: float) -> list[Edge]:
    """Take the strongest jump of a marker, take its answer out of the series, and again."""
    left = [own.N[marker].copy(), residual.N[marker].copy()]
    q = (own.q[marker], residual.q[marker])
    gain = (own.answer[marker][:, _REACH], residual.answer[marker][:, _REACH])
    usual = (own.usual[marker], residual.usual[marker])
    answers = (own.answer[marker], residual.answer[marker])
    n = len(share)

    def score(part: slice) -> FloatArray:
        z = [
            np.sqrt((N[:, part] ** 2 / e[:, None]).sum(0)) / u[part]
            for N, e, u in zip(left, q, usual, strict=True)
        ]
        joined: FloatArray = np.minimum(*z) * share[part]
        return joined

    now = score(slice(0, n))
    edges: list[Edge] = []
    while len(edges) < _MOST_EDGES:
        t = int(now.argmax())
        value = float(now[t])
        if value <= least:
            break
        low, high = max(0, t - _REACH), min(n, t + _REACH + 1)
        sizes = []
        for i in range(2):
            size = left[i][:, t] / gain[i]
            sizes.append(size)
            part = answers[i][:, low - t + _REACH : high - t + _REACH]
            left[i][:, low:high] -= size[:, None] * part
        now[low:high] = score(slice(low, high))
        edges.append(Edge(t, value, (sizes[0], sizes[1])))
    kept = []
    for edge in edges:
        beside = now[max(0, edge.frame - _SIDE) : edge.frame + _SIDE + 1]
        value = edge.score / max(1.0, _SIDE_SHARE * float(beside.max()))
        if value > least:
            kept.append(Edge(edge.frame, value, edge.sizes))
    return sorted(kept, key=lambda e: e.frame)


def _mismatch(first: FloatArray, second: FloatArray) -> float:
    norm = np.sqrt((first**2).sum()) + np.sqrt((second**2).sum())
    return float(np.sqrt(((first + second) ** 2).sum()) / max(norm, 1e-9))
