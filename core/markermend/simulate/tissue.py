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
from markermend.simulate.frames import Frames, Movement
from markermend.simulate.markers import Marker

MOST = 1.7
"""A marker leaves its place by less than this, in mm, so that markers of one segment keep their
distances within 5 mm."""
DRAWN = 3.4
"""How hard skin is drawn by the joints, relative to `MOST`."""
FOLDS = 2.2
"""How quickly the drawing changes its direction while a joint turns, per radian."""
HYSTERESIS = 3.0
"""How far its phase wanders, per radian that the joints turn."""
CREEP = 0.3
"""Slow changes without a cause, relative to `MOST`."""
WOBBLE_HZ, WOBBLE_DAMPING, WOBBLE_SHARE = 9.0, 0.35, 0.25
NOISE_RANGE = (0.1, 0.3)
"""Standard deviation of the measurement noise of the best and the worst seen marker, in mm."""
NOISE_MEMORY = 0.35
"""Correlation of the noise of one frame with that of the one before."""

BREATH_HZ = 0.27
_BREATHES = {"STRN": (1.6, 0.0, 0.5), "CLAV": (1.0, 0.0, 1.0), "RBAK": (-0.5, 0.0, 0.3)}

_STIFF = {"head": 0.5}
"""Skin on the skull moves less."""


def skin_motion(
    movement: Movement, markers: tuple[Marker, ...], rng: np.random.Generator
) -> FloatArray:
    """Displacement of every marker in its segment's frame, (n, n_markers, 3) in mm."""
    segments = movement.segments
    n_frames = len(movement.belt)
    creep = wander(rng, n_frames, 3 * len(markers), 1.2, movement.rate)
    moved = np.empty((n_frames, len(markers), 3))
    wobbles = {name: _wobble(frames, movement.rate) for name, frames in segments.items()}
    angles = {name: _joint_angles(segments, name) for name in segments}
    breath = _breath(n_frames, movement.rate, rng)
    for k, marker in enumerate(markers):
        drawn = DRAWN * _drawn(angles[marker.segment], movement.rate, rng)
        free = drawn + CREEP * creep[:, 3 * k : 3 * k + 3] + wobbles[marker.segment] / MOST
        free += breath[:, None] * np.array(_BREATHES.get(marker.label, (0.0, 0.0, 0.0))) / MOST
        free *= _STIFF.get(marker.segment, 1.0)
        moved[:, k] = MOST * free / np.sqrt(1.0 + np.sum(free**2, axis=1, keepdims=True))
    return moved


def _drawn(angles: FloatArray, rate: float, rng: np.random.Generator) -> FloatArray:
    """A smooth function, (n, 3), of the joints' angles and of the way they have come.

    Skin does not come back to quite the same place: while a joint turns, and only then, the phases
    wander. So no straight line through other markers describes it.
    """
    n_frames, n_angles = angles.shape
    weights = rng.normal(0.0, FOLDS, (n_angles, 3, 2))
    turning = np.linalg.norm(np.gradient(angles, axis=0), axis=1)
    drift = np.cumsum(turning[:, None] * wander(rng, n_frames, 6, 0.3, rate), axis=0)
    phases = rng.uniform(0.0, 2.0 * np.pi, (3, 2)) + HYSTERESIS * drift.reshape(n_frames, 3, 2)
    waves: FloatArray = np.sin(np.tensordot(angles, weights, 1) + phases).sum(axis=2)
    return waves - np.median(waves, axis=0)


def _breath(n_frames: int, rate: float, rng: np.random.Generator) -> FloatArray:
    """Breathing, -1 to 1, with a pace that varies."""
    pace = BREATH_HZ * (1.0 + 0.15 * wander(rng, n_frames, 1, 3.0, rate)[:, 0])
    breath: FloatArray = np.sin(2.0 * np.pi * np.cumsum(pace) / rate + rng.uniform(0.0, 6.0))
    return breath


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
