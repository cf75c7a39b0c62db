"""The likelihood-ratio detector: whitened residuals of a leave-block-out prediction."""

from typing import Annotated

from markermend.detection.likelihood.findings import detect_all
from markermend.detection.likelihood.window import Settings
from markermend.detection.progress import Progress, unheard
from markermend.model import Finding, Take
from markermend.params import Within
from markermend.registry import method

_SCALES = "noise scales"


@method(
    title="Likelihood ratio",
    kinds=("peak", "noise", "step", "slow"),
    source="Generalised likelihood ratios of templates on whitened residuals; the proposal of "
    "Skurowski & Pawlyta (section 5) to decide on all axes at once",
)
def likelihood(
    take: Take,
    progress: Progress = unheard,
    *,
    peak: Annotated[float, Within(2, 50, _SCALES)] = Settings.peak,
    noise: Annotated[float, Within(0.2, 20, "times the usual evidence")] = Settings.noise,
    step: Annotated[float, Within(2, 50, _SCALES)] = Settings.step,
    slow: Annotated[float, Within(1, 50, _SCALES)] = Settings.slow,
    least_slow: Annotated[float, Within(0, 100, "mm")] = Settings.least_slow,
    floor: Annotated[float, Within(0.01, 10, "mm")] = Settings.floor,
) -> tuple[Finding, ...]:
    """Find what neither a marker's own path nor its neighbours explain.

    Every marker is predicted from those that keep their distance to it, in a local frame of
    reference, by a ridge regression that never saw the frames it predicts. The residual is divided
    by its own noise spectrum, and templates are scored by exact likelihood ratios that join all
    axes: boxes of 1 to 3 frames (peaks), jumps (steps), triangles (slow changes); heavy noise by
    fourth differences. Peaks, noise and steps must also show in the marker's own path, which an
    artefact of a neighbour does not, and must not show in the mates' paths, as an impact does.

    Candidates down to half of a threshold are returned with ``strength`` below 1.

    Parameters
    ----------
    take
        The take; only its measured markers are looked at.
    progress
        Called with the number of windows done and of all.
    peak
        Score that a peak has to pass.
    noise
        Factor on the evidence that a segment of heavy noise has to gather.
    step
        Score that the weaker edge of a step has to pass.
    slow
        Score, over the scale learnt from the take, that a slow change has to pass.
    least_slow
        Slow changes of a smaller amplitude are not reported.
    floor
        White noise that every marker is assumed to have at least.

    Returns
    -------
    tuple[Finding, ...]
        With evidence. A swap is a ``step`` with ``partner``; a peak on a slow change shares its
        ``group`` with it. Takes of fewer than 32 frames give none.
    """
    settings = Settings(take.rate, peak, noise, step, slow, least_slow, floor)
    return detect_all(take, settings, progress)
