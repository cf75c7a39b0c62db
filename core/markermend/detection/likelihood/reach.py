"""The smallest slow change that would be seen, marker by marker."""

from dataclasses import dataclass

import numpy as np

from markermend.detection.likelihood.findings import scanned
from markermend.detection.likelihood.window import Settings
from markermend.detection.progress import Progress, unheard
from markermend.model import FloatArray, Take


@dataclass(frozen=True)
class Reach:
    """How small a slow change of half a second may be and still be found.

    Attributes
    ----------
    marker
        Label.
    usual_mm
        Amplitude that suffices in half of the frames.
    fast_mm
        Amplitude that suffices in 90 % of them: where the marker is hard to predict.
    """

    marker: str
    usual_mm: float
    fast_mm: float


def smallest_slow_changes(
    take: Take, settings: Settings | None = None, progress: Progress = unheard
) -> tuple[Reach, ...]:
    """Tabulate the reach of the slow stage, for the markers that it looks at.

    Parameters
    ----------
    take
        The take.
    settings
        As the detector is run with; by default as designed.
    progress
        Called with the number of windows done and of all.

    Returns
    -------
    tuple[Reach, ...]
        In the order of the take; markers without enough mates are left out. It costs one scan.
    """
    settings = settings or Settings(take.rate)
    needed: dict[str, list[FloatArray]] = {}
    for piece in scanned(take, settings, progress):
        if piece.scan.needed is not None:
            for label, row in zip(piece.labels, piece.scan.needed, strict=True):
                needed.setdefault(label, []).append(row[::4])
    table = []
    for m in take.measured:
        rows = needed.get(take.labels[m])
        if rows:
            usual, fast = np.quantile(np.concatenate(rows), [0.5, 0.9])
            least = settings.least_slow
            table.append(Reach(take.labels[m], max(float(usual), least), max(float(fast), least)))
    return tuple(table)
