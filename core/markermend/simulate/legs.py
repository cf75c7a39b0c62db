"""Legs by inverse kinematics: hip and ankle are given, the knee follows."""

from dataclasses import dataclass

import numpy as np

from markermend.model import FloatArray

MOST_STRETCHED = np.radians(2.0)
"""The knee is never straighter than this."""


def reach(thigh: float, shank: float, flexion: FloatArray | float) -> FloatArray:
    """Distance of hip and ankle at some flexion of the knee, in radians."""
    squared = thigh**2 + shank**2 + 2.0 * thigh * shank * np.cos(flexion)
    distance: FloatArray = np.sqrt(squared)
    return distance


@dataclass(frozen=True, eq=False)
class Leg:
    """One leg: the knee, (n, 3), and the frames of thigh and shank, (n, 3, 3)."""

    knee: FloatArray
    thigh: FloatArray
    shank: FloatArray


def solve_leg(
    hip: FloatArray, ankle: FloatArray, forward: FloatArray, thigh: float, shank: float
) -> Leg:
    """Find the knee between hip and ankle, bent towards `forward`.

    Parameters
    ----------
    hip, ankle
        (n, 3) mm, nearer to one another than both segments are long.
    forward
        (n, 3): where the knee points to; need not be perpendicular to the leg.
    thigh, shank
        Lengths in mm.
    """
    line = hip - ankle
    distance = np.linalg.norm(line, axis=1, keepdims=True)
    up = line / distance
    ahead = _unit(forward - np.sum(forward * up, axis=1, keepdims=True) * up)
    along = (thigh**2 - shank**2 + distance**2) / (2.0 * distance)
    out = np.sqrt(thigh**2 - along**2)
    knee = hip - along * up + out * ahead
    left = np.cross(up, ahead)
    return Leg(knee, _frame(hip - knee, left), _frame(knee - ankle, left))


def _frame(up: FloatArray, left: FloatArray) -> FloatArray:
    up = _unit(up)
    return np.stack([np.cross(left, up), left, up], axis=2)


def _unit(vectors: FloatArray) -> FloatArray:
    unit: FloatArray = vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
    return unit
