"""A body of two segments whose markers all wobble a little on their own."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from markermend.model import FloatArray, Take

RATE = 100.0
LABELS = tuple(f"{segment}{i}" for segment in ("TRUNK", "THIGH") for i in range(6))


def body(n_frames: int, seed: int = 3, noise: float = 0.05) -> FloatArray:
    """(n_frames, 12, 3) mm: a walk with skin that moves with the joint angle."""
    rng = np.random.default_rng(seed)
    trunk_shape = rng.uniform(-120, 120, (6, 3))
    thigh_shape = rng.uniform(-80, 80, (6, 3)) - np.array([0, 0, 350])
    pull = rng.normal(0, 12, (6, 3))
    time = np.arange(n_frames) / RATE
    phase = 2 * np.pi * 0.9 * time + 0.4 * np.sin(0.7 * time)
    angle = (0.6 + 0.15 * np.sin(0.31 * time)) * np.sin(phase + 0.5)
    sway = 0.15 * np.column_stack([np.sin(phase), 0.6 * np.cos(phase), np.sin(phase / 4)])
    swing = np.column_stack([angle, 0 * time, 0.1 * np.sin(2 * phase)])
    way = np.column_stack([900 * np.sin(0.2 * time), 40 * np.sin(phase), 950 + 20 * np.cos(phase)])
    trunk = Rotation.from_rotvec(sway).as_matrix()
    thigh = trunk @ Rotation.from_rotvec(swing).as_matrix()
    upper = np.einsum("tij,mj->tmi", trunk, trunk_shape)
    lower = np.einsum("tij,tmj->tmi", thigh, thigh_shape + angle[:, None, None] * pull)
    every = way[:, None] + np.concatenate([upper, lower], axis=1)
    return np.asarray(every + rng.normal(0, noise, every.shape))


@pytest.fixture(scope="session")
def walk() -> Take:
    """1,200 frames without a gap."""
    return Take(body(1200), RATE, LABELS)
