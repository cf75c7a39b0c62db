"""Cross a span in which no neighbour is seen by how the body went on from like postures.

Elsewhere in the take, and in the takes to learn from, the same length is crossed by the ways into
a gap that need the marker alone.  What they leave over is learnt as a Gaussian process of the
posture and motion of the whole body at both edges, turned to where the body is headed here.
Where motion repeats itself this says much; where it does not, the mix leaves it out.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from markermend.model import BoolArray, FloatArray, Take
from markermend.repairing.blend.blend import Blend, hardness, mixed
from markermend.repairing.blend.mixing import mix
from markermend.repairing.blend.pseudo import (
    EMBARGO,
    GROUPS,
    MOST,
    PseudoGaps,
    inside_offsets,
    possible_starts,
)
from markermend.repairing.blend.scene import BOUNDARY
from markermend.repairing.geometry import LocalFrames, defines_frame, kabsch
from markermend.repairing.kriging import Operator, operators
from markermend.repairing.window import CONTEXT, Window

EDGE = (9, 5, 1)
"""Frames before the span, and as many after it, in which the body is looked at."""
AHEAD_S = 0.1
"""Velocities count as the way that is gone in this time."""
PLACES = 320
"""Places that are learnt from."""
LEAST_PLACES = 24
KEPT_SHARE = 0.8
"""Share of the frames that a marker of the body must be seen in."""
REACHES = (0.6, 1.0)
"""Lengths of the correlation, in median distances between two places."""
NUGGETS = (0.3, 0.03, 0.003)
POOL = 12


@dataclass(frozen=True, eq=False)
class Places:
    """Stretches of the span's length, all turned alike.

    Attributes
    ----------
    take, start
        (n,): number of the recording and first frame in it; recording 0 is the window itself.
    edges
        (n, n_features) mm: posture and motion of the body at both edges.
    own
        (n, 2 · BOUNDARY + length, n_dims) mm: the marker around the span, then in it.
    """

    take: NDArray[np.intp]
    start: NDArray[np.intp]
    edges: FloatArray
    own: FloatArray

    def __len__(self) -> int:
        return len(self.start)


def bridge(cut: Window, training: Sequence[Take] = ()) -> Blend | None:
    """Cross the span by the mix that does best on pseudo-gaps.

    Parameters
    ----------
    cut
        The window; the marker is seen BOUNDARY frames before and after the span.
    training
        Takes to learn from; those of another rate or that lack markers are left out.

    Returns
    -------
    The mix, or None where too little is seen. Its pseudo-gaps lie in the window if enough fit
    there, and otherwise in the takes to learn from, where they have no start of their own.
    """
    span = cut.span
    around = np.concatenate([np.arange(-BOUNDARY, 0), np.arange(BOUNDARY) + len(span)])
    if span.start < BOUNDARY or span.stop + BOUNDARY > cut.n_frames:
        return None
    body = _body(cut)
    here = _edge_frames(span.start, len(span))
    if cut.marker not in body or not np.isfinite(cut.own[span.start + around]).all():
        return None
    shape = cut.positions[here][:, body].reshape(-1, cut.n_dims)
    if not defines_frame(shape):
        return None
    recordings = [cut.positions[:, body], *_learnt(training, cut, body)]
    place = int(np.flatnonzero(body == cut.marker)[0])
    known = _gather(recordings, place, shape, around, len(span), cut.rate)
    if len(known) < LEAST_PLACES:
        return None
    frames = kabsch(shape, shape[None], np.ones(len(shape)))
    target = _edges(frames.to_local(shape[None]), len(body), cut.rate)
    own = frames.to_local(cut.own[None, span.start + around])[0]
    return _mix(cut, known, target, own, frames)


def _body(cut: Window) -> NDArray[np.intp]:
    """Give the markers that are seen at the edges of the span and in most frames."""
    edges = cut.seen[_edge_frames(cut.span.start, len(cut.span))].all(axis=0)
    mine = cut.seen[:, cut.marker]
    often = cut.seen[mine].mean(axis=0) >= KEPT_SHARE
    return np.flatnonzero(edges & often)


def _edge_frames(start: int, length: int) -> NDArray[np.intp]:
    before = np.array(EDGE)
    return np.concatenate([start - before, start + length - 1 + before[::-1]])


def _learnt(training: Sequence[Take], cut: Window, body: NDArray[np.intp]) -> list[FloatArray]:
    labels = [cut.labels[m] for m in body]
    return [
        take.positions[:CONTEXT, [take.index(label) for label in labels]]
        for take in training
        if np.isclose(take.rate, cut.rate) and set(labels) <= set(take.labels)
    ]


def _gather(
    recordings: Sequence[FloatArray],
    marker: int,
    shape: FloatArray,
    around: NDArray[np.intp],
    length: int,
    rate: float,
) -> Places:
    """Turn all places that the span could lie at to the posture at its edges."""
    found: list[tuple[int, int]] = []
    for i, positions in enumerate(recordings):
        rows: BoolArray = np.asarray(np.isfinite(positions[:, :, 0]).all(axis=1))
        found += [(i, int(start)) for start in possible_starts(rows, length, around)]
    chosen = np.array(found, np.intp).reshape(-1, 2)
    if len(chosen) > PLACES:
        chosen = chosen[np.linspace(0, len(chosen) - 1, PLACES).round().astype(np.intp)]
    wanted = np.concatenate([around, np.arange(length)])
    n_markers = recordings[0].shape[1]
    edges: list[FloatArray] = []
    own: list[FloatArray] = []
    for i, positions in enumerate(recordings):
        starts = chosen[chosen[:, 0] == i, 1]
        if len(starts):
            at = np.stack([_edge_frames(int(start), length) for start in starts])
            bodies = positions[at].reshape(len(starts), len(shape), -1)
            frames = kabsch(shape, bodies, np.ones(len(shape)))
            edges.append(_edges(frames.to_local(bodies), n_markers, rate))
            own.append(frames.to_local(positions[starts[:, None] + wanted, marker]))
    if not own:
        return Places(chosen[:, 0], chosen[:, 1], np.empty((0, 0)), np.empty((0, 0, 0)))
    return Places(chosen[:, 0], chosen[:, 1], np.concatenate(edges), np.concatenate(own))


def _edges(bodies: FloatArray, n_markers: int, rate: float) -> FloatArray:
    """Give posture and velocity at both edges, (n, n_features) mm, whatever the markers' number."""
    posture = bodies.reshape(len(bodies), 2, len(EDGE), n_markers, -1)
    ahead = AHEAD_S * rate / (EDGE[0] - EDGE[-1])
    inner = np.stack([posture[:, 0, -1], posture[:, 1, 0]], axis=1)
    outer = np.stack([posture[:, 0, 0], posture[:, 1, -1]], axis=1)
    both = np.concatenate([inner, ahead * (inner - outer)], axis=1)
    return np.asarray(both.reshape(len(bodies), -1) / np.sqrt(n_markers))


def _mix(
    cut: Window, known: Places, target: FloatArray, own: FloatArray, frames: LocalFrames
) -> Blend | None:
    length = len(cut.span)
    offsets = np.concatenate([np.arange(-BOUNDARY, 0), np.arange(BOUNDARY) + length])
    tested, groups = _tested(known, length)
    inside = inside_offsets(length)
    ways = _ways(np.arange(length) / cut.rate, offsets / cut.rate)
    reach = float(np.median(_distance(known.edges[tested], known.edges)))
    bases = np.stack([_left(known, way) for way in ways])
    plain = bases[:, tested][:, :, inside]
    first = int(np.argmin(np.linalg.norm(plain, axis=3).mean(axis=(1, 2))))
    settings = [(share * reach + 1e-9, nugget) for share in REACHES for nugget in NUGGETS]
    learnt = np.zeros((len(settings), len(tested), len(inside), cut.n_dims))
    for members, rest in groups:
        wanted = known.edges[tested[members]]
        made = _processes(known.edges[rest], bases[first][rest][:, inside], wanted, settings)
        learnt[:, members] = plain[first, members] - made
    errors = np.concatenate([plain, learnt])
    pool = np.argsort(np.linalg.norm(errors, axis=3).mean(axis=(1, 2)), kind="stable")[:POOL]
    chosen, weights = mix(errors[pool].reshape(len(pool), len(tested), -1))
    members = pool[chosen]
    fills = np.stack([way.weights @ own for way in ways])
    if (members >= len(ways)).any():
        more = _processes(known.edges, bases[first], target, settings)[:, 0]
        fills = np.concatenate([fills, fills[first] + more])
    local, apart = mixed(weights, fills[members])
    off, there = mixed(weights, errors[members])
    names = [way.name for way in ways]
    names += [f"{names[first]} and what followed like postures"] * len(settings)
    at_home = bool((known.take[tested] == 0).all())
    pseudo = PseudoGaps(
        known.start[tested] if at_home else np.empty(0, np.intp), length, inside, offsets, ()
    )
    return Blend(
        frames.to_world(local[None])[0],
        np.linalg.norm(off, axis=2),
        pseudo,
        tuple((float(w), names[m]) for w, m in zip(weights, members, strict=True)),
        cut.start,
        len(known) if not at_home else int(cut.seen[:, cut.marker].sum()),
        hardness(float(apart.mean()), there.mean(axis=1)),
    )


def _tested(
    known: Places, length: int
) -> tuple[NDArray[np.intp], list[tuple[NDArray[np.intp], NDArray[np.intp]]]]:
    """Choose the places that are pseudo-gaps, in groups with what may be learnt from for each.

    Places in the window itself are taken if there are enough, otherwise all.
    """
    home = np.flatnonzero(known.take == 0)
    tested = home if len(home) >= LEAST_PLACES else np.arange(len(known))
    if len(tested) > MOST:
        tested = tested[np.linspace(0, len(tested) - 1, MOST).round().astype(np.intp)]
    groups = []
    apart = length + 2 * BOUNDARY + EMBARGO
    for members in np.array_split(np.arange(len(tested)), GROUPS):
        free = np.ones(len(known), bool)
        for place in tested[members]:
            same = known.take == known.take[place]
            free &= ~(same & (np.abs(known.start - known.start[place]) < apart))
        groups.append((members, np.flatnonzero(free)))
    return tested, groups


def _ways(inside: FloatArray, boundary: FloatArray) -> list[Operator]:
    """Give the ways into the gap that do not depend on where the room's origin is."""
    return [
        way
        for way in operators(inside, boundary)
        if np.allclose(way.weights.sum(axis=1), 1.0, atol=1e-6)
    ]


def _left(known: Places, way: Operator) -> FloatArray:
    """Give what one way into the gap leaves over at all places, (n, length, n_dims) mm."""
    n = way.weights.shape[1]
    return np.asarray(known.own[:, n:] - np.matmul(way.weights, known.own[:, :n]))


def _distance(first: FloatArray, second: FloatArray) -> FloatArray:
    square = np.square(first).sum(axis=1)[:, None] + np.square(second).sum(axis=1)
    return np.asarray(np.sqrt(np.maximum(square - 2 * first @ second.T, 0.0)))


def _processes(
    edges: FloatArray, left: FloatArray, wanted: FloatArray, settings: list[tuple[float, float]]
) -> FloatArray:
    """Predict what is left over from the edges by Gaussian processes of mean zero.

    Returns
    -------
    (n_settings, n_wanted, length, n_dims) mm.
    """
    if not len(edges):
        return np.zeros((len(settings), len(wanted), *left.shape[1:]))
    own, across = _distance(edges, edges), _distance(wanted, edges)
    flat = left.reshape(len(left), -1)
    made = []
    for reach, nugget in settings:
        kernel = np.exp(-0.5 * np.square(own / reach)) + nugget * np.eye(len(own))
        solved = cho_solve(cho_factor(kernel, lower=True), flat)
        made.append(np.exp(-0.5 * np.square(across / reach)) @ solved)
    return np.stack(made).reshape(len(settings), len(wanted), *left.shape[1:])
