"""Skin does not stay on the bone, and cameras do not measure exactly.

A marker leaves its place on the bone by some mm: with the angles of the joints beside it (skin is
drawn along), and by wobbling when the segment is accelerated. Both follow the movement; compare
Leardini, Chiari, Della Croce and Cappozzo, *Gait Posture* 21 (2005) 212-225, whose figures reach
higher on the thigh than is allowed here.
"""

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

from markermend.model import FloatArray
from markermend.simulate.body import PARENT
from markermend.simulate.curves import wander
from markermend.simulate.markers import Marker
from markermend.simulate.posture import Frames, Movement

DRAWN = 1.3
"""Standard deviation, per axis, of how far skin is drawn by a joint that turns by one radian."""
CREEP = 0.25
"""Standard deviation of slow changes without a cause, in mm."""
MOST = 2.4
"""No axis leaves its place by more than this, in mm."""
WOBBLE_HZ, WOBBLE_DAMPING, WOBBLE_SHARE = 9.0, 0.35, 0.25
NOISE_RANGE = (0.1, 0.3)
"""Standard deviation of the measurement noise of the best and the worst seen marker, in mm."""
NOISE_MEMORY = 0.35
"""Correlation of the noise of one frame with that of the one before."""

_STIFF = {"head": 0.3, "pelvis": 0.9, "Lhand": 0.5, "Rhand": 0.5, "Lfoot": 0.45, "Rfoot": 0.45}


def skin_motion(
    movement: Movement, markers: tuple[Marker, ...], rng: np.random.Generator
) -> FloatArray:
    """Displacement of every marker in its segment's frame, (n, n_markers, 3) in mm."""
    segments = movement.segments
    n_frames = len(movement.belt)
    creep = wander(rng, n_frames, 3 * len(markers), 1.2, movement.rate)
    moved = np.empty((n_frames, len(markers), 3))
    wobbles = {name: _wobble(frames, movement.rate) for name, frames in segments.items()}
    for k, marker in enumerate(markers):
        softness = _STIFF.get(marker.segment, 1.0)
        angles = _joint_angles(segments, marker.segment)
        weights = rng.normal(0.0, DRAWN, (angles.shape[1], 3))
        bends = rng.normal(0.0, 0.5 * DRAWN, (angles.shape[1], 3))
        drawn = angles @ weights + angles**2 @ bends
        drawn -= np.median(drawn, axis=0)
        free = drawn + CREEP * creep[:, 3 * k : 3 * k + 3] + wobbles[marker.segment]
        moved[:, k] = softness * MOST * np.tanh(free / MOST)
    return moved


def _joint_angles(segments: dict[str, Frames], name: str) -> FloatArray:
    """Rotation vectors, (n, 3 k), of the joints at both ends of a segment."""
    near = [(PARENT[name], name)] if name in PARENT else []
    near += [(name, child) for child, parent in PARENT.items() if parent == name]
    turns = []
    for parent, child in near:
        between = np.swapaxes(segments[parent].rotation, 1, 2) @ segments[child].rotation
        turns.append(Rotation.from_matrix(between).as_rotvec())
    return np.concatenate(turns, axis=1)


def _wobble(frames: Frames, rate: float) -> FloatArray:
    """A damped mass on a spring, driven by the acceleration of the segment, in its frame."""
    middle = frames.point(np.array([0.0, 0.0, -150.0]))
    # Without the curvature of single frames, which no soft tissue would answer.
    calm = gaussian_filter1d(middle, 0.01 * rate, axis=0, mode="nearest")
    pulled = np.gradient(np.gradient(calm, axis=0), axis=0) * rate**2
    local = np.einsum("nji,nj->ni", frames.rotation, pulled)
    step, own = 1.0 / rate, 2.0 * np.pi * WOBBLE_HZ
    # Backward differences of x'' + 2 d w x' + w^2 x = -a: stable at any rate.
    damping = 2.0 * WOBBLE_DAMPING * own * step
    denominator = np.array([1.0 + damping + (own * step) ** 2, -2.0 - damping, 1.0])
    wobbling = lfilter([-(step**2) * WOBBLE_SHARE], denominator, local, axis=0)
    return np.asarray(wobbling, np.float64)


def measurement_noise(n_frames: int, n_markers: int, rng: np.random.Generator) -> FloatArray:
    """Error of the measurement, (n, n_markers, 3) in mm; each marker with a level of its own."""
    white = rng.standard_normal((n_frames, n_markers, 3))
    coloured = lfilter([np.sqrt(1.0 - NOISE_MEMORY**2)], [1.0, -NOISE_MEMORY], white, axis=0)
    level: FloatArray = rng.uniform(*NOISE_RANGE, (n_markers, 1))
    return np.asarray(coloured * level, np.float64)
