"""The evidence lane: the signal that explains a finding, as recorded and after the repair."""

from dataclasses import dataclass, replace

import numpy as np

from markermend import curves
from markermend.model import BoolArray, Finding, FloatArray, Span, short
from markermend_app.state.values import EvidenceCurve
from markermend_app.state.workspace import Opened

NEIGHBOURS = 4
TITLES = {
    "residual": "Deviation from the neighbours’ prediction",
    "speed": "Speed",
    "acceleration": "Acceleration",
    "distance": "Change of the distances to neighbours",
}


@dataclass(frozen=True, eq=False)
class Surroundings:
    """A marker and its neighbours over some frames.

    Attributes
    ----------
    start
        Frame of the take with which the arrays begin.
    own, neighbours
        (n, n_dims) and (n, n_neighbours, n_dims) mm.
    trusted
        (n,): frames outside the finding's span.
    expected
        (n, n_dims) mm: where the neighbours put the marker.
    """

    start: int
    own: FloatArray
    neighbours: FloatArray
    trusted: BoolArray
    expected: FloatArray

    def with_own(self, own: FloatArray) -> "Surroundings":
        """Give the same surroundings of other positions of the marker."""
        return replace(self, own=own)


def surroundings(
    opened: Opened, marker: int, frames: Span, hidden: Span | None, partner: str | None = None
) -> Surroundings:
    """Cut out a marker and its steadiest neighbours; what is hidden is not learnt from.

    The partner of a swap is no witness, since it is where the marker should be.
    """
    take = opened.take
    own = take.positions[frames.frames, marker]
    # Mates on the same part of the body, and others only where these are too few for a frame.
    mates, others = opened.mesh.siblings(marker), opened.mesh.neighbours(marker)
    known = [m for m in dict.fromkeys((*mates, *others)) if take.labels[m] != partner]
    n_mates = sum(m in set(mates) for m in known)
    near = known[: min(NEIGHBOURS, max(take.n_dims, n_mates))]
    neighbours = take.positions[frames.frames][:, near]
    trusted = np.ones(len(own), bool)
    if hidden is not None:
        trusted[max(0, hidden.start - frames.start) : max(0, hidden.stop - frames.start)] = False
    expected = (
        curves.expected(own, neighbours, trusted, _weights(opened, marker, near))
        if near
        else np.full(own.shape, np.nan)
    )  # fmt: skip
    return Surroundings(frames.start, own, neighbours, trusted, expected)


def _weights(opened: Opened, marker: int, near: list[int]) -> FloatArray:
    """Let a neighbour count by how little its distance varies, in mm."""
    spread = opened.mesh.spread[marker, near]
    return np.asarray(1.0 / np.square(1.0 + np.where(np.isfinite(spread), spread, 1e3)))


def signal_of(
    opened: Opened,
    name: str,
    finding: Finding | None,
    around: Surroundings,
    *,
    repaired: bool = False,
) -> EvidenceCurve | None:
    """Give one signal of a marker with its levels.

    Parameters
    ----------
    opened
        The take.
    name
        ``residual``, ``speed``, ``acceleration`` or ``distance``.
    finding
        The finding at hand: its own evidence is the residual where it has any.
    around
        The marker, as recorded or as repaired.
    repaired
        Whether the marker is as repaired: then the finding's own evidence does not stand for it.
    """
    take = opened.take
    unit = take.units
    time = (np.arange(len(around.own)) + around.start) / take.rate
    if name == "residual":
        found = None if finding is None else finding.evidence
        if found is not None:
            if not repaired:
                stretch = (np.arange(len(found.signal)) + found.start) / take.rate
                signal = np.abs(found.signal)
                return EvidenceCurve(
                    _sentence(found.name), found.unit, stretch, signal, found.threshold, found.usual
                )
            if found.prediction is None or found.unit not in ("mm", "px"):
                return None
            frames = np.arange(len(around.own)) + around.start - found.start
            known = (frames >= 0) & (frames < len(found.prediction))
            off = np.linalg.norm(around.own[known] - found.prediction[frames[known]], axis=1)
            return EvidenceCurve("", unit, time[known], off)
        signal = np.linalg.norm(around.own - around.expected, axis=1)
    elif name == "speed":
        signal, unit = curves.speed(around.own, take.rate), f"{unit}/s"
    elif name == "acceleration":
        signal = curves.acceleration(around.own, take.rate)
        unit = "m/s²" if unit == "mm" else "kpx/s²"
    else:
        signal = curves.distance_change(around.own, around.neighbours, around.trusted)
    title = TITLES[name]
    if name == "distance" and finding is not None and finding.partner:
        title = f"{title}; exchanged with {short(finding.partner)}"
    outside = signal[around.trusted & np.isfinite(signal)]
    usual = float(np.median(outside)) if outside.size else np.nan
    return EvidenceCurve(title, unit, time, signal, usual=usual)


def _sentence(name: str) -> str:
    return name[:1].upper() + name[1:]
