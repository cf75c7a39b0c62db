"""From the strength of a finding to the probability that it is real."""

import math

# Logistic curves p = 1 / (1 + exp(-(a + b log strength))), fitted by tests/bench/calibrate_likelihood.py.
CURVES = {
    "peak": (0.96, 7.99),
    "noise": (-1.15, 6.18),
    "step": (-0.23, 3.89),
    "slow": (-1.20, 2.56),
    "swap": (3.0, 2.0),
}


def probability(kind: str, strength: float) -> float:
    """Give the share of findings of this kind and strength that were real artefacts."""
    a, b = CURVES[kind]
    return 1.0 / (1.0 + math.exp(-(a + b * math.log(max(strength, 1e-6)))))
