"""The weights of a mix are the best there are, and only as many as pay."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from markermend.repairing.blend.mixing import MOST_MEMBERS, mix, simplex_weights


@given(st.integers(1, 4), st.integers(0, 2**32 - 1))
@settings(max_examples=60, deadline=None)
def test_no_point_of_the_simplex_is_better(n, seed):
    rng = np.random.default_rng(seed)
    half = rng.normal(size=(n, n + 2))
    covariance = half @ half.T
    weights = simplex_weights(covariance)
    assert (weights >= 0).all()
    np.testing.assert_allclose(weights.sum(), 1.0)
    others = rng.dirichlet(np.ones(n), 200)
    reached = weights @ covariance @ weights
    assert (np.einsum("ki,ij,kj->k", others, covariance, others) >= reached - 1e-9).all()


def test_errors_that_cancel_are_mixed_and_copies_are_not():
    rng = np.random.default_rng(5)
    common, own = rng.normal(size=(8, 90)), rng.normal(size=(8, 90))
    members, weights = mix(np.stack([common + own, common - own, common + own, 9 * common]))
    assert sorted(members) in ([0, 1], [1, 2])
    np.testing.assert_allclose(weights, 0.5, atol=0.05)


@given(st.integers(1, 9), st.integers(0, 2**32 - 1))
@settings(max_examples=30, deadline=None)
def test_few_members_with_positive_weights(n, seed):
    members, weights = mix(np.random.default_rng(seed).normal(size=(n, 6, 30)))
    assert 1 <= len(members) <= MOST_MEMBERS
    assert len(set(members)) == len(members)
    assert (weights > 0).all()
    np.testing.assert_allclose(weights.sum(), 1.0)
