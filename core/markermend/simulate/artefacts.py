"""Artefacts put in by hand, and the truth about them.

The kinds are those of Skurowski and Pawlyta (2022), section 3.4: isolated peaks, heavy noise, step
(rectangular) and slow (triangular) changes, besides gaps; and their figure 14, a peak on a slow
change.
"""

from collections.abc import Iterable, Sequence

import numpy as np

from markermend.errors import BadInput
from markermend.model import AXES, FloatArray, Kind, Take
from markermend.truth import Truth


def distort(
    take: Take, wanted: Iterable[Truth], rng: np.random.Generator
) -> tuple[Take, tuple[Truth, ...]]:
    """Put artefacts into a take, in the order given; gaps last.

    Parameters
    ----------
    take
        A clean take.
    wanted
        The artefacts. Swaps may be given for one marker of the two; their amplitude is measured.
    rng
        Source of signs and of heavy noise.

    Returns
    -------
    The distorted take, and what was put in, ordered by time.

    Raises
    ------
    BadInput
        If an artefact reaches beyond the take.
    UnknownName
        If there is no such marker.
    """
    positions = take.positions.copy()
    done: list[Truth] = []
    for truth in sorted(wanted, key=lambda one: one.kind == "gap"):
        if truth.span.stop > take.n_frames:
            raise BadInput(
                f"The {truth.kind} at {truth.marker} ends at frame {truth.span.stop}, but the take "
                f"has {take.n_frames} frames; put it earlier."
            )
        done += _put(positions, take, truth, rng)
    done.sort(key=lambda one: (one.span, one.marker, one.kind))
    return take.with_positions(positions), tuple(done)


def _put(
    positions: FloatArray, take: Take, truth: Truth, rng: np.random.Generator
) -> Sequence[Truth]:
    marker, frames = take.index(truth.marker), truth.span.frames
    if truth.partner is not None:
        return _swap(positions, take, truth)
    if truth.kind == "gap":
        positions[frames, marker] = np.nan
        return [truth]
    axes = [AXES.index(axis) for axis in truth.axes]
    signs = rng.choice([-1.0, 1.0], len(axes))
    height = float(truth.amplitude or 0.0)
    if truth.kind == "noise":
        shape = height * rng.standard_normal((len(truth.span), len(axes)))
    else:
        profile = _profile(truth.kind, len(truth.span))
        shape = height / np.sqrt(len(axes)) * signs * profile[:, None]
    offset = np.zeros((len(truth.span), take.n_dims))
    offset[:, axes] = shape
    positions[frames, marker] += offset
    return [truth]


def _profile(kind: Kind, length: int) -> FloatArray:
    """Height over time, at most 1: a triangle for slow changes and peaks, else a rectangle."""
    if kind == "step":
        return np.ones(length)
    ramp = np.arange(1, length + 1)
    triangle: FloatArray = np.minimum(ramp, ramp[::-1]) / ((length + 1) // 2)
    return triangle


def _swap(positions: FloatArray, take: Take, truth: Truth) -> Sequence[Truth]:
    """Exchange two markers, as a wrong label does: a step at each of them."""
    partner = str(truth.partner)
    one, other = take.index(truth.marker), take.index(partner)
    frames = truth.span.frames
    positions[frames, [one, other]] = positions[frames, [other, one]]
    apart = positions[truth.span.start, one] - positions[truth.span.start, other]
    distance = float(np.linalg.norm(apart))
    return [
        Truth(marker, truth.span, "step", round(distance, 3), AXES, mate)
        for marker, mate in ((truth.marker, partner), (partner, truth.marker))
    ]
