"""From the strength of a finding to the probability that it is real."""

import math

# Logistic curves p = 1 / (1 + exp(-(a + b log strength))); tests/bench/calibrate_likelihood.py
# fits them.
CURVES = {
    "peak": (1.30, 7.95),
    "noise": (-1.31, 6.43),
    "step": (-1.61, 7.08),
    "slow": (-1.72, 5.12),
    "swap": (3.0, 2.0),
}


def probability(kind: str, strength: float) -> float:
    """Give the share of findings of this kind and strength that were real artefacts."""
    a, b = CURVES[kind]
    return 1.0 / (1.0 + math.exp(-(a + b * math.log(max(strength, 1e-6)))))
