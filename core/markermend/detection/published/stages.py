"""The four stages: each looks at coordinates one by one and marks stretches of one kind.

A stage is given ``x`` (n_frames, n_columns) without NaN, and ``trusted`` of the same shape: the
samples that were seen and not taken out by a stage before.  Thresholds are k standard deviations
over the trusted samples of the column.
"""

from dataclasses import dataclass

import numpy as np

from markermend.detection.published.morphology import closing, derivative_pairs, top_hat
from markermend.detection.published.settings import Settings
from markermend.model import BoolArray, FloatArray, Kind, Span, runs
from markermend.predict import median_highpass, savgol_highpass


@dataclass(frozen=True, eq=False)
class Mark:
    """A stretch of one coordinate; `strength` is statistic over threshold, `amplitude` in mm."""

    column: int
    span: Span
    strength: float
    amplitude: float


@dataclass(frozen=True, eq=False)
class Stage:
    """What a stage found, and the signal that it looked at.

    Attributes
    ----------
    kind, name
        What is found, and what the signal is.
    marks
        One per stretch and coordinate.
    signal
        (n_frames, n_columns) mm.
    threshold, usual
        (n_columns,) mm: what the signal has to pass, and its standard deviation.
    """

    kind: Kind
    name: str
    marks: tuple[Mark, ...]
    signal: FloatArray
    threshold: FloatArray
    usual: FloatArray

    def mask(self) -> BoolArray:
        """Give the samples (n_frames, n_columns) that are marked."""
        marked = np.zeros(self.signal.shape, bool)
        for mark in self.marks:
            marked[mark.span.frames, mark.column] = True
        return marked


def differential(x: FloatArray) -> FloatArray:
    """Step from the frame before to this one; 0 in the first (Eq. 12, 19, 26)."""
    return np.diff(x, axis=0, prepend=x[:1])


def deviation(signal: FloatArray, trusted: BoolArray) -> FloatArray:
    """Give the standard deviation of each column over its trusted samples, 0 where none is."""
    counts = np.maximum(trusted.sum(axis=0), 1)
    mean = np.where(trusted, signal, 0.0).sum(axis=0) / counts
    spread: FloatArray = np.sqrt(np.where(trusted, (signal - mean) ** 2, 0.0).sum(axis=0) / counts)
    return spread


def peaks(x: FloatArray, trusted: BoolArray, settings: Settings) -> Stage:
    """Find isolated peaks (section 3.4.2)."""
    fast = median_highpass(x, settings.peak_window)  # Eq. 18
    jumps = differential(fast)  # Eq. 19
    usual = deviation(jumps, trusted)
    threshold = settings.peak_k * usual
    large = jumps if settings.as_printed else np.abs(jumps)
    kept = np.where(large > threshold, jumps, 0.0)  # Eq. 20
    candidates = peak_candidates(kept, settings)
    size = 2 * settings.peak_size + 3
    raw = candidates.astype(float)
    if not settings.as_printed:
        # The peaks of heavy noise leave holes between each other; closed, they are one wide run.
        raw = closing(raw, size)
    isolated = top_hat(raw, size, settings.as_printed) > 0.5  # Eq. 25
    marks = []
    for column in np.flatnonzero(isolated.any(axis=0)):
        for run in runs(isolated[:, column]):
            largest = float(np.abs(kept[run.frames, column]).max())
            # The window reaches beyond a large step; what only lies beside one is no peak.
            if largest > 0.0:
                span = _trimmed(run, np.abs(fast[:, column]))
                amplitude = float(np.abs(fast[span.frames, column]).max())
                strength = largest / float(threshold[column])
                marks.append(Mark(int(column), span, strength, amplitude))
    name = "step from frame to frame beside the moving median"
    return Stage("peak", name, tuple(marks), jumps, threshold, usual)


def peak_candidates(kept: FloatArray, settings: Settings) -> BoolArray:
    """Find where large steps go up as much as they go down (Eq. 21 to 24).

    Eq. 23 is printed upside down: movSum / movSumAbs never exceeds 1.
    """
    window = 2 * settings.peak_size + 3
    total = np.abs(_moving_sum(kept, window))
    absolute = _moving_sum(np.abs(kept), window)
    if settings.as_printed:
        ratio = np.divide(total, absolute, out=np.zeros_like(total), where=absolute > 0)
        return ratio > settings.peak_ratio
    return (absolute > 0) & (absolute > settings.peak_ratio * total)


def _moving_sum(x: FloatArray, window: int) -> FloatArray:
    half = window // 2
    padded = np.pad(x, ((half + 1, half), (0, 0)))
    sums = np.cumsum(padded, axis=0)
    total = sums[window:] - sums[:-window]
    # Rounding of the cumulative sum must not pass for a sum that is not 0.
    floor = 1e-12 * np.abs(padded).sum(axis=0)
    return np.where(np.abs(total) <= floor, 0.0, total)


def _trimmed(run: Span, size: FloatArray) -> Span:
    """Cut a candidate, 2 maxSize + 2 frames wide, to the frames above half its height."""
    inside = size[run.frames]
    top = int(inside.argmax())
    high = inside >= 0.5 * inside[top]
    for part in runs(high):
        if part.start <= top < part.stop:
            return Span(run.start + part.start, run.start + part.stop)
    return run


def fast_steps(x: FloatArray, settings: Settings) -> FloatArray:
    """High-passed differential, which noise and step stages share (Eq. 26 and 27)."""
    return savgol_highpass(differential(x), settings.savgol_order, settings.savgol_window)


def heavy_noise(x: FloatArray, trusted: BoolArray, settings: Settings) -> Stage:
    """Find stretches in which large steps follow each other (section 3.4.3)."""
    fast = fast_steps(x, settings)
    usual = deviation(fast, trusted)
    threshold = settings.noise_k * usual
    size = 2 * settings.noise_length - 1
    level = closing(np.abs(fast), size, settings.as_printed)  # Eq. 28
    raw = (level > threshold).astype(float)  # Eq. 29
    noisy = closing(raw, size, settings.as_printed) > 0.5  # Eq. 30
    gain = _noise_gain(settings)
    marks = []
    for column in np.flatnonzero(noisy.any(axis=0) & (threshold > 0.0)):
        for span in runs(noisy[:, column]):
            if len(span) >= settings.noise_length:
                inside = fast[span.frames, column]
                strength = max(
                    1.0, float(np.median(level[span.frames, column])) / threshold[column]
                )
                amplitude = float(np.sqrt((inside**2).mean())) / gain
                marks.append(Mark(int(column), span, float(strength), amplitude))
    name = "level of fast steps from frame to frame"
    return Stage("noise", name, tuple(marks), level, threshold, usual)


def _noise_gain(settings: Settings) -> float:
    """Root of the power that white noise of variance 1 has in `fast_steps`."""
    unit = np.zeros((8 * settings.savgol_window, 1))
    unit[len(unit) // 2] = 1.0
    return float(np.linalg.norm(fast_steps(unit, settings)))


def steps(x: FloatArray, trusted: BoolArray, settings: Settings) -> Stage:
    """Find stretches between two opposite jumps (section 3.4.4)."""
    fast = fast_steps(x, settings)
    usual = deviation(fast, trusted)
    threshold = settings.step_k * usual
    gain = _step_gain(settings)
    marks = []
    for column in np.flatnonzero((np.abs(fast) > threshold).any(axis=0) & (threshold > 0.0)):
        pairs = derivative_pairs(
            fast[:, column],
            float(threshold[column]),
            settings.step_length,
            settings.step_distance,
            settings.savgol_window // 2,
        )
        for span, jump in pairs:
            both = np.abs(fast[[span.start, min(span.stop, len(fast) - 1)], column]).mean()
            marks.append(
                Mark(int(column), span, jump / float(threshold[column]), float(both) / gain)
            )
    name = "fast step from frame to frame"
    return Stage("step", name, tuple(marks), fast, threshold, usual)


def _step_gain(settings: Settings) -> float:
    """Height of the answer of `fast_steps` to a step of 1 mm."""
    unit = np.zeros((8 * settings.savgol_window, 1))
    unit[len(unit) // 2 :] = 1.0
    return float(np.abs(fast_steps(unit, settings)).max())


def slow_changes(residual: FloatArray, trusted: BoolArray, settings: Settings) -> Stage:
    """Find long hills and valleys of the residual by hysteresis (section 3.5)."""
    usual = deviation(residual, trusted)
    upper, lower = settings.slow_k * usual, settings.slow_low * usual
    marks = []
    for column in np.flatnonzero((np.abs(residual) > upper).any(axis=0) & (upper > 0.0)):
        for sign in (1.0, -1.0):
            signal = sign * residual[:, column]
            tops = [s for s in runs(signal > upper[column]) if len(s) >= settings.slow_top]
            hills = runs(signal > lower[column])
            for hill in hills:
                inside = [s for s in tops if s.overlaps(hill)]
                if inside and len(hill) >= settings.slow_length:
                    height = float(signal[hill.frames].max())
                    strength = height / float(upper[column])
                    marks.append(Mark(int(column), hill, strength, height))
    name = "deviation from where the neighbours predict it"
    return Stage("slow", name, tuple(marks), residual, upper, usual)
