"""From candidates in windows to findings of a take, with the evidence that an operator sees."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from markermend.detection.likelihood import templates
from markermend.detection.likelihood.calibration import probability
from markermend.detection.likelihood.sharp import Candidate
from markermend.detection.likelihood.swaps import LEAST_MM, Swap
from markermend.detection.likelihood.window import SHORTEST, Scan, Settings, scan_window
from markermend.detection.progress import Progress, unheard
from markermend.model import AXES, Evidence, Finding, FloatArray, Span, Take

_WINDOW = 2700  # frames: longer takes go in pieces, so time and memory stay linear
_OVERLAP = 180  # the same at 100 Hz, or more at higher rates: slow changes last longer there
_CONTEXT = 60  # frames of evidence on each side
_AXIS_SHARE = 0.2  # of the amplitude, from which an axis is named
_SLOW_AXIS_SHARE = 0.4  # for slow changes, whose other axes drift along with the prediction
_AXIS_NOISE = 4.0  # and times the axis's own noise


@dataclass(frozen=True, eq=False)
class Piece:
    """One window of a take, scanned.

    Attributes
    ----------
    start
        Its first frame.
    low, high
        Frames in which the middle of a finding has to lie for this window to own it.
    labels
        Names of the markers on the axes of `points` and `scan`.
    points
        (n, n_markers, 3) mm as recorded; a third axis of zeros in two dimensions.
    scan
        What was found.
    """

    start: int
    low: float
    high: float
    labels: tuple[str, ...]
    points: FloatArray
    scan: Scan


def scanned(take: Take, settings: Settings, progress: Progress = unheard) -> Iterator[Piece]:
    """Scan the take window by window; one is held at a time, and `progress` hears of each."""
    windows = _windows(take.n_frames, settings.pace)
    for done, (start, stop, low, high) in enumerate(windows):
        progress(done, len(windows))
        part = take.positions[start:stop, take.measured]
        shown = np.flatnonzero(np.isfinite(part[:, :, 0]).sum(0) >= SHORTEST)
        if stop - start < SHORTEST or not len(shown):
            continue
        points = np.zeros((stop - start, len(shown), 3))
        points[:, :, : take.n_dims] = part[:, shown]
        points[np.isnan(points[:, :, 0])] = np.nan
        labels = tuple(take.labels[take.measured[i]] for i in shown)
        yield Piece(start, low, high, labels, points, scan_window(points, settings))
    progress(len(windows), len(windows))


def detect_all(take: Take, settings: Settings, progress: Progress = unheard) -> tuple[Finding, ...]:
    """Scan the take in overlapping windows; each finding counts in the window that owns it."""
    findings: list[Finding] = []
    for piece in scanned(take, settings, progress):
        made = [_finding(c, piece, take) for c in piece.scan.candidates]
        for swap in piece.scan.swaps:
            made += _swapped(swap, piece, take)
        findings += [f for f in made if piece.low <= _middle(f.span) < piece.high]
    return _grouped(findings)


def _middle(span: Span) -> float:
    return (span.start + span.stop) / 2


def _windows(n_frames: int, pace: float) -> list[tuple[int, int, float, float]]:
    """Windows and the part of each in which the middle of a finding has to lie."""
    overlap = round(_OVERLAP * max(1.0, pace))
    longest = max(_WINDOW, 10 * overlap)
    if n_frames <= longest + overlap:
        return [(0, n_frames, -np.inf, np.inf)]
    count = -(-(n_frames - overlap) // (longest - overlap))
    length = -(-(n_frames + (count - 1) * overlap) // count)
    starts = np.linspace(0, n_frames - length, count).astype(int)
    cuts = [-np.inf, *((starts[1:] + starts[:-1] + length) / 2), np.inf]
    return [(int(s), int(s) + length, cuts[i], cuts[i + 1]) for i, s in enumerate(starts)]


def _finding(c: Candidate, piece: Piece, take: Take) -> Finding:
    scan, points, offset = piece.scan, piece.points, piece.start
    deviation = scan.final[c.marker] if c.kind == "slow" else scan.residual[c.marker]
    n = len(deviation)
    low, high = max(0, c.start - _CONTEXT), min(n, c.stop + _CONTEXT)
    outside = np.r_[low : c.start, c.stop : high]
    base = np.median(deviation[outside], axis=0) if len(outside) else np.zeros(3)
    rest = deviation - base
    inside = rest[c.start : c.stop]
    shape = _shape(c)
    if c.kind == "noise":
        sizes = np.sqrt(np.mean(inside**2, axis=0))
        amplitude = float(np.sqrt((sizes**2).sum()))
        signal = np.sqrt((rest**2).sum(1))
        template = None
    else:
        sizes = (shape[:, None] * inside).sum(0) / (shape**2).sum()
        amplitude = float(np.sqrt((sizes**2).sum()))
        signal = rest @ (sizes / max(amplitude, 1e-9))
        template = np.zeros(high - low)
        template[c.start - low : c.stop - low] = amplitude * shape
    noise = _spread(rest[outside]) / (1.0 if c.kind == "noise" else np.sqrt((shape**2).sum()))
    share = _SLOW_AXIS_SHARE if c.kind == "slow" else _AXIS_SHARE
    least = np.maximum(share * amplitude, _AXIS_NOISE * noise)
    axes = tuple(
        AXES[i]
        for i in range(take.n_dims)
        if abs(sizes[i]) >= min(least[i], np.abs(sizes[: take.n_dims]).max())
    )
    evidence = Evidence(
        name="deviation from where the neighbours put the marker",
        start=offset + low,
        signal=signal[low:high],
        threshold=amplitude / c.strength,
        usual=float(np.median(np.abs(signal[outside]))) if len(outside) else 0.0,
        unit=take.units,
        prediction=(points[low:high, c.marker] - deviation[low:high])[:, : take.n_dims],
        template=template,
    )
    return Finding(
        marker=piece.labels[c.marker],
        span=Span(offset + c.start, offset + c.stop),
        kind=c.kind,
        score=probability(c.kind, c.strength),
        axes=axes,
        amplitude=amplitude,
        detector="likelihood",
        strength=c.strength,
        evidence=evidence,
    )


def _spread(deviation: FloatArray) -> FloatArray:
    """Give the robust standard deviation of each axis; zeros where there is nothing around."""
    if not len(deviation):
        return np.zeros(deviation.shape[1])
    return np.asarray(1.4826 * np.median(np.abs(deviation), axis=0))


def _shape(c: Candidate) -> FloatArray:
    length = c.stop - c.start
    return templates.triangle_template(length)[:length] if c.kind == "slow" else np.ones(length)


def _swapped(swap: Swap, piece: Piece, take: Take) -> list[Finding]:
    """Give a step on each of two exchanged markers, with the other as partner."""
    findings = []
    points, offset = piece.points, piece.start
    low, high = max(0, swap.start - _CONTEXT), min(len(points), swap.stop + _CONTEXT)
    inside = np.zeros(high - low, bool)
    inside[swap.start - low : swap.stop - low] = True
    for marker, other in ((swap.first, swap.second), (swap.second, swap.first)):
        expected = piece.scan.predicted[low:high, marker]
        away = np.nan_to_num(points[low:high, marker] - expected)
        signal = np.sqrt((away**2).sum(1))
        amplitude = float(np.median(signal[inside]))
        sizes = np.abs(np.median(away[inside], axis=0))
        axes = [AXES[i] for i in range(take.n_dims) if sizes[i] >= _AXIS_SHARE * sizes.max()]
        partner = piece.labels[other]
        evidence = Evidence(
            name=f"distance from where the neighbours put it, once exchanged with {partner}",
            start=offset + low,
            signal=signal,
            threshold=LEAST_MM,
            usual=float(np.median(signal[~inside])) if not inside.all() else 0.0,
            unit=take.units,
            prediction=expected[:, : take.n_dims],
            template=np.where(inside, amplitude, 0.0),
        )
        findings.append(
            Finding(
                marker=piece.labels[marker],
                span=Span(offset + swap.start, offset + swap.stop),
                kind="step",
                score=probability("swap", swap.strength),
                axes=tuple(axes),
                amplitude=amplitude,
                detector="likelihood",
                strength=swap.strength,
                partner=partner,
                evidence=evidence,
            )
        )
    return findings


def _grouped(findings: list[Finding]) -> tuple[Finding, ...]:
    """A peak on a slow change shares its group with it (Skurowski & Pawlyta, Fig. 14)."""
    slow = [f for f in findings if f.kind == "slow"]
    groups: dict[str, str] = {}
    for peak in findings:
        if peak.kind != "peak":
            continue
        for change in slow:
            if change.marker == peak.marker and change.span.overlaps(peak.span):
                groups[peak.id] = groups[change.id] = change.id
    return tuple(replace(f, group=groups[f.id]) if f.id in groups else f for f in findings)
