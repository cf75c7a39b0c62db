"""Predictors from a coordinate's own neighbourhood in time: moving median and Savitzky-Golay."""

import numpy as np
from scipy.ndimage import median_filter
from scipy.signal import savgol_filter

from markermend.model import FloatArray


def scaled(frames: float, rate: float, least: int = 1) -> int:
    """Turn a number of frames at 100 Hz into frames at `rate`, at least `least`."""
    return max(least, round(frames * rate / 100.0))


def odd(frames: float, rate: float, least: int = 3) -> int:
    """Turn a window at 100 Hz into the nearest odd window at `rate`."""
    return max(least, 2 * round((frames * rate / 100.0 - 1.0) / 2.0) + 1)


def median_highpass(values: FloatArray, window: int) -> FloatArray:
    """Give what a moving median leaves (Skurowski & Pawlyta, Eq. 18).

    Parameters
    ----------
    values
        (n_frames, n) without NaN.
    window
        Odd number of frames; the ends repeat their last value.
    """
    slow = np.stack([median_filter(x, window, mode="nearest") for x in values.T], axis=1)
    fast: FloatArray = values - slow
    return fast


def savgol_lowpass(values: FloatArray, order: int, window: int) -> FloatArray:
    """Fit a polynomial in every window and give its middle (Skurowski & Pawlyta, Eq. 6).

    Parameters
    ----------
    values
        (n_frames, n) without NaN.
    order
        Degree L of the polynomial.
    window
        Odd length of the window, the M = 13 of the paper.  Both are cut to what short signals
        allow; fewer than three frames come back as they are.
    """
    window = min(window, len(values) - 1 + len(values) % 2)
    if window < 3:
        return values.copy()
    smooth: FloatArray = savgol_filter(values, window, min(order, window - 1), axis=0)
    return smooth


def savgol_highpass(values: FloatArray, order: int, window: int) -> FloatArray:
    """Give what the Savitzky-Golay filter leaves (Skurowski & Pawlyta, Eq. 7)."""
    return values - savgol_lowpass(values, order, window)
