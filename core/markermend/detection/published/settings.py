"""The tunable values of all stages, in the frames of the take at hand."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Settings:
    """What the stages need to know; lengths in frames of the take.

    Attributes
    ----------
    peak_window, peak_k, peak_ratio, peak_size
        Window of the moving median, threshold_1 in standard deviations, threshold_2, maxSize.
    noise_k, noise_length
        Threshold in standard deviations, minLen.
    step_k, step_length, step_distance
        Threshold in standard deviations, minLen, maxDist.
    savgol_order, savgol_window
        L and M of the noise and step stages.
    slow_k, slow_low, slow_top, slow_length
        T_U and T_L in standard deviations of the residual, tau_U, tau_hv.
    predictor, order, context, average, epochs
        ``"polynomial"`` with its L and k, or ``"ffnn"`` with its moving average and training.
    as_printed
        Whether the misprinted equations are followed to the letter.
    """

    peak_window: int
    peak_k: float
    peak_ratio: float
    peak_size: int
    noise_k: float
    noise_length: int
    step_k: float
    step_length: int
    step_distance: int
    savgol_order: int
    savgol_window: int
    slow_k: float
    slow_low: float
    slow_top: int
    slow_length: int
    predictor: str
    order: int
    context: int
    average: int
    epochs: int
    as_printed: bool = False
