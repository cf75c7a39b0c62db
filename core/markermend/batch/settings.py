"""How a batch looks at takes; two runs with equal settings share their results."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from markermend import __version__, detection
from markermend.batch.policy import Policy
from markermend.detection import DETECTORS
from markermend.model import KINDS, Kind


@dataclass(frozen=True)
class Settings:
    """What is asked of every take.

    Attributes
    ----------
    detector
        Name of the detector.
    kinds
        The kinds that are looked for.
    parameters, sensitivity
        What of the detector is set otherwise than by default, and factors by kind as in
        `markermend.detection.detect`.
    units, rate, ignore_residuals
        As in `markermend.read`: what files lack.
    policy
        What is repaired, or None.
    """

    detector: str = detection.DEFAULT
    kinds: tuple[Kind, ...] = KINDS
    units: str | None = None
    rate: float | None = None
    ignore_residuals: bool = False
    policy: Policy | None = None
    parameters: Mapping[str, Any] = field(default_factory=dict)
    sensitivity: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        DETECTORS.get(self.detector)  # an unknown name is said before any take is read

    def to_json(self) -> dict[str, Any]:
        """Give them, with the version of the program, as they are kept."""
        more = {"parameters": dict(self.parameters), "sensitivity": dict(self.sensitivity)}
        return {
            "program": __version__,
            "detector": self.detector,
            "kinds": list(self.kinds),
            "units": self.units,
            "rate": self.rate,
            "ignore_residuals": self.ignore_residuals,
            "policy": None if self.policy is None else self.policy.to_json(),
            **{name: said for name, said in more.items() if said},
        }

    @property
    def key(self) -> str:
        """Hash of everything that a result depends on besides the take."""
        text = json.dumps(self.to_json(), sort_keys=True, separators=(",", ":"))
        return hashlib.sha256(text.encode()).hexdigest()
