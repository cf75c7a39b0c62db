"""The published detector: four stages, from the simplest distortion to the hardest."""

from typing import Annotated

from markermend.detection.progress import Progress, unheard
from markermend.detection.published import Settings, run
from markermend.model import Finding, Take
from markermend.params import OneOf, Within
from markermend.predict.smoothing import odd, scaled
from markermend.registry import method

_SD = "standard deviations"
_AT_100 = "frames at 100 Hz"


@method(
    title="Published (four stages)",
    kinds=("peak", "noise", "step", "slow"),
    source="Skurowski & Pawlyta, Detection and classification of artifact distortions in optical "
    "motion capture sequences, sections 3.3 to 3.5",
)
def published(
    take: Take,
    progress: Progress = unheard,
    *,
    peak_window: Annotated[int, Within(5, 201, _AT_100)] = 19,
    peak_k: Annotated[float, Within(0.5, 50, _SD)] = 7.0,
    peak_ratio: Annotated[float, Within(1, 100)] = 5.0,
    peak_size: Annotated[int, Within(1, 20, _AT_100)] = 2,
    noise_k: Annotated[float, Within(0.5, 50, _SD)] = 8.0,
    noise_length: Annotated[int, Within(3, 500, _AT_100)] = 20,
    step_k: Annotated[float, Within(0.5, 50, _SD)] = 9.0,
    step_length: Annotated[int, Within(1, 500, _AT_100)] = 20,
    step_distance: Annotated[int, Within(2, 5000, _AT_100)] = 200,
    savgol_order: Annotated[int, Within(1, 9)] = 5,
    savgol_window: Annotated[int, Within(5, 201, _AT_100)] = 13,
    slow_k: Annotated[float, Within(0.5, 50, _SD)] = 3.0,
    slow_low: Annotated[float, Within(0, 10, _SD)] = 0.5,
    slow_top: Annotated[int, Within(1, 500, _AT_100)] = 8,
    slow_length: Annotated[int, Within(1, 2000, _AT_100)] = 20,
    predictor: Annotated[str, OneOf("polynomial", "ffnn")] = "polynomial",
    order: Annotated[int, Within(1, 6)] = 4,
    context: Annotated[int, Within(0, 20, "frames")] = 3,
    average: Annotated[int, Within(1, 5000, _AT_100)] = 200,
    epochs: Annotated[int, Within(1, 5000)] = 100,
    as_printed: bool = False,
) -> list[Finding]:
    """Find peaks, heavy noise, steps and slow changes, stage by stage.

    Each coordinate is looked at by itself; what overlaps on the axes of one marker is one finding.
    Gaps are interpolated first, and after each stage what it found.

    Parameters
    ----------
    take
        The take.
    progress
        Called with the number of markers done and of all, each counted twice.
    peak_window
        Window of the moving median that stands for legitimate motion (Eq. 18).
    peak_k
        Threshold of the steps of a peak (threshold_1); printed 3.
    peak_ratio
        How much more a peak goes up and down than it gets on (threshold_2).
    peak_size
        Longest peak (maxSize); the paper gives no value.
    noise_k
        Threshold of heavy noise; printed 2.
    noise_length
        Shortest heavy noise (minLen).
    step_k
        Threshold of the two edges of a step; printed 3.
    step_length
        Shortest step (minLen).
    step_distance
        Longest step (maxDist).
    savgol_order
        Degree L of the Savitzky-Golay filter of noise and steps.
    savgol_window
        Length M of its window; below 100 Hz as many frames as at 100 Hz.
    slow_k
        Upper threshold T_U of the residual of a slow change.
    slow_low
        Lower threshold T_L, down to which it is followed.
    slow_top
        How long it must stay above T_U (tau_U); printed 20.
    slow_length
        Shortest slow change (tau_hv); printed 50.
    predictor
        What predicts a marker from its neighbours: the polynomial, or the network of the paper.
    order
        Highest power L of the polynomial predictor.
    context
        Past frames k of the polynomial predictor.
    average
        Window of the network's moving average of the marker itself; longer than any artefact.
    epochs
        Steps of the network's training.
    as_printed
        Follow the misprints to the letter, and take the printed thresholds 3, 2, 3, 3 and lengths
        20 and 50 of the slow stage instead of the given ones.

    Notes
    -----
    Read instead of what is printed: erosion is the minimum and dilation the maximum (Eq. 13, 14);
    the peak threshold is for the absolute value of D (Eq. 20); the ratio is movSumAbs over the
    absolute value of movSum (Eq. 23).  M = 13 is the length of the window.  Peak candidates are
    closed before the top-hat, so that heavy noise is no row of isolated peaks, and a peak is cut to
    the frames above half its height.  Within the width of the Savitzky-Golay filter only the
    largest step counts, since the filter echoes it.  T_L is a multiple of the residual's deviation
    like T_U.  The printed thresholds fire everywhere, because every coordinate exceeds three
    deviations somewhere (as printed, 370 to 1,360 findings a minute on four takes of people who
    stand or lift, and no peak or noise at all); the defaults are tuned.

    Every finding has passed its stage's threshold, so that ``strength`` is at least 1: the stages
    are chained, each on what the former interpolated, and a weaker candidate that an earlier stage
    had taken would have changed all later ones. Strengths above 1 can be filtered as with any
    detector; for less, run it again with smaller k. A jump without a second one that answers it
    within ``step_distance`` is no step (section 3.4.4 pairs edges) and is not reported.
    """
    if as_printed:
        peak_k, noise_k, step_k, slow_k, slow_top, slow_length = 3.0, 2.0, 3.0, 3.0, 20, 50
    rate = take.rate
    # A jump takes one frame at any rate: fewer samples than printed would follow it.
    window = odd(savgol_window, max(rate, 100.0))
    settings = Settings(
        peak_window=odd(peak_window, rate),
        peak_k=peak_k,
        peak_ratio=peak_ratio,
        peak_size=scaled(peak_size, rate),
        noise_k=noise_k,
        noise_length=scaled(noise_length, rate, 2),
        step_k=step_k,
        step_length=scaled(step_length, rate),
        step_distance=scaled(step_distance, rate, 2),
        savgol_order=savgol_order,
        savgol_window=window,
        slow_k=slow_k,
        slow_low=slow_low,
        slow_top=scaled(slow_top, rate),
        slow_length=scaled(slow_length, rate),
        predictor=predictor,
        order=order,
        context=context,
        average=scaled(average, rate),
        epochs=epochs,
        as_printed=as_printed,
    )
    return run(take, settings, progress)
