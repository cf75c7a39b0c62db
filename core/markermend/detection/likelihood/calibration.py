"""From the strength of a finding to the probability that it is real."""

import math

# Logistic curves p = 1 / (1 + exp(-(a + b log strength))), fitted by tests/bench/calibrate.py.
CURVES = {
    "peak": (2.0, 4.0),
    "noise": (2.0, 2.0),
    "step": (2.0, 4.0),
    "slow": (0.5, 4.0),
    "swap": (3.0, 2.0),
}


def probability(kind: str, strength: float) -> float:
    """Give the share of findings of this kind and strength that were real artefacts."""
    a, b = CURVES[kind]
    return 1.0 / (1.0 + math.exp(-(a + b * math.log(max(strength, 1e-6)))))
