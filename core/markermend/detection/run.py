"""Run detectors on takes."""

import inspect
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from markermend.detection.progress import Progress, unheard
from markermend.errors import UnknownName
from markermend.model import KINDS, Finding, Kind, Take
from markermend.params import checked
from markermend.registry import Registry

DETECTORS = Registry("detector", "markermend.detection.methods", "markermend.detectors")
DEFAULT = "likelihood"


def detect(
    take: Take,
    detector: str = DEFAULT,
    *,
    kinds: Iterable[str] | None = None,
    sensitivity: Mapping[str, float] | float = 1.0,
    progress: Progress = unheard,
    **parameters: Any,
) -> tuple[Finding, ...]:
    """Find what an operator should look at, in the order of markers and time.

    Parameters
    ----------
    take
        The take; only its measured markers are looked at.
    detector
        Name of a registered detector.
    kinds
        The kinds wanted; by default all five.
    sensitivity
        1 as designed; 2 keeps findings at half the threshold. One number, or one per kind.
    progress
        Called with how much is done, and of how much, by detectors that can tell.
    **parameters
        Parameters of the detector.

    Raises
    ------
    UnknownName, BadParameter
        If detector, kind or a parameter is unknown or out of bounds.
    """
    wanted = _kinds(kinds)
    per_kind = (
        sensitivity if isinstance(sensitivity, Mapping) else dict.fromkeys(KINDS, sensitivity)
    )
    return tuple(
        finding
        for finding in scan(take, detector, kinds=wanted, progress=progress, **parameters)
        if finding.strength * per_kind.get(finding.kind, 1.0) >= 1.0
    )


def scan(
    take: Take,
    detector: str = DEFAULT,
    *,
    kinds: Iterable[str] | None = None,
    progress: Progress = unheard,
    **parameters: Any,
) -> tuple[Finding, ...]:
    """Find all candidates, also those below their thresholds (``strength`` < 1).

    Re-thresholding is a filter on ``strength`` and computes nothing again.
    """
    wanted = _kinds(kinds)
    method = DETECTORS.get(detector)
    checked(method.function, parameters)
    heard = (progress,) if "progress" in inspect.signature(method.function).parameters else ()
    found: Sequence[Finding] = method(take, *heard, **parameters) if set(wanted) - {"gap"} else ()
    order = {label: i for i, label in enumerate(take.labels)}
    return tuple(
        sorted(
            (f for f in (*gaps(take), *found) if f.kind in wanted),
            key=lambda f: (order[f.marker], f.span, f.kind),
        )
    )


def gaps(take: Take) -> tuple[Finding, ...]:
    """Find every span in which a measured marker is not seen, unless it never is."""
    return tuple(
        Finding(take.labels[m], span, "gap", detector="gaps")
        for m in take.measured
        for span, _ in take.gaps(int(m))
        if len(span) < take.n_frames
    )


def overlapping(findings: Iterable[Finding]) -> list[list[Finding]]:
    """Group findings of one marker whose spans overlap: two repairs cannot write one sample."""
    groups: list[list[Finding]] = []
    for finding in sorted(findings, key=lambda f: (f.marker, f.span)):
        last = groups[-1] if groups else []
        reach = max((other.span.stop for other in last), default=0)
        if last and last[0].marker == finding.marker and reach > finding.span.start:
            last.append(finding)
        else:
            groups.append([finding])
    return groups


def _kinds(kinds: Iterable[str] | None) -> tuple[Kind, ...]:
    if kinds is None:
        return KINDS
    wanted = tuple(kinds)
    for kind in wanted:
        if kind not in KINDS:
            raise UnknownName.among("kind", kind, KINDS)
    return tuple(kind for kind in KINDS if kind in wanted)
