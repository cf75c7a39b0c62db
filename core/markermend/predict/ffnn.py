"""The feed-forward network that predicts a marker from its neighbours."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from markermend.body import Body
from markermend.model import BoolArray, FloatArray
from markermend.predict import scg
from markermend.predict.regressors import powers, regressor_markers, standardised, with_past

HIDDEN = 12
PER_REPLICA = 4
# Frames that a network learns from; consecutive frames say nearly the same.
LEARNT = 600
# Samples that pass through the networks at once.
BLOCK = 400_000


def moving_average(values: FloatArray, trusted: BoolArray, window: int) -> FloatArray:
    """Average the trusted samples of a window around each frame (the MA of Eq. 11).

    Parameters
    ----------
    values
        (n_frames, n_dims) without NaN.
    trusted
        (n_frames,).
    window
        Frames, cut to the take; where it holds no trusted frame the mean of all stands.
    """
    window = min(window, len(values))
    weight = trusted.astype(float)
    sums = uniform_filter1d(values * weight[:, None], window, axis=0, mode="constant")
    counts = uniform_filter1d(weight, window, mode="constant")[:, None]
    overall = values[trusted].mean(axis=0) if trusted.any() else values.mean(axis=0)
    return np.where(counts > 1e-9, sums / np.maximum(counts, 1e-9), overall)


def ffnn(
    positions: FloatArray,
    trusted: BoolArray,
    body: Body,
    markers: Sequence[int],
    *,
    context: int = 1,
    order: int = 2,
    window: int = 200,
    replicas: int = 5,
    epochs: int = 100,
    n_siblings: int = 6,
    seed: int = 0,
) -> FloatArray:
    """Predict markers by networks, one for each, trained side by side on the take itself.

    Parameters
    ----------
    positions
        (n_frames, n_markers, n_dims) mm without NaN in the markers of the body.
    trusted
        (n_frames, n_markers): the frames to learn from.
    body
        The mesh that says who is parent and sibling.
    markers
        Indices of the markers to predict.
    context, order
        Number of past frames (k = 1) and highest power (L = 2) of the inputs.
    window
        Frames of the marker's own moving average, longer than any artefact.
    replicas
        P: how often the output is repeated; the prediction is the mean of all (Eq. 10).
    epochs
        Steps of training; more follow the data closer, artefacts as well.
    n_siblings
        How many siblings are used at most.
    seed
        Of the initial weights; a marker's network does not depend on which others are trained.

    Returns
    -------
    (n_frames, len(markers), n_dims) mm: the mean of the replicas (Eq. 10); NaN for a marker
    without neighbours or with fewer than ten trusted frames.

    Notes
    -----
    Skurowski & Pawlyta, section 3.3.3: inputs of Eq. 11, 12 and 4 P sigmoid neurons, linear
    output, scaled conjugate gradients.  They print 4 M neurons without a meaning of M; P = 5
    replicas give the 20 that work.  The error is squared, in units of each coordinate's spread.
    """
    outputs = ffnn_replicas(
        positions,
        trusted,
        body,
        markers,
        context=context,
        order=order,
        window=window,
        replicas=replicas,
        epochs=epochs,
        n_siblings=n_siblings,
        seed=seed,
    )
    predicted: FloatArray = outputs.mean(axis=2)
    return predicted


def ffnn_replicas(
    positions: FloatArray,
    trusted: BoolArray,
    body: Body,
    markers: Sequence[int],
    *,
    context: int = 1,
    order: int = 2,
    window: int = 200,
    replicas: int = 5,
    epochs: int = 100,
    n_siblings: int = 6,
    seed: int = 0,
) -> FloatArray:
    """Predict as `ffnn` does, and give each replica of the output (Fig. 9) by itself.

    Returns
    -------
    (n_frames, len(markers), replicas, n_dims) mm.
    """
    n_frames, _, n_dims = positions.shape
    predicted = np.full((n_frames, len(markers), replicas, n_dims), np.nan)
    able = [
        place
        for place, marker in enumerate(markers)
        if regressor_markers(body, marker, n_siblings) and trusted[:, marker].sum() >= 10
    ]
    width = (n_siblings + 1) * n_dims * order * (context + 1) + n_dims
    shape = scg.Shape((width, HIDDEN, PER_REPLICA * replicas, n_dims * replicas))
    size = max(1, BLOCK // n_frames)
    for group in (able[at : at + size] for at in range(0, len(able), size)):
        chosen = [markers[place] for place in group]
        columns = []
        for marker in chosen:
            neighbours = regressor_markers(body, marker, n_siblings)
            own = moving_average(positions[:, marker], trusted[:, marker], window)
            columns.append((powers(positions, neighbours, order), standardised(own)))
        frames = _frames_to_learn(trusted[:, chosen])
        targets = np.stack([positions[f, m] for f, m in zip(frames, chosen, strict=True)])
        mean, spread = targets.mean(axis=1, keepdims=True), targets.std(axis=1, keepdims=True)
        spread = np.maximum(spread, 1e-9)
        inputs = np.stack(
            [_rows(c, f, context, width) for c, f in zip(columns, frames, strict=True)]
        )
        weights = scg.train(
            shape,
            scg.initial(shape, [seed * 1_000_003 + marker for marker in chosen]),
            inputs,
            np.tile((targets - mean) / spread, replicas),
            np.full((len(chosen), inputs.shape[1], 1), 1.0 / inputs.shape[1]),
            epochs,
        )
        step = max(1, BLOCK // len(group))
        for at in range(0, n_frames, step):
            block = np.arange(at, min(at + step, n_frames))
            rows = np.stack([_rows(c, block, context, width) for c in columns])
            output = scg.forward(shape, weights, rows)[-1]
            output = output.reshape(len(group), len(block), replicas, n_dims)
            output = output * spread[:, :, None] + mean[:, :, None]
            predicted[block[:, None], group] = output.transpose(1, 0, 2, 3)
    return predicted


def _frames_to_learn(trusted: BoolArray) -> NDArray[np.intp]:
    """Choose equally many trusted frames for each marker, evenly; (n_markers, n)."""
    n = min(LEARNT, len(trusted))
    known = [np.flatnonzero(column) for column in trusted.T]
    return np.stack([own[np.linspace(0, len(own) - 1, n).round().astype(np.intp)] for own in known])


def _rows(
    columns: tuple[FloatArray, FloatArray], frames: NDArray[np.intp], context: int, width: int
) -> FloatArray:
    """Build the inputs of Eq. 11; missing siblings are columns of zeros."""
    neighbours, own = columns
    rows = np.zeros((len(frames), width))
    past = with_past(neighbours, frames, context)
    rows[:, : past.shape[1]] = past
    rows[:, -own.shape[1] :] = own[frames]
    return rows
