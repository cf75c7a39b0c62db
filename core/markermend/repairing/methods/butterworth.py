"""Zero-lag low-pass for heavy noise."""

from typing import Annotated

import numpy as np
from scipy.signal import butter, sosfiltfilt

from markermend.errors import CannotRepair
from markermend.model import FloatArray
from markermend.params import Within
from markermend.registry import method
from markermend.repairing.problem import Problem


@method(
    title="Butterworth, zero lag",
    kinds=("noise", "peak"),
    source="D. A. Winter, Biomechanics and Motor Control of Human Movement, 2009, section 3.4",
)
def butterworth(
    problem: Problem,
    *,
    cutoff: Annotated[float, Within(0.5, 60, "Hz")] = 6.0,
    order: Annotated[int, Within(1, 6)] = 2,
) -> FloatArray:
    """Smooth what was recorded in the span by a low-pass filter run there and back.

    Parameters
    ----------
    cutoff
        Frequency at which half the power is left, after both runs.
    order
        Order of one run; both together have twice that.

    Returns
    -------
    (len(span), n_dims) mm.

    Raises
    ------
    CannotRepair
        If something in the span was not recorded, or the cut-off is not below half the rate.
    """
    span, rate = problem.span, problem.rate
    label = problem.labels[problem.marker]
    if cutoff >= 0.5 * rate:
        raise CannotRepair(
            f"A cut-off of {cutoff:g} Hz needs more than twice that as the rate, not the {rate:g} "
            "Hz of this take; choose a lower one."
        )
    reach = span.padded(round(3.0 * rate / cutoff), problem.n_frames)
    values = problem.own[reach.frames].copy()
    at = slice(span.start - reach.start, span.stop - reach.start)
    values[at] = problem.recorded[span.frames]
    if not np.isfinite(values[at]).all():
        raise CannotRepair(
            f"{label} was not recorded in the whole span, and there is nothing to smooth; choose a "
            "method that fills gaps."
        )
    start, stop = _run_around(np.isfinite(values[:, 0]), at)
    if stop - start <= 3 * (2 * order + 1):
        raise CannotRepair(
            f"Only {stop - start} frames of {label} are seen in one piece here; choose a lower "
            "order or another method."
        )
    # Running twice halves the power at the cut-off once more; Winter's correction undoes that, on
    # the axis of frequencies as the bilinear transform bends it.
    bent = np.tan(np.pi * cutoff / rate) / (2.0**0.5 - 1.0) ** (0.5 / order)
    single = rate / np.pi * np.arctan(bent)
    sos = butter(order, single, fs=rate, output="sos")
    length = min(3 * (2 * order + 1) * 4, stop - start - 1)
    smooth = sosfiltfilt(sos, values[start:stop], axis=0, padlen=length)
    return np.asarray(smooth[at.start - start : at.stop - start])


def _run_around(seen: np.ndarray, at: slice) -> tuple[int, int]:
    before, after = np.flatnonzero(~seen[: at.start]), np.flatnonzero(~seen[at.stop :])
    start = int(before[-1]) + 1 if len(before) else 0
    return start, at.stop + int(after[0]) if len(after) else len(seen)
