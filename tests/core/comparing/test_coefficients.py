import krippendorff
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from sklearn.metrics import cohen_kappa_score

from markermend.comparing.coefficients import MISSING, cohen_kappa, krippendorff_alpha

CLASSES = 5
LABELS = st.integers(0, CLASSES - 1)


def table(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    counts = np.zeros((CLASSES, CLASSES), np.int64)
    np.add.at(counts, (one, other), 1)
    return counts


@given(st.integers(1, 60).flatmap(lambda n: arrays(np.intp, (2, n), elements=LABELS)))
def test_kappa_is_that_of_scikit_learn(both: np.ndarray) -> None:
    one, other = both
    ours = cohen_kappa(table(one, other))
    if len(np.unique(both)) == 1:
        assert ours is None
    else:
        assert ours == pytest.approx(cohen_kappa_score(one, other), abs=1e-12)


@given(
    st.tuples(st.integers(2, 5), st.integers(1, 40)).flatmap(
        lambda shape: arrays(np.intp, shape, elements=st.integers(MISSING, CLASSES - 1))
    )
)
def test_alpha_is_that_of_the_package_krippendorff(values: np.ndarray) -> None:
    pairable = (values != MISSING).sum(axis=0) >= 2
    known = values[:, pairable]
    assume(len(np.unique(known[known != MISSING])) >= 2)
    data = np.where(values == MISSING, np.nan, values).astype(float)
    theirs = krippendorff.alpha(
        reliability_data=data,
        value_domain=list(range(CLASSES)),
        level_of_measurement="nominal",
    )
    assert krippendorff_alpha(values, CLASSES) == pytest.approx(theirs, abs=1e-12)


def test_alpha_is_that_of_krippendorffs_own_example() -> None:
    # Krippendorff (2011), Computing Krippendorff's Alpha-Reliability, C: nominal data, 0.743.
    _ = MISSING
    values = np.array(
        [
            [1, 2, 3, 3, 2, 1, 4, 1, 2, _, _, _],
            [1, 2, 3, 3, 2, 2, 4, 1, 2, 5, _, 3],
            [_, 3, 3, 3, 2, 3, 4, 2, 2, 5, 1, _],
            [1, 2, 3, 3, 2, 4, 4, 1, 2, 5, 1, _],
        ]
    )
    assert krippendorff_alpha(values, 6) == pytest.approx(0.743, abs=5e-4)


@given(arrays(np.intp, (2, 30), elements=LABELS))
def test_both_coefficients_are_symmetric(both: np.ndarray) -> None:
    counts = table(*both)
    assert cohen_kappa(counts) == pytest.approx(cohen_kappa(counts.T))
    assert krippendorff_alpha(both, CLASSES) == pytest.approx(
        krippendorff_alpha(both[::-1], CLASSES)
    )


def test_nothing_can_be_said_without_two_classes() -> None:
    assert cohen_kappa(np.zeros((3, 3))) is None
    assert cohen_kappa(np.diag([9, 0, 0])) is None
    assert krippendorff_alpha(np.zeros((2, 9), np.intp), 3) is None
    assert krippendorff_alpha(np.array([[1, MISSING], [MISSING, 2]]), 3) is None
    assert krippendorff_alpha(np.empty((2, 0), np.intp), 3) is None
