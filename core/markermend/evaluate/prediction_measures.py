"""The measurements behind the tables of prediction: one function a table."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from markermend.body import Body
from markermend.evaluate.prediction_tables import (
    Correlation,
    Lagged,
    RegressorScore,
    ReplicaResidual,
    ResidualFit,
    SweepPoint,
)
from markermend.evaluate.regressors import REGRESSORS
from markermend.model import BoolArray, FloatArray, Span
from markermend.predict import ffnn_replicas, polynomial

ORDERS = (1, 2, 3, 4, 5, 6)
CONTEXTS = (0, 1, 2, 3, 4, 6, 8)
FOLDS = 5
# Frames at 100 Hz beside a fold that are not learnt from, since neighbours in time are alike.
EMBARGO = 50
# The artefact of which a residual should show all: a triangle of 10 mm over half a second.
ARTEFACT_MM, ARTEFACT_FRAMES = 10.0, 50
LAG_S = 1.0


@dataclass(frozen=True, eq=False)
class Case:
    """A take without gaps, its body, and the markers looked at."""

    positions: FloatArray
    seen: BoolArray
    rate: float
    labels: tuple[str, ...]
    body: Body
    markers: tuple[int, ...]
    seed: int


def correlation(case: Case) -> Correlation:
    """Correlate x of all markers, and of some pairs over lags (Fig. 3)."""
    order = list(case.body.order)
    x = case.positions[:, order, 0]
    x = x - x.mean(axis=0)
    x = x / np.maximum(np.linalg.norm(x, axis=0), 1e-12)
    matrix = x.T @ x
    lag = min(round(LAG_S * case.rate), len(x) // 4)
    lagged = []
    first = order.index(case.markers[0])
    siblings = case.body.siblings(case.markers[0])
    parent = case.body.parent(case.markers[0])
    far = case.body.neighbours(case.markers[0])[-1]
    others = [("itself", case.markers[0])]
    others += [("sibling", siblings[0])] if siblings else []
    others += [("parent", parent)] if parent is not None else []
    others += [("far away", far)]
    for relation, other in others:
        a, b = x[:, first], x[:, order.index(other)]
        values = [
            float(a[max(0, -k) : len(a) - max(0, k)] @ b[max(0, k) : len(b) - max(0, -k)])
            for k in range(-lag, lag + 1)
        ]
        names = (case.labels[case.markers[0]], case.labels[other])
        lagged.append(Lagged(*names, relation, tuple(range(-lag, lag + 1)), tuple(values)))
    return Correlation(
        tuple(case.labels[m] for m in order),
        tuple(tuple(map(float, row)) for row in matrix),
        tuple(lagged),
    )


def residuals(case: Case) -> tuple[ResidualFit, ...]:
    """Fit Laplace's density to the residuals of P_3^4, without and with the own past (Fig. 6)."""
    fits = []
    for marker in case.markers:
        seen = case.seen[:, marker]
        for variant, own_past in (("neighbours", False), ("with own past", True)):
            predicted = polynomial(case.positions, seen, case.body, marker, own_past=own_past)
            if predicted is None:
                continue
            residual = (case.positions[:, marker] - predicted)[seen].ravel()
            fits.append(_fit(case.labels[marker], variant, residual))
    return tuple(fits)


def _fit(label: str, variant: str, residual: FloatArray) -> ResidualFit:
    sigma = float(residual.std())
    b = sigma / np.sqrt(2.0)
    reach = max(5.0 * sigma, 1e-9)
    density, edges = np.histogram(residual, 60, (-reach, reach), density=True)
    middle = 0.5 * (edges[1:] + edges[:-1])
    laplace = np.exp(-np.abs(middle) / max(b, 1e-12)) / (2.0 * max(b, 1e-12))
    return ResidualFit(
        marker=label,
        variant=variant,
        sigma=sigma,
        b=float(b),
        b_likelihood=float(np.abs(residual).mean()),
        edges=tuple(edges.tolist()),
        density=tuple(density.tolist()),
        laplace=tuple(laplace.tolist()),
    )


def _folds(case: Case) -> list[tuple[Span, Span]]:
    """Give each fold, and the frames around it that are not learnt from."""
    n = len(case.positions)
    edges = np.linspace(0, n, FOLDS + 1).round().astype(int).tolist()
    pause = min(round(EMBARGO * case.rate / 100.0), n // (4 * FOLDS))
    folds = [Span(a, b) for a, b in pairwise(edges)]
    return [(fold, fold.padded(pause, n)) for fold in folds]


Predictor = Callable[[FloatArray, BoolArray, int], FloatArray | None]


def _measured(case: Case, predict: Predictor) -> tuple[float, float, float]:
    """Residual learnt and held out in mm, mean over the markers, and seconds a marker."""
    learnt, held_out = [], []
    started = time.perf_counter()
    for marker in case.markers:
        seen = case.seen[:, marker]
        learnt.append(_spread(case, predict(case.positions, seen, marker), marker, seen))
    seconds = (time.perf_counter() - started) / len(case.markers)
    for marker in case.markers:
        seen = case.seen[:, marker]
        whole = np.full_like(case.positions[:, marker], np.nan)
        for fold, around in _folds(case):
            trusted = seen.copy()
            trusted[around.frames] = False
            predicted = predict(case.positions, trusted, marker)
            if predicted is not None:
                whole[fold.frames] = predicted[fold.frames]
        held_out.append(_spread(case, whole, marker, seen))
    return float(np.mean(learnt)), float(np.mean(held_out)), seconds


def _spread(case: Case, predicted: FloatArray | None, marker: int, seen: BoolArray) -> float:
    if predicted is None:
        return float("inf")
    residual = (case.positions[:, marker] - predicted)[seen]
    return float(np.sqrt((residual[np.isfinite(residual)] ** 2).mean()))


def sweep(case: Case) -> tuple[SweepPoint, ...]:
    """Measure P_k^L over orders L and contexts k (Fig. 7)."""
    points = []
    plan = [("order", order, 3) for order in ORDERS] + [("context", 4, k) for k in CONTEXTS]
    for parameter, order, context in plan:

        def predict(
            positions: FloatArray,
            trusted: BoolArray,
            marker: int,
            order: int = order,
            context: int = context,
        ) -> FloatArray | None:
            return polynomial(positions, trusted, case.body, marker, order=order, context=context)

        points.append(SweepPoint(parameter, order, context, *_measured(case, predict)))
    return tuple(points)


def replicas(case: Case) -> tuple[ReplicaResidual, ...]:
    """Measure each replica of the network's output, and their mean (Fig. 9)."""
    markers = list(case.markers)
    outputs = ffnn_replicas(
        case.positions,
        case.seen,
        case.body,
        markers,
        window=round(2.0 * case.rate),
        seed=case.seed,
    )
    table = []
    for place, marker in enumerate(markers):
        seen = case.seen[:, marker]
        residual = (case.positions[:, marker, None] - outputs[:, place])[seen]
        each = residual.std(axis=(0, 2))
        mean = float(residual.mean(axis=1).std())
        table.append(ReplicaResidual(case.labels[marker], tuple(map(float, each)), mean))
    return tuple(table)


def regressors(case: Case) -> tuple[RegressorScore, ...]:
    """Measure all regressors: learnt, held out, and what they show of an artefact."""
    scores = []
    for name, regress in REGRESSORS.items():

        def predict(
            positions: FloatArray,
            trusted: BoolArray,
            marker: int,
            regress: Any = regress,
        ) -> FloatArray | None:
            predicted: FloatArray = regress(positions, trusted, case.body, marker, case.seed)
            return predicted

        learnt, held_out, seconds = _measured(case, predict)
        shown = float(np.mean([_shown(case, predict, marker) for marker in case.markers]))
        scores.append(RegressorScore(name, learnt, held_out, shown, seconds))
    return tuple(scores)


def _shown(case: Case, predict: Predictor, marker: int) -> float:
    """Give the share of a slow change that the residual shows, if it is learnt from as well."""
    n = len(case.positions)
    length = min(max(3, round(ARTEFACT_FRAMES * case.rate / 100.0)), n // 4)
    start = (n - length) // 2
    triangle = np.zeros(n)
    middle = (length - 1) / 2.0
    triangle[start : start + length] = 1.0 - np.abs(np.arange(length) - middle) / (middle + 1.0)
    seen: NDArray[np.bool_] = case.seen[:, marker]
    dirty = case.positions.copy()
    dirty[:, marker, 0] += ARTEFACT_MM * triangle
    before, after = predict(case.positions, seen, marker), predict(dirty, seen, marker)
    if before is None or after is None:
        return float("nan")
    change = (dirty[:, marker] - after) - (case.positions[:, marker] - before)
    return float(change[:, 0] @ triangle / (ARTEFACT_MM * (triangle @ triangle)))
