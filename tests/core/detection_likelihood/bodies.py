"""Small moving bodies for tests: two jointed boxes with markers on them."""

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.spatial.transform import Rotation

from markermend.model import Take


def body(n_frames: int = 600, per_part: int = 7, seed: int = 0, noise_mm: float = 0.1) -> Take:
    """Two rigid parts that turn about a joint while the whole walks about; skin moves by 0.3 mm."""
    rng = np.random.default_rng(seed)

    def smooth(width: float, size: float) -> np.ndarray:
        raw = gaussian_filter1d(rng.standard_normal((n_frames + 400, 3)), width, axis=0)[200:-200]
        return size * raw / raw.std()

    turns = [Rotation.from_rotvec(smooth(45, 0.35)) for _ in range(2)]
    path = smooth(80, 250.0)
    parts = []
    for turn, centre in zip(turns, ((0, 0, 0), (0, 0, 300)), strict=True):
        shape = rng.uniform(-110, 110, (per_part, 3)) + centre
        skin = np.stack([smooth(20, 0.3) for _ in range(per_part)], axis=1)
        parts.append(np.einsum("tij,tkj->tki", turn.as_matrix(), shape + skin))
    positions = np.concatenate(parts, axis=1) + path[:, None]
    positions += rng.normal(0, noise_mm, positions.shape)
    return Take(positions, 100.0, [f"m{i}" for i in range(positions.shape[1])])
