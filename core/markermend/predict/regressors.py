"""What the neighbour predictors look at: coordinates of the parent and of the siblings."""

from collections.abc import Sequence

import numpy as np

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
    return np.divide(centred, scale, out=np.zeros_like(centred), where=scale > 1e-9)


def design(positions: FloatArray, markers: Sequence[int], context: int, order: int) -> FloatArray:
    """Build the rows X(n) of Eq. 9 and 11 without their constant and moving averages.

    Parameters
    ----------
    positions
        (n_frames, n_markers, n_dims) without NaN in `markers`.
    markers
        Parent first, then the siblings.
    context
        Number k of past frames beside the present one; before the first frame stands the first.
    order
        Highest power L.

    Returns
    -------
    (n_frames, len(markers) * n_dims * (context + 1) * order), the columns standardised before and
    after they are raised to powers; that spans the same space as the raw powers do.
    """
    n_frames = len(positions)
    chosen = standardised(positions[:, list(markers)].reshape(n_frames, -1))
    past = np.maximum(np.arange(n_frames)[:, None] - np.arange(context + 1), 0)
    lagged = chosen[past].reshape(n_frames, -1)
    return np.concatenate(
        [lagged if power == 1 else standardised(lagged**power) for power in range(1, order + 1)],
        axis=1,
    )
