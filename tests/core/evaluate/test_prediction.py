"""The tables of how well markers can be predicted."""

import json
from dataclasses import replace

import numpy as np
import pytest

from markermend.errors import BadInput, UnknownName
from markermend.evaluate import predictors
from markermend.model import Take


@pytest.fixture(scope="module")
def take():
    """Two loose groups of four markers; the motion is a smooth random walk."""
    rng = np.random.default_rng(0)
    walk = rng.normal(0, 1, (600, 2, 3)).cumsum(0).cumsum(0)
    walk = 300 * walk / np.abs(walk).max()
    positions = np.repeat(walk, 4, axis=1) + rng.normal(0, 120, (8, 3))
    positions += rng.normal(0, 1.0, positions.shape)
    return Take(positions, 100.0, [f"m{i}" for i in range(8)])


def test_correlation(take):
    table = predictors(take, tables=["correlation"]).correlation
    matrix = np.array(table.matrix)
    x = take.positions[:, [take.index(label) for label in table.labels], 0]
    assert matrix == pytest.approx(np.corrcoef(x.T))
    itself = table.lagged[0]
    assert itself.relation == "itself"
    assert itself.values[itself.lags.index(0)] == pytest.approx(1.0)
    assert itself.values == pytest.approx(itself.values[::-1])


def test_lag_has_the_right_sign():
    """The second marker does what the first did 20 frames earlier."""
    rng = np.random.default_rng(1)
    walk = rng.normal(size=(1000, 3)).cumsum(0)
    walk = np.diff(walk, axis=0, prepend=walk[:1]) * 50
    late = np.roll(walk, 20, axis=0)
    pair = Take(np.stack([walk, late + np.array([100.0, 0, 0])], 1), 100.0, ["a", "b"])
    lagged = predictors(pair, tables=["correlation"], markers=["a"]).correlation.lagged[-1]
    assert (lagged.first, lagged.second) == ("a", "b")
    assert lagged.lags[int(np.argmax(lagged.values))] == 20


def test_residuals_and_laplace(take):
    fits = predictors(take, tables=["residuals"], n_markers=2).residuals
    assert {fit.variant for fit in fits} == {"neighbours", "with own past"}
    for fit in fits:
        assert fit.b == pytest.approx(fit.sigma / 2**0.5)
        width = np.diff(fit.edges)
        assert np.sum(fit.density * width) == pytest.approx(1.0)
        assert np.sum(fit.laplace * width) == pytest.approx(1.0, abs=0.02)
        middle = 0.5 * (fit.edges[30] + fit.edges[29])
        assert fit.laplace[29] == pytest.approx(
            np.exp(-abs(middle) / fit.b) / (2 * fit.b), rel=1e-6
        )


def test_sweep_learns_better_with_order_and_not_held_out(take):
    points = predictors(take, tables=["sweep"], n_markers=2).sweep
    orders = [p for p in points if p.parameter == "order"]
    assert [p.order for p in orders] == [1, 2, 3, 4, 5, 6]
    assert orders[3].learnt_mm < orders[0].learnt_mm
    assert all(p.held_out_mm > p.learnt_mm for p in points)


def test_mean_of_replicas_is_quieter_than_each(take):
    table = predictors(take, tables=["replicas"], n_markers=3).replicas
    assert len(table) == 3
    assert all(len(row.replicas) == 5 and row.mean < min(row.replicas) for row in table)


def test_regressors(take):
    short = Take(take.positions[:240], 100.0, take.labels)
    table = predictors(short, tables=["regressors"], n_markers=1)
    scores = {score.name: score for score in table.regressors}
    assert set(scores) == {"polynomial", "ffnn", "ridge", "lasso", "svr", "tree", "narx"}
    assert all(score.held_out_mm > 0 for score in scores.values())
    # What fits closer follows an artefact closer: least in the stiff, most in the tree.
    assert scores["lasso"].shown > scores["polynomial"].shown > scores["tree"].shown
    again = predictors(short, tables=["regressors"], n_markers=1)
    timeless = [replace(s, seconds=0.0) for s in table.regressors]
    assert [replace(s, seconds=0.0) for s in again.regressors] == timeless


def test_json_tables_and_progress(take):
    seen = []
    wanted = ["residuals", "correlation"]
    made = predictors(
        take, tables=wanted, n_markers=1, progress=lambda done, total: seen.append((done, total))
    )
    assert seen == [(1, 2), (2, 2)]
    assert json.loads(json.dumps(made.to_json(), allow_nan=False))["experiment"] == "predictors"
    for _, columns, rows in made.tables():
        assert {len(row) for row in rows} == {len(columns)}
    assert {title for title, _, _ in made.tables()} == set(wanted)


def test_gaps_are_left_out(take):
    positions = take.positions.copy()
    positions[100:150, 3] = np.nan
    holed = take.with_positions(positions)
    assert np.isfinite(predictors(holed, tables=["residuals"], markers=["m3"]).residuals[0].sigma)


def test_refusals(take):
    with pytest.raises(UnknownName, match="no table 'spells'"):
        predictors(take, tables=["spells"])
    with pytest.raises(UnknownName, match="no marker 'knee'"):
        predictors(take, markers=["knee"])
    with pytest.raises(BadInput, match="2 s or more"):
        predictors(Take(take.positions[:100], 100.0, take.labels))
    with pytest.raises(BadInput, match="two markers"):
        predictors(Take(take.positions[:, :1], 100.0, ["m0"]))
