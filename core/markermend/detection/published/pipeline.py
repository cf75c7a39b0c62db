"""Gaps first, then peaks, heavy noise, steps and slow changes, each interpolated away."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from markermend.body import Body, infer
from markermend.detection.progress import Progress, unheard
from markermend.detection.published import stages
from markermend.detection.published.interpolate import interpolated
from markermend.detection.published.merge import findings
from markermend.detection.published.settings import Settings
from markermend.model import BoolArray, Finding, FloatArray, Take
from markermend.predict import ffnn, polynomial

# The sharp stages look at so many samples at once, which bounds their memory on long takes.
BLOCK = 2_000_000
EVIDENCE_S = 0.5


def run(take: Take, settings: Settings, progress: Progress = unheard) -> list[Finding]:
    """Find peaks, heavy noise, steps and slow changes on the measured markers of a take.

    `progress` hears of markers, each of which counts twice.

    Linear algebra runs in one thread, since rounding must not depend on the number of threads.
    """
    with threadpool_limits(1):
        return _run(take, settings, progress)


def _run(take: Take, settings: Settings, progress: Progress) -> list[Finding]:
    markers = np.array([m for m in take.measured if take.seen[:, m].any()], np.intp)
    clean = take.positions.copy()
    trusted = np.zeros(take.positions.shape, bool)
    found: list[Finding] = []
    size = max(1, BLOCK // (take.n_frames * take.n_dims))
    done = 0  # each marker counts once for the sudden stages, and once for the slow one
    for block in (markers[at : at + size] for at in range(0, len(markers), size)):
        some, clean[:, block], trusted[:, block] = _sharp(take, block, settings)
        found += some
        done += len(block)
        progress(done, 2 * len(markers))
    for marker, predicted in _predictions(infer(take), markers, clean, trusted, settings):
        done += 1
        progress(done, 2 * len(markers))
        stage = stages.slow_changes(clean[:, marker] - predicted, trusted[:, marker], settings)
        found += _findings(take, stage, predicted, trusted[:, marker], np.array([marker]))
    return found


def _predictions(
    body: Body,
    markers: NDArray[np.intp],
    positions: FloatArray,
    trusted: BoolArray,
    settings: Settings,
) -> Iterator[tuple[int, FloatArray]]:
    """Predict each marker that can be; the polynomial is made one by one to save memory."""
    known = np.asarray(trusted.all(axis=2))
    if settings.predictor == "ffnn":
        all_of_them = ffnn(
            positions,
            known,
            body,
            markers.tolist(),
            window=settings.average,
            epochs=settings.epochs,
        )
        for place, marker in enumerate(markers.tolist()):
            if np.isfinite(all_of_them[0, place, 0]):
                yield marker, all_of_them[:, place]
        return
    for marker in markers.tolist():
        predicted = polynomial(
            positions,
            known[:, marker],
            body,
            marker,
            order=settings.order,
            context=settings.context,
        )
        if predicted is not None:
            yield marker, predicted


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
