"""Interpolation of what a stage found, so that the next one does not find it again."""

import numpy as np
from scipy.interpolate import PchipInterpolator

from markermend.model import BoolArray, FloatArray


def interpolated(x: FloatArray, missing: BoolArray) -> FloatArray:
    """Replace missing samples by monotone cubics through the others; ends stay at their last value.

    Parameters
    ----------
    x
        (n_frames, n_columns); NaN only where missing.
    missing
        Of the same shape.  A column of which nothing is known becomes 0.
    """
    y = x.copy()
    frames = np.arange(len(x))
    for column in np.flatnonzero(missing.any(axis=0)):
        holes = missing[:, column]
        known = frames[~holes]
        if len(known) < 2:
            y[holes, column] = x[known[0], column] if len(known) else 0.0
            continue
        inner = np.clip(frames[holes], known[0], known[-1])
        y[holes, column] = PchipInterpolator(known, x[known, column])(inner)
    return y
