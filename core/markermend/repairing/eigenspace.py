"""Eigenspaces learnt from a training set (Li et al., IEEE Access 8:76980, 2020).

Two readings of the same idea: rows are frames and what moves together is learnt (Eq. 1 to 4), or
columns are trajectories and how they go on in time is learnt (Eq. 5 to 8, and 9 to 16 where whole
frames are missing).  Data are centred, and pieces with the same entries missing share one
eigenspace, without which the equations have no meaning.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from markermend.errors import CannotRepair
from markermend.model import BoolArray, FloatArray, Span, Take
from markermend.repairing.problem import Problem
from markermend.repairing.window import Window

LEARNT = 6000
"""Frames or trajectories that suffice to learn an eigenspace."""


def leading(gram: FloatArray, cumulative: float, most: int) -> FloatArray:
    """Give the eigenvectors that hold a share of the energy, at most so many."""
    values, vectors = np.linalg.eigh(gram)
    energy = np.maximum(values[::-1], 0.0).cumsum()
    rank = int(np.argmax(energy >= cumulative * energy[-1])) + 1
    return np.asarray(vectors[:, ::-1][:, : max(1, min(rank, most))])


def map_rows(
    training: FloatArray, rows: FloatArray, missing: BoolArray, cumulative: float
) -> FloatArray:
    """Complete rows from the columns that they have (Eq. 1 to 4, and 5 to 8 transposed).

    Parameters
    ----------
    training
        (n_rows, n_columns): complete rows, centred.
    rows
        (n, n_columns): to be completed, centred alike; missing columns are not read.
    missing
        (n_columns,): which are missing.

    Returns
    -------
    (n, n_columns).

    Notes
    -----
    T = (Σ U0ᵀA0ᵀA0U0)⁻¹ Σ U0ᵀA0ᵀA U stands the other way round than it is printed in Eq. 3, and
    with U, so that A U = A0 U0 T (Eq. 2) holds in the sense of least squares.
    """
    gram = training.T @ training
    half = np.where(missing[:, None], 0.0, gram)
    most = int((~missing).sum())
    basis = leading(gram, cumulative, most)
    zeroed = leading(np.where(missing, 0.0, half), cumulative, most)[:, : basis.shape[1]]
    energy = np.einsum("ij,ij->j", zeroed, half @ zeroed)
    solid = energy > 1e-12 * energy[0]
    zeroed, energy = zeroed[:, solid], energy[solid]
    between = (zeroed.T @ half @ basis) / energy[:, None]
    given = np.where(missing, 0.0, rows)
    return np.asarray(given @ zeroed @ between @ basis.T)


def weighted_rows(
    training: FloatArray,
    column: FloatArray,
    missing: BoolArray,
    ranks: Sequence[int],
    weights: Sequence[FloatArray],
) -> FloatArray:
    """Complete trajectories of which whole frames are missing (Eq. 9 to 16).

    Parameters
    ----------
    training
        (n_rows, n_columns): complete trajectories, centred.
    column
        (n_rows, n): to be completed.
    missing
        (n_rows,): which frames are missing.
    ranks, weights
        Candidates for the number of eigenvectors and for the diagonal of W, (n_rows,) each. Where
        there are several, those are taken with which eigenvectors of the first half of the
        training set tell best the missing frames of the second half (Eq. 13).

    Notes
    -----
    The factor W behind the transposed eigenvectors, left out in Eq. 15 and 16, is there.
    """
    rank, weight = chosen(training, missing, ranks, weights)
    done = column.copy()
    bridge = _bridge(_eigenvectors(training), missing, rank, weights[weight])
    done[missing] = bridge @ column[~missing]
    return done


def chosen(
    training: FloatArray,
    missing: BoolArray,
    ranks: Sequence[int],
    weights: Sequence[FloatArray],
) -> tuple[int, int]:
    """Choose among the candidates of `weighted_rows`: the rank, and which of the weights."""
    most = max(1, int((~missing).sum()) - 1)
    choices = [(min(rank, most), i) for rank in ranks for i in range(len(weights))]
    if len(choices) == 1:
        return choices[0]
    half = training.shape[1] // 2
    basis = _eigenvectors(training[:, :half])
    gram = training[:, half:] @ training[:, half:].T
    errors = [_misses(_bridge(basis, missing, r, weights[i]), gram, missing) for r, i in choices]
    return choices[int(np.argmin(errors))]


def _eigenvectors(training: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.eigh(training @ training.T)[1][:, ::-1])


def _misses(operator: FloatArray, gram: FloatArray, missing: BoolArray) -> float:
    """Sum the squares of operator · seen - missing over all columns, from their products."""
    across = gram[np.ix_(~missing, missing)]
    seen = operator @ gram[np.ix_(~missing, ~missing)]
    return float((seen * operator).sum() - 2.0 * (operator * across.T).sum())


def _bridge(basis: FloatArray, missing: BoolArray, rank: int, weight: FloatArray) -> FloatArray:
    root = np.sqrt(weight[~missing])[:, None]
    seen, unseen = basis[~missing, :rank], basis[missing, :rank]
    return np.asarray(unseen @ np.linalg.pinv(root * seen, rcond=1e-8) * root.T)


def sources(problem: Problem, cut: Window, labels: Sequence[str]) -> list[FloatArray]:
    """Give the positions to learn from: the training set, or else the rest of the take.

    Parameters
    ----------
    labels
        Markers wanted, in this order.

    Returns
    -------
    Arrays (n_frames, len(labels), n_dims) mm, NaN where something is not seen.

    Raises
    ------
    CannotRepair
        If a take of the training set lacks a label, or is of another rate or dimension.
    """
    if not problem.training:
        places = [cut.labels.index(label) for label in labels]
        rest = cut.positions[:, places].copy()
        rest[cut.span.frames] = np.nan
        return [rest]
    return [_matched(take, cut, labels) for take in problem.training]


def _matched(take: Take, cut: Window, labels: Sequence[str]) -> FloatArray:
    lacking = [label for label in labels if label not in take.labels]
    if lacking:
        raise CannotRepair(
            f"A take to learn from lacks {', '.join(lacking[:6])}{' …' if lacking[6:] else ''}; "
            "give takes with the same markers."
        )
    if take.n_dims != cut.n_dims or not np.isclose(take.rate, cut.rate, rtol=1e-3):
        raise CannotRepair(
            f"A take to learn from has {take.n_dims} dimensions at {take.rate:g} Hz, and this one "
            f"{cut.n_dims} at {cut.rate:g} Hz; give takes of the same sort."
        )
    return take.positions[:, [take.index(label) for label in labels]]


def whole_rows(found: Iterable[FloatArray]) -> FloatArray:
    """Join the frames in which everything is seen, evenly chosen where they are many.

    Returns
    -------
    (n_frames, n_markers, n_dims) mm.
    """
    rows = np.concatenate([x[np.isfinite(x).all(axis=(1, 2))] for x in found])
    return rows[:: max(1, -(-len(rows) // LEARNT))]


def whole_pieces(found: Iterable[FloatArray], length: int) -> FloatArray:
    """Cut trajectories into pieces without gaps that overlap by half.

    Returns
    -------
    (length, n_pieces) mm, each coordinate of each marker on its own.
    """
    step = max(1, length // 2)
    pieces = []
    for positions in found:
        for start in range(0, len(positions) - length + 1, step):
            piece = positions[start : start + length]
            kept = piece[:, np.isfinite(piece).all(axis=(0, 2))]
            pieces.append(kept.reshape(length, -1))
    if not pieces:
        return np.empty((length, 0))
    joined = np.concatenate(pieces, axis=1)
    return joined[:, :: max(1, -(-joined.shape[1] // LEARNT))]


@dataclass(frozen=True, eq=False)
class Piece:
    """A stretch of the marker around the span, and complete stretches of the same length.

    Attributes
    ----------
    column
        (n_frames, n_dims) mm, less the mean of what is seen; NaN where missing.
    mean
        (n_dims,) mm.
    missing
        (n_frames,): which frames.
    training
        (n_frames, n_trajectories) mm, each less its mean over the frames that are not missing.
    inside
        The span, counted in the piece.
    weights
        Candidates for W.
    """

    column: FloatArray
    mean: FloatArray
    missing: BoolArray
    training: FloatArray
    inside: slice
    weights: tuple[FloatArray, ...]


def piece(problem: Problem, cut: Window, context: int) -> Piece:
    """Cut out the marker around the span, and what to learn its going on from.

    Raises
    ------
    CannotRepair
        If the marker is not seen within the context, or nothing is long enough to learn from.
    """
    around = cut.span.padded(context, cut.n_frames)
    column = cut.own[around.frames]
    missing = np.isnan(column[:, 0])
    labels = [label for m, label in enumerate(cut.labels) if cut.seen[:, m].any()]
    training = whole_pieces(sources(problem, cut, labels), len(around))
    if missing.all() or not training.shape[1]:
        why = (
            f"{cut.label} is not seen within {context} frames of the span"
            if missing.all()
            else f"No trajectory is seen for {len(around)} frames on end to learn from"
        )
        raise CannotRepair(f"{why}; choose another context or a method that does not learn.")
    mean = column[~missing].mean(axis=0)
    return Piece(
        column=column - mean,
        mean=mean,
        missing=missing,
        training=training - training[~missing].mean(axis=0),
        inside=slice(cut.span.start - around.start, cut.span.stop - around.start),
        weights=tuple(nearness(around, cut.span)),
    )


def nearness(piece: Span, span: Span) -> list[FloatArray]:
    """Give candidates for W: all frames alike, or the nearer to the span the more."""
    frames = np.arange(piece.start, piece.stop)
    away = np.maximum(span.start - frames, frames - span.stop + 1).clip(0)
    scales: NDArray[np.float64] = np.array([5.0, 10.0, 20.0, 40.0])
    return [np.ones(len(frames)), *(np.exp(-away / s) + 1e-6 for s in scales)]
