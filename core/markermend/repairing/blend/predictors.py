"""Many regressions at once: frames of reference, numbers of neighbours, ridges, horizons."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from markermend.model import BoolArray, FloatArray, Span
from markermend.repairing.blend.ridge import features
from markermend.repairing.blend.scene import Scene
from markermend.repairing.geometry import LocalFrames

PENALTIES = (0.01, 0.1, 1.0, 10.0)
"""mm²: ridges that are tried."""
SIZES = (6, 12, 24)
"""Numbers of neighbours that are tried; none at all is the rigid prediction."""
HORIZON = 0.5
"""Half the width of the running mean that is taken off the fast signals, in gap lengths."""
FRAME_MARKERS = (4, 8, 40)


@dataclass(frozen=True)
class Recipe:
    """How one prediction is made: in which family, from how many neighbours, with what ridge."""

    family: int
    neighbours: int
    penalty: float


@dataclass(frozen=True, eq=False)
class Family:
    """All regressions in one frame of reference that learn from the same signals.

    Attributes
    ----------
    name
        For the operator.
    frames
        The frame of reference.
    z, y
        (n_frames, n_features), (n_frames, n_dims) mm: neighbours and marker in it.
    rows
        (n_frames,): where it may learn.
    learnt
        (n_frames, n_features + n_dims): neighbours and marker as they are learnt from, all their
        motion or only what is faster than the gap; zero outside `rows`.
    sizes
        Numbers of neighbours that are tried.
    """

    name: str
    frames: LocalFrames
    z: FloatArray
    y: FloatArray
    rows: BoolArray
    learnt: FloatArray
    sizes: tuple[int, ...]

    def recipes(self, family: int) -> list[Recipe]:
        """List the recipes of this family, in the order of `predictions`."""
        return [
            Recipe(family, size, penalty)
            for size in self.sizes
            for penalty in (PENALTIES if size else (0.0,))
        ]

    def predictions(self, at: Span, hidden: Span | None) -> FloatArray:
        """Predict the marker in its local frame by every recipe.

        Parameters
        ----------
        at
            Frames wanted.
        hidden
            Frames not to learn from: their products are taken off the sums.

        Returns
        -------
        (n_recipes, len(at), n_dims) mm.
        """
        n_dims = self.y.shape[1]
        level, covariance = self._moments(hidden)
        moved = self.z[at.frames] - level[:-n_dims]
        made = [
            one
            for size in self.sizes
            for one in _predictions(moved, covariance, size * n_dims, n_dims)
        ]
        return np.stack(made) + level[-n_dims:]

    def _moments(self, hidden: Span | None) -> tuple[FloatArray, FloatArray]:
        """Give the means of z and y, and the covariance of what is learnt from."""
        n, plain, learnt, sums = self._without(hidden)
        level = learnt / n
        return plain / n, sums / n - np.outer(level, level)

    def _without(self, hidden: Span | None) -> tuple[int, FloatArray, FloatArray, FloatArray]:
        """Give the number of rows and their sums: plain, as learnt from, and of products."""
        n, whole, learnt, sums = self._all
        if hidden is not None:
            frames = np.arange(hidden.start, hidden.stop)[self.rows[hidden.frames]]
            part = self.learnt[frames]
            n -= len(frames)
            whole = np.asarray(whole - self._plain(frames))
            learnt = learnt - part.sum(axis=0)
            sums = sums - part.T @ part
        return max(n, 1), whole, learnt, sums

    @cached_property
    def _all(self) -> tuple[int, FloatArray, FloatArray, FloatArray]:
        frames = np.flatnonzero(self.rows)
        sums = self.learnt.T @ self.learnt
        return len(frames), self._plain(frames), self.learnt.sum(axis=0), sums

    def _plain(self, frames: NDArray[np.intp]) -> FloatArray:
        return np.concatenate([self.z[frames].sum(axis=0), self.y[frames].sum(axis=0)])


def _predictions(
    moved: FloatArray, covariance: FloatArray, p: int, n_dims: int
) -> Iterator[FloatArray]:
    """Serve all penalties by one eigendecomposition of the first p features."""
    if not p:
        yield np.zeros((len(moved), n_dims))
        return
    values, vectors = np.linalg.eigh(covariance[:p, :p])
    turned = vectors.T @ covariance[:p, -n_dims:]
    basis = moved[:, :p] @ vectors
    for penalty in PENALTIES:
        yield basis @ (turned / (np.maximum(values, 0.0) + penalty)[:, None])


def families(around: Scene) -> tuple[Family, ...]:
    """Set up the frames of reference that the neighbours allow, and the room."""
    cut = around.window
    n = len(around.order)
    shape = (cut.n_frames, cut.n_dims, cut.n_dims)
    still = LocalFrames(
        np.broadcast_to(np.eye(cut.n_dims), shape), np.zeros((cut.n_frames, cut.n_dims))
    )
    kinds: list[tuple[str, LocalFrames]] = []
    if n >= cut.n_dims:
        counts = sorted({min(count, n) for count in FRAME_MARKERS})
        kinds = [(f"{count} neighbours", around.frames_of(count)) for count in counts]
    kinds.append(("the room", still))
    sizes = tuple(sorted({min(size, n) for size in SIZES} - {0}))
    half = max(int(HORIZON * len(cut.span)), 4)
    found = []
    for name, frames in kinds:
        z = features(around, frames, SIZES[-1])
        y = frames.to_local(cut.own)
        all_of_it = np.where(around.rows[:, None], np.hstack([z, y]), 0.0)
        found.append(Family(name, frames, z, y, around.rows, all_of_it, (0, *sizes)))
        if sizes:
            fast = all_of_it - smooth(all_of_it, around.rows, half)
            found.append(Family(f"{name}, fast", frames, z, y, around.rows, fast, sizes))
    return tuple(found)


def smooth(values: FloatArray, rows: BoolArray, half: int) -> FloatArray:
    """Average twice over the rows in use among 2·half + 1 frames; zero outside the rows."""
    n = len(values)
    low, high = np.maximum(np.arange(n) - half, 0), np.minimum(np.arange(n) + half + 1, n)
    count = np.concatenate([[0], np.cumsum(rows)])
    share = (rows / np.maximum(count[high] - count[low], 1))[:, None]
    for _ in range(2):
        passed = np.concatenate([np.zeros((1, values.shape[1])), np.cumsum(values, axis=0)])
        values = (passed[high] - passed[low]) * share
    return values
