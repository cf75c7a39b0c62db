"""What was recorded inside a span, where there is an artefact and not a gap, is evidence too."""

from dataclasses import replace

import numpy as np

from markermend.model import FloatArray
from markermend.repairing.blend.blend import Blend
from markermend.repairing.kriging import matern32
from markermend.repairing.problem import Outcome, Problem

SMOOTH = 0.3
"""Length of the correlation of a fill's error, in lengths of the span."""
WIDER = 1.2
"""A fill's error as a share of what the pseudo-gaps say, set on other recordings."""
USUAL = 3.0
"""An axis stays as it was recorded where it is off the fill by less than so many times the error
that is to be expected."""
LEAST_FOR_NOISE = 5
FLOOR_MM2 = 1e-6


def with_recorded(problem: Problem, done: Outcome, found: Blend | None) -> Outcome:
    """Weigh the fill of an artefact against what was recorded there.

    Under heavy noise every sample is an observation with a variance that the second differences
    of its axis tell, and the fill is a Gaussian process about them whose variance the pseudo-gaps
    tell; the result is its posterior mean.  Under any other artefact an axis on which nothing
    unusual was recorded stays as it was.

    Parameters
    ----------
    problem
        The span.
    done
        How it would be filled as a gap.
    found
        The mix that was tested; without it the fill stays as it is.

    Returns
    -------
    The fill, with band and expected error smaller by as much as the recording tells.
    """
    recorded = problem.recorded[problem.span.frames]
    known = np.isfinite(recorded[:, 0])
    if found is None or problem.kind == "gap" or not known.all():
        return done
    spread = WIDER * found.spread() / np.sqrt(problem.n_dims) + np.sqrt(FLOOR_MM2)
    off = recorded - done.values
    if problem.kind == "noise" and len(off) >= LEAST_FOR_NOISE:
        values, left = _posterior(off, spread)
        note = "The noisy samples count by how noisy each axis is."
    else:
        same = (np.abs(off) <= USUAL * spread[:, None]).all(axis=0)
        if not same.any() or same.all():
            return done
        values, left = np.where(same, off, 0.0), np.full(len(off), np.sqrt(1 - same.mean()))
        note = f"{', '.join('xyz'[a] for a in np.flatnonzero(same))} stays as recorded."
    return replace(
        done,
        values=done.values + values,
        band=None if done.band is None else done.band * left,
        expected_mm=None if done.expected_mm is None else done.expected_mm * float(left.mean()),
        note=f"{done.note} {note}",
    )


def _posterior(off: FloatArray, spread: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Give what to believe of it, and the error that is left, as a share by frame.

    The axes are those of the noise, the second differences' own, so that they turn with the room;
    where the noise is on one axis of the room, it is one of them.
    """
    frames = np.arange(len(off))
    lag = (frames[:, None] - frames) / (SMOOTH * len(off))
    prior = matern32(lag) * np.outer(spread, spread)
    rough = np.diff(off, n=2, axis=0)
    # The second difference of white noise has six times its variance.
    noises, axes = np.linalg.eigh(rough.T @ rough / (6.0 * len(rough)))
    believed = np.zeros_like(off)
    left = np.zeros(len(off))
    for noise, axis in zip(np.maximum(noises, 0.0) + FLOOR_MM2, axes.T, strict=True):
        gain = np.linalg.solve(prior + noise * np.eye(len(prior)), prior).T
        believed += np.outer(gain @ (off @ axis), axis)
        left += np.maximum(np.diag(prior) - np.einsum("ij,ji->i", gain, prior), 0.0)
    return believed, np.sqrt(left / (off.shape[1] * np.diag(prior)))
