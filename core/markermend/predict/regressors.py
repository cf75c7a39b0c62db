"""What the neighbour predictors look at: coordinates of the parent and of the siblings."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from markermend.body import Body
from markermend.model import FloatArray


def regressor_markers(body: Body, marker: int, n_siblings: int) -> tuple[int, ...]:
    """Give the parent marker and the steadiest siblings, at most `n_siblings` of them.

    In the root cluster, which has no parent, and for a marker without siblings, the steadiest
    neighbours stand in, so that there are always two markers where the body has three.
    """
    parent = body.parent(marker)
    chosen = [] if parent is None else [parent]
    chosen += body.siblings(marker)[:n_siblings]
    for other in body.neighbours(marker):
        if len(chosen) >= 2:
            break
        if other not in chosen:
            chosen.append(other)
    return tuple(chosen)


def standardised(columns: FloatArray) -> FloatArray:
    """Centre columns (n_frames, n) and give them unit variance; constant ones become 0."""
    centred = columns - columns.mean(axis=0)
    scale = centred.std(axis=0)
    unit: FloatArray = np.divide(centred, scale, out=np.zeros_like(centred), where=scale > 1e-9)
    return unit


def powers(positions: FloatArray, markers: Sequence[int], order: int) -> FloatArray:
    """Give the coordinates of some markers, standardised and raised to powers.

    Parameters
    ----------
    positions
        (n_frames, n_markers, n_dims) without NaN in `markers`.
    markers
        Parent first, then the siblings.
    order
        Highest power L.

    Returns
    -------
    (n_frames, order * len(markers) * n_dims).  Coordinates are standardised before they are raised
    to powers and after; that spans the same space as the raw powers do.
    """
    base = standardised(positions[:, list(markers)].reshape(len(positions), -1))
    columns, power = [base], base
    for _ in range(1, order):
        power = power * base
        columns.append(standardised(power))
    return np.concatenate(columns, axis=1)


def with_past(columns: FloatArray, frames: NDArray[np.intp], context: int) -> FloatArray:
    """Build the rows X(n) of Eq. 9 and 11 at some frames: columns now and `context` frames back.

    Before the first frame stands the first.  The result is (len(frames), (context + 1) * n).
    """
    return np.concatenate([columns[np.maximum(frames - k, 0)] for k in range(context + 1)], axis=1)
