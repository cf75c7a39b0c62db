"""One finding in several versions, as the small pictures of feedback and adjudication show it."""

import warnings
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from markermend.model import AXES, FloatArray, Kind, Span, Take

LEAST_S = 0.15
"""What is shown on both sides of a span, at least."""


@dataclass(frozen=True, eq=False)
class Sight:
    """One axis of a marker around a span.

    Attributes
    ----------
    kind, start_s, stop_s
        What is to be seen, and where it is: from half a frame before it to half a frame before
        the next.
    axis
        The axis on which the versions differ most; of one version, that on which it moves most.
    unit
        Of the values.
    time
        (n,) s.
    lines
        Name of the version -> (n,) values, NaN where there is nothing.
    """

    kind: Kind
    start_s: float
    stop_s: float
    axis: str
    unit: str
    time: FloatArray
    lines: Mapping[str, FloatArray]


def around(take: Take, span: Span) -> Span:
    """Give the frames that a picture of a span shows."""
    pad = max(round(LEAST_S * take.rate), len(span) // 2, 3)
    return span.padded(pad, take.n_frames)


def sight(
    take: Take,
    kind: Kind,
    span: Span,
    versions: Mapping[str, FloatArray],
    against: FloatArray | None = None,
) -> Sight:
    """Choose the axis that shows most, and take away what hides it.

    Parameters
    ----------
    take
        For its rate and units.
    kind, span
        What is to be seen.
    versions
        Name -> (len(around), n_dims) mm over the frames of `around`.
    against
        (len(around), n_dims) mm, what is subtracted; by default a straight line through the ends
        of the first version, so that the marker's travel does not hide what is small.
    """
    frames = around(take, span)
    base = _chord(next(iter(versions.values()))) if against is None else against
    off = {name: values - base for name, values in versions.items()}
    spread = _spread(np.stack(list(off.values())))
    axis = int(np.argmax(spread))
    return Sight(
        kind,
        (span.start - 0.5) / take.rate,
        (span.stop - 0.5) / take.rate,
        AXES[axis],
        take.units,
        np.arange(frames.start, frames.stop) / take.rate,
        {name: values[:, axis] for name, values in off.items()},
    )


def _spread(values: FloatArray) -> FloatArray:
    """Give (n_dims,): how far apart (n_versions, n, n_dims) are at most, else how far they go."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # nothing is known at some times
        between = np.nanmax(np.nanmax(values, axis=0) - np.nanmin(values, axis=0), axis=0)
        over = np.nanmax(values, axis=(0, 1)) - np.nanmin(values, axis=(0, 1))
    chosen: FloatArray = np.nan_to_num(between if np.nanmax(between) > 1e-9 else over)
    return chosen


def _chord(values: FloatArray) -> FloatArray:
    seen = np.flatnonzero(np.isfinite(values).all(axis=1))
    if len(seen) == 0:
        return np.zeros_like(values)
    first, last = seen[0], seen[-1]
    share = (np.arange(len(values)) - first) / max(1, last - first)
    line: FloatArray = values[first] + share[:, None] * (values[last] - values[first])
    return line
