"""Takes whose truth is known, and the problems that every method is put to."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from markermend.model import FloatArray, Kind, Span, Take
from markermend.registry import Method
from markermend.repairing.run import repair

RATE = 100.0
N_FRAMES = 240
LABELS = ("HIP_A", "HIP_B", "HIP_C", "HIP_D", "KNEE_A", "KNEE_B", "KNEE_C", "KNEE_D")
MARKER, PARTNER = "KNEE_B", "KNEE_C"
SPAN = Span(110, 130)


def walker(n_frames: int = N_FRAMES, seed: int = 1, noise: float = 0.1) -> FloatArray:
    """Two segments of four markers, the second swinging at the end of the first; mm."""
    shape = np.random.default_rng(1)
    first = shape.uniform(-120, 120, (4, 3))
    second = shape.uniform(-80, 80, (4, 3)) - np.array([0, 0, 350])
    rng = np.random.default_rng(seed)
    phase = 2 * np.pi * 0.9 * np.arange(n_frames) / RATE + rng.uniform(0, 6)
    still = np.zeros(n_frames)
    sway = np.column_stack([np.sin(phase), 0.6 * np.cos(phase), 2 * np.sin(phase / 4)]) * 0.15
    swing = np.column_stack([0.6 * np.sin(phase + 0.5), still, 0.1 * np.sin(2 * phase)])
    way = np.column_stack(
        [9.0 * np.arange(n_frames), 40 * np.sin(phase), 950 + 20 * np.sin(2 * phase)]
    )
    trunk = Rotation.from_rotvec(sway).as_matrix()
    thigh = trunk @ Rotation.from_rotvec(swing).as_matrix()
    markers = [way + trunk @ p for p in first] + [way + thigh @ p for p in second]
    body = np.stack(markers, axis=1)
    return np.asarray(body + rng.normal(0, noise, body.shape))


@dataclass(frozen=True, eq=False)
class Case:
    """What is recorded, what is wrong with it, and what would be right."""

    take: Take
    truth: FloatArray
    kind: Kind = "gap"
    marker: str = MARKER
    span: Span = SPAN
    partner: str | None = None
    training: tuple[Take, ...] = ()

    def solve(self, method: str, **parameters: Any) -> FloatArray:
        """Give the values that a method puts in the span."""
        return repair(
            self.take,
            self.marker,
            self.span,
            method,
            kind=self.kind,
            partner=self.partner,
            training=self.training,
            **parameters,
        ).values

    def moved(self, change: Any) -> "Case":
        """Apply a change of coordinates to all that is recorded."""
        training = tuple(t.with_positions(change(t.positions)) for t in self.training)
        positions = change(self.take.positions)
        return replace(
            self, take=self.take.with_positions(positions), truth=change(self.truth),
            training=training,
        )  # fmt: skip


def case(
    kind: Kind = "gap",
    truth: FloatArray | None = None,
    span: Span = SPAN,
    swapped: bool = False,
    n_dims: int = 3,
) -> Case:
    """Spoil a truth by an artefact of a kind; a gap has its fragment among the ``*n``."""
    truth = walker() if truth is None else truth
    truth = truth[..., :n_dims]
    marker, partner = LABELS.index(MARKER), LABELS.index(PARTNER)
    spoilt = truth.copy()
    inside, size = spoilt[span.frames, marker], (len(span), n_dims)
    labels, fragment = LABELS, np.full((len(truth), 1, n_dims), np.nan)
    if swapped:
        spoilt[span.frames, [marker, partner]] = truth[span.frames, [partner, marker]]
    elif kind == "gap":
        labels = (*LABELS, "*1")
        fragment[span.frames, 0] = inside
        inside[:] = np.nan
        spoilt = np.concatenate([spoilt, fragment], axis=1)
    elif kind == "step":
        inside += 25.0
    elif kind == "slow":
        ramp = np.minimum(np.arange(1, len(span) + 1), np.arange(len(span), 0, -1))
        inside += 30.0 * (ramp / ramp.max())[:, None]
    else:
        inside += np.random.default_rng(5).normal(0, 15, size)
    units = "mm" if n_dims == 3 else "px"
    training = tuple(Take(walker(seed=s)[..., :n_dims], RATE, LABELS, units=units) for s in (2, 3))
    return Case(
        Take(spoilt, RATE, labels, units=units),
        truth[span.frames, marker],
        kind,
        span=span,
        partner=PARTNER if swapped else None,
        training=training,
    )


class Lab:
    """The builders above, for tests that cannot import them."""

    Case, LABELS, MARKER, PARTNER, RATE, SPAN = Case, LABELS, MARKER, PARTNER, RATE, SPAN
    walker, case = staticmethod(walker), staticmethod(case)

    @staticmethod
    def for_method(method: Method, **options: Any) -> Case:
        """Pose the sort of problem that a method is meant for."""
        kind = "gap" if "gap" in method.kinds else method.kinds[0]
        return case(kind, swapped=method.name == "swap", **options)


@pytest.fixture(scope="session")
def lab() -> type[Lab]:
    return Lab
