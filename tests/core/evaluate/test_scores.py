"""Scores, counted by hand (Eq. 31 to 37)."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.metrics import confusion_matrix, f1_score, matthews_corrcoef

from markermend.evaluate import Truth
from markermend.evaluate.scores import (
    CLASSES,
    confusion,
    match,
    overall_f,
    overall_mcc,
    rates,
    standard_errors,
)
from markermend.model import Finding, Span, Take

TAKE = Take(np.zeros((100, 2, 3)), 100.0, ["a", "b"])


def truth(marker, start, stop, kind):
    return Truth(marker, Span(start, stop), kind, 10.0, ("x",), sign=1)


def finding(marker, start, stop, kind):
    return Finding(marker, Span(start, stop), kind)


def test_confusion_by_hand():
    truths = [truth("a", 10, 20, "step"), truth("b", 50, 51, "peak")]
    found = [finding("a", 12, 22, "step"), finding("b", 50, 52, "noise"), finding("a", 0, 9, "gap")]
    matrix = confusion(TAKE, truths, found)
    assert matrix.sum() == 200
    clear, peak, noise, step, _ = range(5)
    assert matrix[step, step] == 8
    assert matrix[step, clear] == 2
    assert matrix[clear, step] == 2
    assert matrix[peak, noise] == 1
    assert matrix[clear, noise] == 1
    assert matrix[clear, clear] == 200 - 8 - 2 - 2 - 1 - 1


def test_earlier_stages_come_first():
    found = [finding("a", 10, 11, "peak"), finding("a", 5, 20, "slow")]
    matrix = confusion(TAKE, [], found)
    assert matrix[0, CLASSES.index("peak")] == 1
    assert matrix[0, CLASSES.index("slow")] == 14


def test_rates_by_hand():
    matrix = np.array([[90, 2], [3, 5]])
    measured = rates(matrix, 1)
    assert measured.tpr == pytest.approx(100 * 5 / 8)
    assert measured.fnr == pytest.approx(100 * 3 / 8)
    assert measured.fpr == pytest.approx(100 * 2 / 7)  # as printed: fp / (tp + fp)
    assert measured.ppv == pytest.approx(100 * 5 / 7)
    assert measured.f == pytest.approx(5 / (5 + 0.5 * 5))
    root = np.sqrt(7 * 8 * 92 * 93)
    assert measured.mcc == pytest.approx((5 * 90 - 2 * 3) / root)


def test_nothing_there_is_none_and_not_nan():
    empty = rates(np.array([[10, 0], [0, 0]]), 1)
    assert (empty.tpr, empty.fpr, empty.f, empty.mcc) == (None, None, None, None)


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_as_scikit_learn_counts(seed):
    rng = np.random.default_rng(seed)
    true, called = rng.integers(0, 5, (2, 300))
    matrix = confusion_matrix(true, called, labels=range(5))
    assert overall_mcc(matrix) == pytest.approx(matthews_corrcoef(true, called))
    assert overall_f(matrix) == pytest.approx(f1_score(true, called, average="micro"))
    for index in range(5):
        single = rates(matrix, index)
        assert single.f == pytest.approx(f1_score(true == index, called == index))
        assert single.mcc == pytest.approx(matthews_corrcoef(true == index, called == index))


def test_spans_by_hand():
    truths = [truth("a", 10, 20, "step"), truth("a", 40, 50, "step"), truth("b", 10, 20, "slow")]
    found = [
        finding("a", 12, 22, "step"),  # IoU 8 / 12
        finding("a", 46, 60, "step"),  # IoU 4 / 20: neither found nor false
        finding("a", 70, 80, "step"),  # false
        finding("b", 10, 20, "step"),  # wrong kind, but there is something
    ]
    step = match(truths, found)["step"]
    assert (step.true, step.found, step.called, step.false) == (2, 1, 4, 1)
    slow = match(truths, found)["slow"]
    assert (slow.true, slow.found, slow.called, slow.false) == (1, 0, 0, 0)


def test_one_finding_finds_one_artefact():
    truths = [truth("a", 10, 20, "step")]
    found = [finding("a", 10, 20, "step"), finding("a", 11, 20, "step")]
    assert match(truths, found)["step"].found == 1
    assert match(truths, found[:1])["step"].found == 1


def test_standard_errors_are_those_of_the_mean_where_simulations_weigh_the_same():
    shares = np.array([7, 9, 4, 8, 10])
    matrices = [np.array([[90, 0], [10 - k, k]]) for k in shares]
    tpr, fpr = standard_errors(matrices, 1)
    assert tpr == pytest.approx(10.0 * shares.std(ddof=1) / np.sqrt(5))
    assert fpr == pytest.approx(0.0)
    assert standard_errors(matrices[:1], 1) == (None, None)
    assert standard_errors([np.array([[90, 0], [10, 0]])] * 3, 1)[1] is None
