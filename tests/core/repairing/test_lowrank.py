"""Solvers of low rank: the constraint is met, the objective falls to its limit, exact where due."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from markermend.model import Span, Take
from markermend.repairing.lowrank import (
    by_sparse_low_rank,
    by_truncated_norm,
    frequency_penalty,
    nuclear_norm,
    shrink,
)
from markermend.repairing.run import repair
from markermend.simulate import simulate

RATE = 100.0


def treadmill(n_frames=300, n_columns=24, n_cycles=5, seed=0):
    """Trajectories of three harmonics of one step frequency, in mm: periodic and of low rank."""
    rng = np.random.default_rng(seed)
    phase = 2 * np.pi * n_cycles * np.arange(n_frames) / n_frames
    waves = np.column_stack([f(k * phase) for k in (1, 2, 3) for f in (np.sin, np.cos)])
    amplitude = np.repeat([100.0, 40.0, 10.0], 2)
    mean = rng.normal(0, 300, n_columns)
    return mean + (waves * amplitude) @ rng.normal(0, 1, (6, n_columns))


def hidden(data, seed=0, length=30, columns=(3, 4, 5, 12)):
    rng = np.random.default_rng(seed)
    spoilt = data.copy()
    for column in columns:
        start = rng.integers(0, len(data) - length)
        spoilt[start : start + length, column] = np.nan
    return spoilt, np.isfinite(spoilt)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 1000), st.integers(4, 30), st.integers(4, 30), st.floats(0.1, 50))
def test_shrink_is_the_proximal_point_of_the_nuclear_norm(seed, n, m, threshold):
    """Reference: the singular value decomposition itself."""
    matrix = np.random.default_rng(seed).normal(0, 10, (n, m))
    u, s, vt = np.linalg.svd(matrix, full_matrices=False)
    np.testing.assert_allclose(
        shrink(matrix, threshold), (u * np.maximum(s - threshold, 0)) @ vt, atol=1e-5
    )
    assert nuclear_norm(matrix) == pytest.approx(s.sum(), rel=1e-6)


@pytest.mark.parametrize("group", [False, True])
class TestSparseLowRank:
    def solve(self, spoilt, known, group, iterations=2000, tolerance=1e-7, weight=0.1):
        penalty = frequency_penalty(len(spoilt), RATE, weight, 6.0, 100.0)
        return by_sparse_low_rank(spoilt, known, penalty, group, iterations, tolerance, trace=True)

    def test_meets_the_constraint_and_falls_to_its_limit(self, group):
        spoilt, known = hidden(treadmill())
        found = self.solve(spoilt, known, group)
        assert found.converged
        np.testing.assert_array_equal(found.matrix[known], spoilt[known])
        limit = found.objective[-1]
        assert found.objective[0] > limit
        assert np.abs(found.objective[-10:] - limit).max() < 1e-4 * limit
        assert found.objective.min() > limit * (1 - 1e-4)

    def test_no_neighbour_of_the_limit_is_better(self, group):
        """The problem is convex: the minimum is where no small step lowers the objective."""
        spoilt, known = hidden(treadmill())
        found = self.solve(spoilt, known, group)
        penalty = frequency_penalty(len(spoilt), RATE, 0.1, 6.0, 100.0)
        rng = np.random.default_rng(1)

        def objective(matrix):
            spectrum = np.fft.fft(matrix, axis=0, norm="ortho")
            weight = np.concatenate([penalty, penalty[1:-1][::-1]])
            length = np.linalg.norm(spectrum, axis=1) if group else np.abs(spectrum).sum(axis=1)
            return nuclear_norm(matrix) + weight @ length

        here = objective(found.matrix)
        assert here == pytest.approx(found.objective[-1], rel=1e-9)
        smooth = np.sin(np.linspace(0, np.pi, 300))[:, None] * np.ones((1, 24))
        for size in (0.3, 3.0):
            for step in (rng.normal(0, size, spoilt.shape), size * smooth, -size * smooth):
                assert objective(np.where(known, spoilt, found.matrix + step)) > here * (1 - 1e-6)

    def test_recovers_what_is_periodic(self, group):
        data = treadmill()
        spoilt, known = hidden(data)
        found = self.solve(spoilt, known, group, 300, 1e-4)
        assert np.abs(found.matrix - data)[~known].mean() < 2.0


@pytest.mark.parametrize(("rank", "rounds"), [(0, 1), (4, 10)])
def test_the_truncated_norm_keeps_the_data_and_converges(rank, rounds):
    data = treadmill()
    spoilt, known = hidden(data)
    found = by_truncated_norm(spoilt, known, rank, rounds, 500, 1e-5)
    assert found.converged
    np.testing.assert_array_equal(found.matrix[known], spoilt[known])
    assert np.abs(found.matrix - data)[~known].mean() < 10.0
    assert (np.diff(found.objective) < 1e-3 * found.objective[0]).all()


def test_a_penalty_counts_hertz_not_indices():
    short, long = (frequency_penalty(n, RATE, 0.5, 6.0, 100.0) for n in (100, 1000))
    assert (short > 1).sum() / len(short) == pytest.approx((long > 1).sum() / len(long), abs=0.02)
    assert set(long) == {0.5, 50.0}


def test_on_a_treadmill_the_papers_ordering_holds():
    """GS-LR before S-LR before PCA R1 on eleven markers of the legs, gaps of half a cycle."""
    walk = simulate("treadmill-fast", seed=3, duration_s=6)
    legs = ["LASI", "RASI", "LPSI", "RPSI", "LTHI", "LKNE", "LTIB", "LANK", "LHEE", "LTOE", "LMT5"]
    truth = walk.positions[:, [walk.index(label) for label in legs]]
    rng = np.random.default_rng(0)
    errors = {"gslr": [], "slr": [], "pca_r1": []}
    for _ in range(2):
        gaps = [(m, int(rng.integers(5, 535))) for m in rng.choice(11, 5, replace=False)]
        seen = truth.copy()
        for marker, start in gaps:
            seen[start : start + 60, marker] = np.nan
        take = Take(seen, walk.rate, legs)
        for method, found in errors.items():
            for marker, start in gaps:
                span = Span(start, start + 60)
                values = repair(take, legs[marker], span, method).values
                found.append(np.linalg.norm(values - truth[span.frames, marker], axis=1).mean())
    means = [np.mean(found) for found in errors.values()]
    assert means == sorted(means)
