"""Noise spectra of residuals, and the filters that whiten them."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy import fft
from scipy.ndimage import median_filter
from scipy.signal import get_window

from markermend.model import FloatArray

_SEGMENT = 256
_BINS_OF_MEDIAN = 0.7  # about ln 2: the median of an exponential variable over its mean


@lru_cache(maxsize=512)
def _power(template: bytes, size: int) -> FloatArray:
    """Power spectrum of a template; bins that stand for two frequencies count twice."""
    power: FloatArray = np.abs(fft.rfft(np.frombuffer(template, np.float64), size)) ** 2
    power[1 : (size + 1) // 2] *= 2.0
    return power


@dataclass(frozen=True, eq=False)
class Whitened:
    """Series divided by their noise spectrum, ready for any template.

    Attributes
    ----------
    g
        (n_series, n_frames): the inverse-spectrum filtered series.
    weight
        (n_series, n_bins): 1 / noise spectrum on the grid of `size` frames.
    size
        Length of the grid.
    """

    g: FloatArray
    weight: FloatArray
    size: int

    def energy(self, template: FloatArray) -> FloatArray:
        """(n_series,): energy q of a template; the squared statistic is N^2 / q."""
        energies: FloatArray = self.weight @ _power(template.tobytes(), self.size) / self.size
        return energies


def noise_spectrum(series: FloatArray, floor: float, size: int, steps: int = 1) -> FloatArray:
    """Robust power spectrum of each series on a grid, variance per frame.

    Welch's method on differences (so that strong low frequencies do not leak), the median over
    half overlapping segments instead of the mean, 1 / f^2 below the lowest bin.

    Parameters
    ----------
    series
        (n_series, n_frames) mm.
    floor
        mm: white noise that is always assumed.
    size
        Frames of the grid.
    steps
        How often to difference first: 1 for residuals, 2 for positions.

    Returns
    -------
    FloatArray
        (n_series, size // 2 + 1).
    """
    n = series.shape[1]
    length = min(_SEGMENT, max(16, n // 3))
    window = get_window("hann", length)
    difference = np.diff(series, n=steps, axis=1)
    starts = np.arange(0, difference.shape[1] - length + 1, length // 2)
    index = starts[:, None] + np.arange(length)
    spectra = np.abs(fft.rfft(difference[:, index] * window, axis=2)) ** 2
    power = np.median(spectra, axis=1) / _BINS_OF_MEDIAN / (window**2).sum()
    frequencies = np.arange(length // 2 + 1) / length
    response = (2.0 * np.sin(np.pi * frequencies)) ** (2 * steps)
    power[:, 1:] /= response[1:]
    power[:, 0] = power[:, 1] * 4.0
    power = np.exp(median_filter(np.log(power + 1e-12), size=(1, 5), mode="nearest"))
    grid = np.arange(size // 2 + 1) / size
    out = np.empty((len(series), len(grid)))
    for i, p in enumerate(power):
        out[i] = np.exp(np.interp(grid, frequencies[1:], np.log(p[1:])))
    below = grid < frequencies[1]
    slope = np.maximum(grid, 0.25 / size)[below] / frequencies[1]
    out[:, below] = power[:, 1, None] * slope[None] ** (-2.0 * steps)
    return out + floor**2


def whiten(series: FloatArray, floor: float, steps: int = 1, slowest: float = 0.0) -> Whitened:
    """Divide each series by its own noise spectrum.

    The ends are continued by point reflection, which keeps level and slope.

    Parameters
    ----------
    series, floor, steps
        As for `noise_spectrum`.
    slowest
        Cycles per frame below which everything counts as noise.
    """
    n = series.shape[1]
    pad = min(n - 1, 256)
    size = fft.next_fast_len(n + 2 * pad, real=True)
    weight = 1.0 / noise_spectrum(series, floor, size, steps)
    if slowest > 0.0:
        fourth = (np.arange(size // 2 + 1) / size) ** 4
        weight *= fourth / (fourth + slowest**4)
    left = 2 * series[:, :1] - series[:, pad:0:-1]
    right = 2 * series[:, -1:] - series[:, -2 : -pad - 2 : -1]
    extended = np.concatenate((left, series, right), axis=1)
    # Take the trend from end to end out, so that the circle closes; the filter ignores it anyway.
    line = np.linspace(0.0, 1.0, extended.shape[1])
    extended = extended - extended[:, :1] - (extended[:, -1:] - extended[:, :1]) * line
    g = fft.irfft(fft.rfft(extended, size, axis=1) * weight, size, axis=1)
    return Whitened(np.ascontiguousarray(g[:, pad : pad + n]), weight, size)


def principal_axes(vectors: FloatArray, steps: int) -> FloatArray:
    """Directions along which a marker's fast changes are independent: (n_markers, 3, 3), columns.

    Eigenvectors of the covariance of the directions of differences of order `steps`; lengths do
    not count, so that artefacts, which are few, hardly turn the axes.

    Parameters
    ----------
    vectors
        (n_markers, n_frames, 3) mm.
    steps
        As for `whiten`.
    """
    difference = np.diff(vectors, n=steps, axis=1)
    length = np.sqrt((difference**2).sum(2, keepdims=True))
    direction = difference / np.maximum(length, 1e-9)
    axes: FloatArray = np.linalg.eigh(np.matmul(np.swapaxes(direction, 1, 2), direction))[1]
    return axes


def series_along(vectors: FloatArray, axes: FloatArray) -> FloatArray:
    """(3 * n_markers, n_frames): three series per marker, along its own axes."""
    turned = np.matmul(vectors, axes)
    return np.ascontiguousarray(turned.transpose(0, 2, 1)).reshape(-1, vectors.shape[1])
