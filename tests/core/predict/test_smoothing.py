"""Moving median and Savitzky-Golay, on signals worked out by hand (Eq. 6, 7, 18)."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from markermend.predict import median_highpass, savgol_highpass, savgol_lowpass
from markermend.predict.smoothing import odd, scaled


def test_median_by_hand():
    x = np.array([[0.0], [0], [9], [0], [0], [2], [2], [2]])
    assert median_highpass(x, 3).ravel().tolist() == [0, 0, 9, 0, 0, 0, 0, 0]


@given(degree=st.integers(0, 5), n=st.integers(13, 60))
def test_savgol_leaves_nothing_of_a_polynomial_of_its_order(degree, n):
    t = np.linspace(-1, 1, n)
    assert np.abs(savgol_highpass((t**degree)[:, None], 5, 13)).max() < 1e-9


def test_savgol_is_the_least_squares_polynomial_of_its_window():
    rng = np.random.default_rng(0)
    x = rng.normal(size=(40, 1))
    t = np.arange(-6, 7)
    fit = np.polynomial.polynomial.polyfit(t, x[14:27, 0], 5)
    assert savgol_lowpass(x, 5, 13)[20, 0] == pytest.approx(fit[0])


@pytest.mark.parametrize("n", [1, 2, 3, 4, 7])
def test_short_signals(n):
    assert np.isfinite(savgol_highpass(np.arange(n, dtype=float)[:, None], 5, 13)).all()
    assert np.isfinite(median_highpass(np.arange(n, dtype=float)[:, None], 19)).all()


@pytest.mark.parametrize(("rate", "window"), [(50, 7), (100, 13), (120, 15), (200, 25), (240, 31)])
def test_windows_keep_their_duration_and_stay_odd(rate, window):
    assert odd(13, rate) == window
    assert scaled(20, rate) == 20 * rate // 100
