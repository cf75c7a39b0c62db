"""The record of a detection, as ``markermend detect --json`` prints it."""

from collections.abc import Iterable
from typing import Any

from markermend.model import Finding, Take

FIELDS = ("id", "marker", "start", "stop", "kind", "score", "axes", "amplitude")
"""What stands of each finding in the JSON; other programs rely on it."""
WHERE_KNOWN = ("partner", "group")
"""What stands there too where it is known: the other marker of a swap, findings that combine."""


def detection_record(take: Take, name: str, findings: Iterable[Finding]) -> dict[str, Any]:
    """Give what was found in a take, ready for JSON.

    Parameters
    ----------
    take, findings
        The take and what was found in it.
    name
        Of the file, without its folder.
    """
    return {
        "version": 1,
        "take": name,
        "rate": take.rate,
        "n_frames": take.n_frames,
        "findings": [_finding(finding) for finding in findings],
        "warnings": list(take.warnings),
    }


def _finding(finding: Finding) -> dict[str, Any]:
    whole = finding.to_json()
    return {name: whole[name] for name in (*FIELDS, *WHERE_KNOWN) if name in whole}
