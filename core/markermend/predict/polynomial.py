"""The polynomial predictor P_k^L from parent and siblings."""

import numpy as np
from scipy.linalg import eigh

from markermend.body import Body
from markermend.model import BoolArray, FloatArray
from markermend.predict.regressors import powers, regressor_markers, with_past

# Directions whose share of the largest eigenvalue is smaller are dropped.
RANK = 1e-9
# At least so many frames for each direction that is fitted.
FRAMES_PER_DIRECTION = 5
# Longer takes are learnt from every second, third, ... frame.
LEARNT = 12_000


def polynomial(
    positions: FloatArray,
    trusted: BoolArray,
    body: Body,
    marker: int,
    *,
    order: int = 4,
    context: int = 3,
    n_siblings: int = 6,
    own_past: bool = False,
) -> FloatArray | None:
    """Predict a marker from powers of the present and past coordinates of its neighbours.

    Parameters
    ----------
    positions
        (n_frames, n_markers, n_dims) mm without NaN in the markers of the body.
    trusted
        (n_frames,): the frames to learn from.
    body
        The mesh that says who is parent and sibling.
    marker
        Index of the marker.
    order
        Highest power L.
    context
        Number k of past frames.
    n_siblings
        How many siblings are used at most.
    own_past
        Whether the marker's own past frames are regressors as well: more exact, and useless for
        detection, since the prediction then follows every artefact (Fig. 6).

    Returns
    -------
    (n_frames, n_dims) mm, or None where the marker has no neighbours or fewer than ten trusted
    frames.

    Notes
    -----
    Skurowski & Pawlyta, Eq. 3 and 9, with k = 3 and L = 4.  Their X'X has no inverse in practice:
    columns are standardised, and the equations are solved in the eigenvectors of X'X, without
    those that rounding decides and, on short takes, with no more than a fifth of the frames.
    The marker's own past is no regressor, so that the prediction does not follow an artefact.
    """
    markers = regressor_markers(body, marker, n_siblings)
    n_trusted = int(trusted.sum())
    if not markers or n_trusted < 2 * FRAMES_PER_DIRECTION:
        return None
    columns = powers(positions, markers, order)
    if own_past:
        own = powers(positions, [marker], order)
        columns = np.concatenate([columns, own[np.maximum(np.arange(len(own)) - 1, 0)]], axis=1)
    frames = np.flatnonzero(trusted)
    frames = frames[:: -(-len(frames) // LEARNT)]
    X, Y = with_past(columns, frames, context), positions[frames, marker]
    centre, mean = X.mean(axis=0), Y.mean(axis=0)
    X -= centre
    values, vectors = eigh(X.T @ X, overwrite_a=True, check_finite=False)
    keep = values > RANK * max(values[-1], 1e-300)
    keep[: -max(1, len(frames) // FRAMES_PER_DIRECTION)] = False
    vectors = vectors[:, keep]
    weights = vectors @ ((vectors.T @ (X.T @ (Y - mean))) / values[keep, None])
    predicted = np.empty_like(positions[:, marker])
    for at in range(0, len(positions), LEARNT):
        block = np.arange(at, min(at + LEARNT, len(positions)))
        predicted[block] = (with_past(columns, block, context) - centre) @ weights + mean
    return predicted
