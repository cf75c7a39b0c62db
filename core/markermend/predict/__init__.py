"""Predictors: where a marker should be, by its own past or by its neighbours."""

from markermend.predict.ffnn import ffnn, ffnn_replicas
from markermend.predict.polynomial import polynomial
from markermend.predict.smoothing import median_highpass, savgol_highpass, savgol_lowpass

__all__ = [
    "ffnn",
    "ffnn_replicas",
    "median_highpass",
    "polynomial",
    "savgol_highpass",
    "savgol_lowpass",
]
