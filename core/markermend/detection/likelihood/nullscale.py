"""How large a score usually is, given what the body does: a scale learnt from the take itself."""

import numpy as np
from scipy.ndimage import uniform_filter1d

from markermend.model import BoolArray, FloatArray

_STRIDE = 4
_ROUNDS = 4
_CLIP = 1.5  # robust deviations beyond which a score does not pull the fit upwards
_SHRINK = 60.0  # samples that a marker's own slope has to outweigh


def learnt_scale(
    score: FloatArray, covariates: tuple[FloatArray, ...], valid: BoolArray
) -> FloatArray:
    """Regress the logarithm of a score on covariates: pooled slopes, own levels, shrunk own slopes.

    Artefacts are rare and large; residuals above `_CLIP` deviations are clipped, so that they
    hardly raise the scale that they are compared with.

    Parameters
    ----------
    score
        (n_markers, n_frames), positive.
    covariates
        Each (n_markers, n_frames), positive; their logarithms are used.
    valid
        (n_markers, n_frames): frames to learn from.

    Returns
    -------
    FloatArray
        (n_markers, n_frames): the typical score.
    """
    y = np.log(np.maximum(score, 1e-3))
    X = np.stack([np.log(np.maximum(c, 1e-6)) for c in covariates], axis=2)
    some = slice(None, None, _STRIDE)
    ys, Xs, ws = y[:, some], X[:, some], valid[:, some].astype(np.float64)
    weight = np.maximum(ws.sum(1), 1.0)
    centre = (Xs * ws[..., None]).sum(1) / weight[:, None]
    Xs = (Xs - centre[:, None]) * ws[..., None]
    level = np.array(
        [np.median(row[w > 0]) if w.any() else 0.0 for row, w in zip(ys, ws, strict=True)]
    )
    p = X.shape[2]
    pooled, own = np.zeros(p), np.zeros((len(y), p))
    each = np.matmul(np.swapaxes(Xs, 1, 2), Xs)
    variance = each.sum(0).diagonal() / max(ws.sum(), 1.0)
    for _ in range(_ROUNDS):
        slope = pooled + own
        rest = (ys - level[:, None] - np.einsum("mtp,mp->mt", Xs, slope)) * ws
        spread = 1.4826 * np.array(
            [
                np.median(np.abs(row[w > 0])) if w.any() else 1.0
                for row, w in zip(rest, ws, strict=True)
            ]
        )
        rest = np.minimum(rest, _CLIP * spread[:, None])
        rest = np.maximum(rest, -3.0 * spread[:, None])
        level = level + rest.sum(1) / weight
        right = np.einsum("mtp,mt->mp", Xs, rest)
        ridge = np.diag(1e-3 * ws.sum() * variance + 1e-9)
        change = np.linalg.solve(each.sum(0) + ridge, right.sum(0))
        pooled = pooled + change
        right = right - each @ change - _SHRINK * variance * own
        own = (
            own
            + np.linalg.solve(each + np.diag(_SHRINK * variance + 1e-9), right[..., None])[..., 0]
        )
    fitted = level[:, None] + np.einsum("mtp,mp->mt", X - centre[:, None], pooled + own)
    typical: FloatArray = np.exp(fitted)
    return typical


def speeds(positions: FloatArray, rate: float, width: int) -> FloatArray:
    """(n_markers, n_frames) mm/s, averaged over `width` frames."""
    step = np.zeros(positions.shape[:2])
    step[1:] = np.sqrt((np.diff(positions, axis=0) ** 2).sum(2)) * rate
    step[0] = step[1] if len(step) > 1 else 0.0
    smooth: FloatArray = uniform_filter1d(step, width, axis=0, mode="nearest").T
    return smooth
