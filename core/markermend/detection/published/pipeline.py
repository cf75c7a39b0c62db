"""Gaps first, then peaks, heavy noise, steps and slow changes, each interpolated away."""

import numpy as np
from numpy.typing import NDArray

from markermend.body import infer
from markermend.detection.published import stages
from markermend.detection.published.interpolate import interpolated
from markermend.detection.published.merge import findings
from markermend.detection.published.settings import Settings
from markermend.model import BoolArray, Finding, FloatArray, Take
from markermend.predict import polynomial

# The sharp stages look at so many samples at once, which bounds their memory on long takes.
BLOCK = 2_000_000
EVIDENCE_S = 0.5


def run(take: Take, settings: Settings) -> list[Finding]:
    """Find peaks, heavy noise, steps and slow changes on the measured markers of a take."""
    markers = np.array([m for m in take.measured if take.seen[:, m].any()], np.intp)
    clean = take.positions.copy()
    trusted = np.zeros(take.positions.shape, bool)
    found: list[Finding] = []
    size = max(1, BLOCK // (take.n_frames * take.n_dims))
    for block in (markers[at : at + size] for at in range(0, len(markers), size)):
        some, clean[:, block], trusted[:, block] = _sharp(take, block, settings)
        found += some
    body = infer(take)
    for marker in markers:
        known = np.asarray(trusted[:, marker].all(axis=1))
        predicted = polynomial(
            clean, known, body, int(marker), order=settings.order, context=settings.context
        )
        if predicted is None:
            continue
        stage = stages.slow_changes(clean[:, marker] - predicted, trusted[:, marker], settings)
        found += _findings(take, stage, predicted, trusted[:, marker], np.array([marker]))
    return found


def _sharp(
    take: Take, block: NDArray[np.intp], settings: Settings
) -> tuple[list[Finding], FloatArray, BoolArray]:
    """Run the three sudden stages on some markers; give the cleaned positions as well."""
    shape = (take.n_frames, len(block), take.n_dims)
    x = take.positions[:, block].reshape(take.n_frames, -1)
    trusted = np.isfinite(x)
    x = interpolated(x, ~trusted)
    found: list[Finding] = []
    for look in (stages.peaks, stages.heavy_noise, stages.steps):
        stage = look(x, trusted, settings)
        left = trusted & ~stage.mask()
        x = interpolated(x, ~left)
        found += _findings(take, stage, x, trusted, block)
        trusted = left
    return found, x.reshape(shape), trusted.reshape(shape)


def _findings(
    take: Take,
    stage: stages.Stage,
    expected: FloatArray,
    trusted: BoolArray,
    block: NDArray[np.intp],
) -> list[Finding]:
    labels = [take.labels[m] for m in block]
    pad = max(1, round(EVIDENCE_S * take.rate))
    return findings(stage, expected, trusted, labels, take.n_dims, pad)
