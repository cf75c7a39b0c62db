"""Regressors that the paper tried beside its network, by scikit-learn."""

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sklearn.exceptions import ConvergenceWarning
from sklearn.linear_model import Lasso, Ridge
from sklearn.multioutput import MultiOutputRegressor
from sklearn.neural_network import MLPRegressor
from sklearn.svm import SVR
from sklearn.tree import DecisionTreeRegressor

from markermend.body import Body
from markermend.model import BoolArray, FloatArray
from markermend.predict import ffnn, polynomial
from markermend.predict.regressors import powers, regressor_markers, standardised, with_past

Predict = Callable[[FloatArray, BoolArray, Body, int, int], FloatArray]
"""positions, trusted (n_frames,), body, marker, seed -> (n_frames, n_dims)."""

# Frames that the regressors of scikit-learn learn from; more is impractical for some of them.
LEARNT = 1500


def _learner(make: Callable[[int], Any], own_past: int = 0) -> Predict:
    """Make a predictor of a regressor: inputs of Eq. 11 with k = 1 and L = 2."""

    def predict(
        positions: FloatArray, trusted: BoolArray, body: Body, marker: int, seed: int
    ) -> FloatArray:
        frames: NDArray[np.intp] = np.arange(len(positions))
        neighbours = regressor_markers(body, marker, 6)
        X = with_past(powers(positions, neighbours, 2), frames, 1)
        target = positions[:, marker]
        if own_past:
            own = standardised(target)[np.maximum(frames - 1, 0)]
            X = np.concatenate([X, with_past(own, frames, own_past - 1)], axis=1)
        learnt = np.flatnonzero(trusted)
        learnt = learnt[:: -(-len(learnt) // LEARNT)]
        mean, spread = target[learnt].mean(axis=0), np.maximum(target[learnt].std(axis=0), 1e-9)
        with warnings.catch_warnings():
            # Training is cut short on purpose; how well it went is what is being measured.
            warnings.simplefilter("ignore", ConvergenceWarning)
            model = make(seed).fit(X[learnt], (target[learnt] - mean) / spread)
        predicted: FloatArray = model.predict(X) * spread + mean
        return predicted

    return predict


def _polynomial(
    positions: FloatArray, trusted: BoolArray, body: Body, marker: int, seed: int
) -> FloatArray:
    predicted = polynomial(positions, trusted, body, marker)
    return np.full_like(positions[:, marker], np.nan) if predicted is None else predicted


def _network(
    positions: FloatArray, trusted: BoolArray, body: Body, marker: int, seed: int
) -> FloatArray:
    all_trusted = np.repeat(trusted[:, None], positions.shape[1], axis=1)
    return ffnn(positions, all_trusted, body, [marker], seed=seed)[:, 0]


REGRESSORS: dict[str, Predict] = {
    "polynomial": _polynomial,
    "ffnn": _network,
    "ridge": _learner(lambda seed: Ridge(alpha=1.0)),
    "lasso": _learner(lambda seed: Lasso(alpha=1e-3, max_iter=2000, random_state=seed)),
    "svr": _learner(lambda seed: MultiOutputRegressor(SVR(C=10.0, epsilon=0.01))),
    "tree": _learner(lambda seed: DecisionTreeRegressor(min_samples_leaf=5, random_state=seed)),
    "narx": _learner(
        lambda seed: MLPRegressor(
            hidden_layer_sizes=(12,), activation="tanh", max_iter=200, random_state=seed
        ),
        own_past=2,
    ),
}
"""The predictors of the package and those of scikit-learn; NARX sees the marker's own past."""
