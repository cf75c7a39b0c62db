"""Pictures of the experiments: what their elements hold, and that a file asks for nothing."""

from dataclasses import replace
from typing import Any

import holoviews as hv
import numpy as np
import pytest

from markermend.evaluate.classification import Cell, Classification, SpanFigures
from markermend.evaluate.masks import Row
from markermend.evaluate.operators import Comparison
from markermend.evaluate.operators import Row as Operated
from markermend.evaluate.prediction_tables import (
    Correlation,
    Lagged,
    Predictors,
    RegressorScore,
    ReplicaResidual,
    ResidualFit,
    SweepPoint,
)
from markermend.evaluate.reconstruction import Reconstruction, Reconstructions
from markermend.evaluate.scores import CLASSES, rates
from markermend_app.plots import experiments, masks, prediction
from markermend_app.style.kinds import KIND_STYLES

MATRIX = np.array(
    [
        [16000.0, 2, 0, 14, 0],
        [1, 15, 0, 0, 0],
        [0, 0, 16, 0, 0],
        [8, 0, 0, 8, 0],
        [9.6, 0, 0, 6.4, 0],
    ]
)


def cell(detector: str = "likelihood", amplitude: float = 5.0, share: float = 0.05) -> Cell:
    return Cell(
        detector=detector,
        amplitude_mm=amplitude,
        share=share,
        simulations=7,
        matrix=MATRIX,
        classes={name: rates(MATRIX, i) for i, name in enumerate(CLASSES)},
        f=0.99,
        mcc=0.9,
        spans={kind: SpanFigures(4, 3, 5, 0.5, 0.0) for kind in CLASSES[1:]},
    )


def parts(element: Any, kind: type) -> list[Any]:
    """Give the elements of one type in an overlay."""
    return [part for part in element.traverse(lambda one: one) if type(part) is kind]


def rows_of(element: Any) -> list[tuple[Any, ...]]:
    """Give the rows of an element's table, as Python's own values."""
    columns = (element.dimension_values(d).tolist() for d in element.dimensions())
    return list(zip(*columns, strict=True))


def classified() -> Classification:
    cells = tuple(
        cell(detector, amplitude, share)
        for detector in ("likelihood", "published")
        for amplitude in (5.0, 10.0)
        for share in (0.05, 0.1)
    )
    return Classification(2200, 53, 100.0, 11, cells)


def test_a_confusion_matrix_has_every_number_at_its_place():
    element = experiments.confusion(cell())
    (shades,) = parts(element, hv.HeatMap)
    held = {(truth, found): (p, n) for found, truth, p, n in rows_of(shades)}
    for i, truth in enumerate(CLASSES):
        for j, found in enumerate(CLASSES):
            per_cent = 100 * MATRIX[i, j] / MATRIX[i].sum()
            assert held[truth, found] == pytest.approx((per_cent, MATRIX[i, j]))
    written: dict[tuple[str, str], set[str]] = {}
    for labels in parts(element, hv.Labels):
        for found, truth, text in rows_of(labels):
            written.setdefault((truth, found), set()).add(text)
    assert len(written) == 25
    assert written["clear", "clear"] == {"16\N{THIN SPACE}000", "99.9 %"}
    assert written["slow", "step"] == {"6", "40.0 %"}


def test_sensitivity_and_false_discovery_stand_in_groups_of_shares_per_kind():
    cells = [cell(detector, share=share) for share in (0.05, 0.1) for detector in ("one", "two")]
    element = experiments.by_kind(cells, "tpr", "Sensitivity")
    points = {dots.label: rows_of(dots) for dots in parts(element, hv.Scatter)}
    assert set(points) == {f"{k}, {d}" for k in CLASSES[1:] for d in ("one", "two")}
    assert points["peak, one"] == [(0, 93.75), (1, 93.75)]
    assert points["step, two"] == [(6, 50.0), (7, 50.0)]
    colours = {
        dots.label.partition(",")[0]: dots.opts.get("style", backend="bokeh").kwargs["line_color"]
        for dots in parts(element, hv.Scatter)
    }
    assert colours == {kind: KIND_STYLES[kind].light for kind in CLASSES[1:]}


def test_where_nothing_was_called_there_is_no_false_discovery():
    element = experiments.by_kind([cell()], "fpr", "False discovery rate")
    held = {dots.label: rows_of(dots) for dots in parts(element, hv.Scatter)}
    assert held["slow, likelihood"] == []
    assert held["step, likelihood"] == [(4, pytest.approx(100 * 20.4 / 28.4))]


def test_the_picture_of_e1_has_a_matrix_per_detector_amplitude_and_share():
    picture = experiments.classification(classified(), "walk.c3d")
    assert [len(row) for row in picture.rows] == [2, 2, 2, 2, 2, 2]
    assert picture.panels[4].title == "likelihood, 5 mm, 5 % of the time"
    assert picture.panels[-1].title == "published, 10 mm, 10 % of the time"
    assert "walk.c3d" in picture.title
    for words in ("n = 7 simulations", "53 markers × 2200 frames at 100 Hz", "seed 11"):
        assert words in picture.caption


COMPARISON = Comparison(
    "likelihood",
    3,
    5,
    (Operated("none", 10, 11, 9, 2, 1), Operated("expert", 9.5, 2.5, 0.5, 2, 0)),
)


def test_operators_are_groups_of_bars_with_their_numbers():
    picture = experiments.operators([COMPARISON], "walk.c3d")
    (panel,) = picture.panels
    (bars,) = parts(panel.element, hv.Bars)
    assert rows_of(bars) == [
        *((0, 10.0), (1, 11.0), (2, 9.0), (3, 2.0), (4, 1.0)),
        *((6, 9.5), (7, 2.5), (8, 0.5), (9, 2.0), (10, 0.0)),
    ]
    numbers, names = parts(panel.element, hv.Labels)
    assert [text for *_, text in rows_of(numbers)][5:] == ["9.5", "2.5", "0.5", "2.0", "0.0"]
    assert [(x, text) for x, _, text in rows_of(names)] == [(2.0, "none"), (8.0, "expert")]
    assert "n = 3 simulations, seed 5" in picture.caption


REPAIRED = Reconstruction("peak", 0.05, "linear", "perfect", 4, 0.01, 0.002, 0.3, 0.5, 0, 9)


def reconstructed() -> Reconstructions:
    cells = (
        REPAIRED,
        replace(REPAIRED, spans="detected", rmse_mm=0.09, sd_mm=0.2),
        replace(REPAIRED, method="", rmse_mm=0.005),
        replace(REPAIRED, kind="slow", distorted_mm=0.2),
        replace(REPAIRED, share=0.1),
    )
    return Reconstructions(2200, 53, 100.0, 2, 10.0, "likelihood", cells)


def test_what_repairs_leave_stands_by_kind_and_method_with_its_spread():
    picture = experiments.reconstruction(reconstructed(), "walk.c3d")
    assert [panel.title for panel in picture.panels] == ["5 % of the time", "10 % of the time"]
    element = picture.panels[0].element
    points = {dots.label: rows_of(dots) for dots in parts(element, hv.Scatter)}
    assert points["peak, perfect"] == [(-0.17, 0.01, 0.002), (0.83, 0.005, 0.002)]
    assert points["peak, detected"] == [(0.17, 0.09, 0.2)]
    assert points["slow, perfect"] == [(2.83, 0.01, 0.002)]
    segments = [rows_of(one) for one in parts(element, hv.Segments)]
    assert [(x0, y) for ((x0, y, *_),) in (segments[0], segments[3])] == [(-0.6, 0.3), (2.4, 0.2)]
    assert segments[1][0] == (-0.17, pytest.approx(0.008), -0.17, pytest.approx(0.012))
    bottom = segments[2][0][1]  # the spread is larger than the mean: there is no such logarithm
    assert 0 < bottom < 0.005
    assert "n = 4 simulations" in picture.caption
    assert "seed 2" in picture.caption


ROW = Row("T 20 frames", "auto", 30, 0, 1.4, 1.3, 1.0, "LGRNN", 3.5, 0.4, 12.0)


def test_masks_are_ratios_to_the_best_other_program():
    worse = replace(ROW, method="pchip", left=2, mean_mm=35.0, ratio=10.0)
    lonely = replace(ROW, cell="T 50 frames", best="", best_mm=np.nan, ratio=np.nan)
    picture = masks.masks([ROW, worse, lonely], [4, 3])
    ratios, errors = (panel.element for panel in picture.panels)
    (points,) = parts(ratios, hv.Points)
    assert rows_of(points) == [(0.4, 0), (10.0, 1)]
    numbers, names = parts(ratios, hv.Labels)
    assert [text for *_, text in rows_of(numbers)] == ["0.40", "10.00"]
    assert {text.strip() for *_, text in rows_of(names)} == {"× LGRNN (3.50 mm)"}
    (points,) = parts(errors, hv.Points)
    assert rows_of(points) == [(1.4, 0), (35.0, 1), (1.4, 2)]
    ticks = errors.opts.get("plot", backend="bokeh").kwargs["yticks"]
    assert [name for _, name in ticks] == [
        "T 20 frames, auto",
        "T 20 frames, pchip (2)",
        "T 50 frames, auto",
    ]
    assert "n = 30 gaps a row, seeds of the masks 3, 4" in picture.caption


def test_masks_without_other_programs_show_the_errors_alone():
    row = replace(ROW, best="", best_mm=np.nan, ratio=np.nan)
    picture = masks.masks([row], [0])
    assert "other program" not in picture.caption
    assert [panel.title for panel in picture.panels] == ["Mean and standard deviation of the error"]


def predicted() -> Predictors:
    edges = tuple(np.linspace(-2, 2, 5).tolist())
    fit = ResidualFit("A:M1", "neighbours", 1.0, 0.7, 0.6, edges, (0.1, 0.4, 0.4, 0.1), (0.1,) * 4)
    return Predictors(
        600,
        200.0,
        ("A:M1",),
        9,
        Correlation(
            ("A:M1", "A:M2"),
            ((1.0, -0.5), (-0.5, 1.0)),
            (Lagged("A:M1", "A:M2", "sibling", (-1, 0, 1), (0.1, -0.5, 0.2)),),
        ),
        (fit, replace(fit, variant="with own past")),
        (
            SweepPoint("order", 1, 3, 2.0, 3.0, 0.1),
            SweepPoint("order", 2, 3, 1.0, float("inf"), 0.1),
            SweepPoint("context", 4, 0, 2.0, 5.0, 0.1),
        ),
        (ReplicaResidual("A:M1", (1.0, 1.5), 0.9),),
        (RegressorScore("ridge", 1.0, 2.0, 0.3, 0.1),),
    )


def test_correlation_and_lags_hold_the_tables():
    table = predicted().correlation
    assert table is not None
    assert set(rows_of(prediction.correlation(table))) == {
        ("M1", "M1", 1.0),
        ("M2", "M1", -0.5),
        ("M1", "M2", -0.5),
        ("M2", "M2", 1.0),
    }
    (curve,) = parts(prediction.lagged(table, 200.0), hv.Curve)
    assert rows_of(curve) == [(-0.005, 0.1), (0.0, -0.5), (0.005, 0.2)]
    assert curve.label == "A:M2 (sibling)"


def test_residuals_hold_the_histogram_and_laplace_at_its_middles():
    element = prediction.laplace(predicted().residuals[0])
    (histogram,), (curve,) = parts(element, hv.Histogram), parts(element, hv.Curve)
    assert histogram.edges.tolist() == [-2.0, -1.0, 0.0, 1.0, 2.0]
    assert histogram.dimension_values("density").tolist() == [0.1, 0.4, 0.4, 0.1]
    assert rows_of(curve) == [(-1.5, 0.1), (-0.5, 0.1), (0.5, 0.1), (1.5, 0.1)]


def test_sweeps_leave_out_what_is_not_finite():
    points = [point for point in predicted().sweep if point.parameter == "order"]
    learnt, held_out = parts(prediction.sweep(points), hv.Curve)
    assert rows_of(learnt) == [(1, 2.0), (2, 1.0)]
    assert rows_of(held_out) == [(1, 3.0)]


def test_replicas_and_regressors_hold_their_tables():
    each, means = parts(prediction.replicas(predicted().replicas), hv.Scatter)
    assert (rows_of(each), rows_of(means)) == ([(0, 1.0), (0, 1.5)], [(0, 0.9)])
    learnt, held_out = parts(prediction.regressors(predicted().regressors), hv.Points)
    assert (rows_of(learnt), rows_of(held_out)) == ([(1.0, 0)], [(2.0, 0)])
    (shown,) = parts(prediction.shown(predicted().regressors), hv.Points)
    assert rows_of(shown) == [(0.3, 0)]


def test_only_the_tables_that_were_made_are_drawn():
    picture = prediction.predictors(predicted(), "walk.c3d")
    assert [len(row) for row in picture.rows] == [2, 2, 2, 1, 2]
    assert "seed 9" in picture.caption
    few = Predictors(600, 200.0, ("A:M1",), 9, replicas=predicted().replicas)
    assert [len(row) for row in prediction.predictors(few, "walk.c3d").rows] == [1]
