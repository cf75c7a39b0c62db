"""The pictures of the recovery of gaps show the numbers of their tables."""

from dataclasses import replace
from typing import Any

import holoviews as hv
import numpy as np
import pytest

from markermend.evaluate.kamali_splits import Split
from markermend.evaluate.kamali_tables import Cell, Kamali, Point
from markermend.evaluate.li_tables import Li, Row
from markermend_app.plots import completion, gait
from markermend_app.plots.picture import html

from .test_plots import parts, rows_of

ROW = Row(
    figure="Blackouts",
    dims=3,
    given="pieces",
    setting="5 % (0.10 s)",
    x=0.05,
    method="auto",
    gaps=10,
    refused=0,
    mean=2.0,
    sd=0.5,
    rmse=2.5,
    first=1.0,
    middle=2.0,
    last=1.0,
    pieces=(1.5, 2.5),
    markers={},
)
LONGER = replace(ROW, setting="40 % (0.80 s)", x=0.4, mean=30.0)
SPLINE = (replace(ROW, method="spline", mean=3.0), replace(LONGER, method="spline", mean=90.0))
CELL = Cell(
    take="walk",
    markers=11,
    method="gslr",
    weight=0.1,
    mean_mm=4.0,
    sd_mm=1.0,
    median_mm=3.0,
    rmse_mm=5.0,
    gaps=30,
    refused=0,
    unconverged=2,
    masks_mm=(2.0, 3.0, 7.0),
)
POINT = Point("walk", 11, "gslr", 0.0, 5, 9.0, 1.0)


def li_of(*rows: Row, projected: str = "") -> Li:
    return Li(7, 50.0, 2, 200, (), (), projected, rows, (), (), ())


def kamali_of(cells: tuple[Cell, ...], sweep: tuple[Point, ...] = ()) -> Kamali:
    return Kamali(4, 3, {}, {}, {}, cells, (), sweep, (), (), ())


def ticks(element: Any, axis: str) -> list[tuple[float, str]]:
    given: list[tuple[float, str]] = element.opts.get("plot", backend="bokeh").kwargs[axis]
    return given


def dotted(element: Any) -> tuple[list[Any], list[Any]]:
    """Give the points that are filled, and those that are hollow."""
    dots = [p for p in parts(element, hv.Points) if p.label != "mask"]
    return (
        [row for part in dots[::2] for row in rows_of(part)],
        [row for part in dots[1::2] for row in rows_of(part)],
    )


def test_li_has_a_curve_a_method_over_the_lengths_of_the_blackout():
    element = completion.li(li_of(LONGER, ROW, *SPLINE), "walk.c3d").panels[0].element
    curves = {curve.label: rows_of(curve) for curve in parts(element, hv.Curve)}
    assert curves == {"auto": [(0.05, 2.0), (0.4, 30.0)], "spline": [(0.05, 3.0), (0.4, 90.0)]}
    assert ticks(element, "xticks") == [(0.05, "5 %\n(0.10 s)"), (0.4, "40 %\n(0.80 s)")]
    (names,) = parts(element, hv.Labels)
    assert [(round(y, 6), name) for _, y, name in rows_of(names)] == [
        (30.0, "auto"),
        (90.0, "spline"),
    ]


def test_li_shows_refusals_as_hollow_points_and_leaves_out_what_none_filled():
    part = replace(ROW, method="li", refused=3)
    none = replace(LONGER, method="li", refused=10, mean=None, sd=None, rmse=None)
    never = [replace(row, method="pma", mean=None, refused=10) for row in (ROW, LONGER)]
    element = completion.by_condition([ROW, LONGER, part, none, *never], looks("li", "pma"))
    filled, hollow = dotted(element)
    assert (filled, hollow) == ([(0.05, 2.0), (0.4, 30.0)], [(0.05, 2.0)])
    assert {curve.label for curve in parts(element, hv.Curve)} == {"auto", "li"}


def test_a_table_with_one_condition_lies_with_its_errors_by_method():
    element = completion.by_condition([ROW, SPLINE[0]], looks("spline"))
    assert dotted(element) == ([(2.0, 0), (3.0, 1)], [])
    assert ticks(element, "yticks") == [(0, "auto"), (1, "spline")]


def test_a_table_where_nothing_was_filled_is_drawn_empty():
    none = [replace(row, mean=None, refused=10) for row in (ROW, LONGER)]
    assert dotted(completion.by_condition(none, looks())) == ([], [])
    html(completion.li(li_of(*none), "walk.c3d"))


def test_li_has_a_panel_a_table_and_says_what_it_is_of():
    flat = [replace(row, dims=2) for row in (ROW, LONGER)]
    picture = completion.li(li_of(ROW, LONGER, *flat, projected="a camera"), "walk.c3d")
    assert [panel.title.splitlines()[0] for panel in picture.panels] == [
        "Blackouts, 3D",
        "Blackouts, 2D",
    ]
    units = [p.element.opts.get("plot", backend="bokeh").kwargs["ylabel"] for p in picture.panels]
    assert units == ["error, mm", "error, px"]
    for words in ("n = 2 pieces of 200 frames at 50 Hz, seed 7", "Two dimensions: a camera."):
        assert words in picture.caption
    assert "walk.c3d" in picture.title


def looks(*others: str) -> dict[str, completion.Style]:
    return completion.styles(["auto", *others])


def test_no_two_of_the_methods_look_alike():
    look = looks(*(f"method {i}" for i in range(20)))
    assert len({(one["color"], one["line_dash"]) for one in look.values()}) == 21


@pytest.mark.parametrize("values", [(1.0, 1.01, 1.02, 50.0), (9.9,) * 6, (1.0, 9.0, 9.9), ()])
def test_names_stand_apart_in_order_and_inside(values: tuple[float, ...]):
    places = np.log(completion.apart([(v, 0.0, "") for v in values], (0.9, 60.0)))
    step = completion.LINE / completion.HEIGHT * np.log(60.0 / 0.9)
    assert (np.diff(places) > 0.999 * step).all()
    assert ((places > np.log(0.9)) & (places < np.log(60.0))).all()


def test_kamali_has_every_mask_with_mean_and_median_by_method():
    none = replace(CELL, method="tnn", weight=None, mean_mm=None, sd_mm=None, median_mm=None)
    none = replace(none, rmse_mm=None, refused=30, unconverged=0, masks_mm=(None,) * 3)
    element = gait.kamali(kamali_of((CELL, none))).panels[0].element
    (masks,) = (part for part in parts(element, hv.Points) if part.label == "mask")
    assert rows_of(masks) == [(2.0, 0), (3.0, 0), (7.0, 0)]
    assert dotted(element) == ([(4.0, 0)], [])
    (median,) = parts(element, hv.Segments)
    assert [(x, to) for x, _, to, _ in rows_of(median)] == [(3.0, 3.0)]
    assert [name for _, name in ticks(element, "yticks")] == [
        "gslr (λ 0.1, 2 unconverged)",
        "tnn (30 refused)",
    ]


def test_kamali_sweeps_lambda_from_nought_with_its_spread():
    more = replace(POINT, weight=0.1, mean_mm=5.0, sd_mm=6.0)
    other = replace(POINT, method="slr", mean_mm=8.0)
    element = gait.by_weight([more, POINT, other])
    curves = {curve.label: rows_of(curve) for curve in parts(element, hv.Curve)}
    assert curves == {"gslr": [(0, 9.0), (1, 5.0)], "slr": [(0, 8.0)]}
    spread, _ = parts(element, hv.Segments)
    assert [row[1::2] for row in rows_of(spread)] == [(8.0, 10.0), (pytest.approx(5 / 1.4), 11.0)]
    assert [name for _, name in ticks(element, "xticks")] == ["0", "0.1"]


def test_kamali_has_a_row_a_take_and_set_of_markers():
    cells = (CELL, replace(CELL, markers=37), replace(CELL, take="run"))
    picture = gait.kamali(kamali_of(cells, (POINT,)))
    assert [len(row) for row in picture.rows] == [2, 1, 1]
    classes = [Split("run", 11, "gslr", by, 5.0, 10.0, 7, 2.0) for by in ("gaps", "share")]
    picture = gait.kamali(replace(kamali_of(cells, (POINT,)), splits=tuple(classes)))
    assert [len(row) for row in picture.rows] == [2, 1, 3]
    assert [panel.title.splitlines()[0] for panel in picture.rows[2][1:]] == [
        "By the gaps in a mask",
        "By a gap's share of a cycle",
    ]
    assert [row[0].title.splitlines()[0] for row in picture.rows] == [
        "walk, 11 markers",
        "walk, 37 markers",
        "run, 11 markers",
    ]
    assert "n = 3 masks, seed 4" in picture.caption
    assert "n = 5 masks of their own" in picture.rows[0][1].title
