"""The experiment of Kamali et al. on a take that meets its premise exactly."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import wilcoxon

import markermend as mm
from markermend.errors import BadInput, UnknownName
from markermend.evaluate.cycles import cycle_of
from markermend.evaluate.hiding import spread_markers
from markermend.evaluate.kamali import Kamali, complete, draw_gaps, kamali
from markermend.evaluate.kamali_splits import splits
from markermend.model import Span

RATE, CYCLE_S, MARKERS = 50.0, 1.2, 8


def gait(noise: float = 0.0, seconds: float = 6.0) -> mm.Take:
    """Eight markers that repeat every 1.2 s, with three harmonics of shared frequencies."""
    rng = np.random.default_rng(5)
    t = np.arange(round(seconds * RATE)) / RATE
    waves = [f(2 * np.pi * k * t / CYCLE_S) for k in (1, 2, 3) for f in (np.sin, np.cos)]
    size = np.repeat([200.0, 60.0, 20.0], 2)[:, None] * rng.normal(0, 1, (6, MARKERS * 3))
    place = rng.uniform(-500, 500, MARKERS * 3)
    positions = place + np.stack(waves, axis=1) @ size + rng.normal(0, noise, (len(t), MARKERS * 3))
    labels = [f"M{i}" for i in range(MARKERS)]
    return mm.Take(positions.reshape(len(t), MARKERS, 3), RATE, labels)


def run(take: mm.Take, jobs: int = 1, seed: int = 0, masks: int = 2) -> Kamali:
    return kamali(
        {"gait": take}, markers=(MARKERS,), methods=("gslr", "slr", "svt", "spline"),
        weights=(0.01, 1.0), masks=masks, sweep_masks=1, cycles=3, jobs=jobs, seed=seed,
    )  # fmt: skip


@pytest.fixture(scope="module")
def result() -> Kamali:
    return run(gait(0.5))


def test_cycle_is_found_and_exact_repetition_has_likeness_1():
    cycle = cycle_of(gait())
    assert cycle.seconds == pytest.approx(CYCLE_S, abs=1.01 / RATE)
    assert cycle.likeness == pytest.approx(1.0, abs=1e-9)
    assert cycle_of(gait(), 0.6).likeness < 0.5, "half a cycle later it is not alike"


def test_no_cycle_is_made_up():
    t = np.linspace(0, 1, 400)[:, None, None]
    straight = mm.Take(t * np.arange(12).reshape(1, 4, 3) ** 2.0, 100, list("abcd"))
    with pytest.raises(BadInput, match="repeats"):
        cycle_of(straight)


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 2**31))
def test_gaps_are_those_of_the_paper(seed: int):
    take, cycle = gait(), CYCLE_S * RATE
    gaps = draw_gaps(take, cycle, np.random.default_rng(seed))
    assert 5 <= len(gaps) <= 20
    for marker, span in gaps:
        assert 0.1 * cycle - 0.5 <= len(span) <= 0.5 * cycle + 0.5
        assert 0 < span.start < span.stop < take.n_frames
        assert sum(m == marker and s.overlaps(span) for m, s in gaps) == 1


@pytest.mark.parametrize("method", ["gslr", "slr", "svt"])
def test_whole_matrix_is_completed_where_the_premise_holds(method: str):
    take = gait(seconds=4.8)
    gaps = [(m, Span(40 + 20 * m, 60 + 20 * m)) for m in range(3)]
    positions = take.positions.copy()
    for marker, span in gaps:
        positions[span.frames, marker] = np.nan
    fills, converged = complete(take.with_positions(positions), gaps, method, 0.01)
    off = [
        np.linalg.norm(fill - take.positions[span.frames, marker], axis=1).mean()
        for fill, (marker, span) in zip(fills, gaps, strict=True)
    ]
    assert converged
    assert max(off) < 3.0, "of movements of some 400 mm"


def test_figures_hang_together(result: Kamali):
    cells = {cell.method: cell for cell in result.cells}
    for cell in cells.values():
        known = np.array(cell.masks_mm, float)
        assert cell.mean_mm == pytest.approx(known.mean())
        assert cell.sd_mm == pytest.approx(known.std())
        assert cell.rmse_mm is not None
        assert cell.refused == cell.unconverged == 0
    for pair in result.pairs:
        off = np.subtract(cells[pair.first].masks_mm, cells[pair.second].masks_mm)
        assert pair.difference_mm == pytest.approx(off.mean())
        assert pair.p == pytest.approx(wilcoxon(off).pvalue)
        assert pair.holds == (off.mean() < 0 and wilcoxon(off).pvalue < 0.05)
    order = result.orderings[0]
    means = [cells[name].mean_mm for name in order.best_first]
    assert means == sorted(means)
    assert cells["gslr"].mean_mm < cells["spline"].mean_mm / 5


def test_the_classes_hold_all_gaps(result: Kamali):
    for cell in result.cells:
        for by in ("gaps", "share"):
            some = [s for s in result.splits if (s.method, s.by) == (cell.method, by)]
            assert sum(split.n for split in some) == cell.gaps
            assert all((split.mean_mm is None) == (split.n == 0) for split in some)
    for by in ("gaps", "share"):
        bounds = [(s.low, s.high) for s in result.splits if (s.method, s.by) == ("svt", by)]
        assert [low for low, _ in bounds[1:]] == [high for _, high in bounds[:-1]]


def test_an_error_counts_in_the_class_of_its_gap():
    errors = [np.array([1.0, 2.0, np.nan, 4.0, 5.0]), np.full(12, 7.0)]
    shares = [np.array([0.1, 0.15, 0.2, 0.3, 0.5]), np.full(12, 0.45)]
    found = {s.name: (s.n, s.mean_mm) for s in splits("walk", 11, "svt", errors, shares)}
    assert found == {
        "5 to 9 gaps": (4, 3.0),
        "10 to 14 gaps": (12, 7.0),
        "15 to 20 gaps": (0, None),
        "10% to 20%": (2, 1.5),
        "20% to 30%": (0, None),
        "30% to 40%": (1, 4.0),
        "40% to 50%": (13, pytest.approx(89 / 13)),
    }


def test_best_weight_of_the_sweep_goes_on(result: Kamali):
    for name in ("gslr", "slr"):
        points = [point for point in result.sweep if point.method == name]
        best = min(points, key=lambda point: point.mean_mm)
        assert [c.weight for c in result.cells if c.method == name] == [best.weight]
    assert len({point.mean_mm for point in result.sweep}) > 1, "lambda makes a difference"


def test_seeded_and_the_same_for_any_number_of_processes(result: Kamali):
    assert run(gait(0.5), jobs=2).to_json() == result.to_json()
    other = run(gait(0.5), seed=1, masks=1)
    assert {c.masks_mm[0] for c in other.cells}.isdisjoint(c.masks_mm[0] for c in result.cells)


def test_markers_are_spread():
    take = gait()
    some = spread_markers(take, 4)
    assert len(set(some)) == 4
    assert [take.index(label) for label in some] == sorted(take.index(label) for label in some)
    rng = np.random.default_rng(0)
    corners = np.array([[0, 0, 0], [900, 0, 0], [0, 900, 0], [0, 0, 900]], float)
    points = np.concatenate([corners, corners[1:] + 10])
    still = np.tile(points, (60, 1, 1)) + rng.normal(0, 1, (60, 7, 3))
    twins = mm.Take(still, 100, list("oxyzXYZ"))
    assert {label.lower() for label in spread_markers(twins, 4)} == set("oxyz")


def test_refusals():
    with pytest.raises(BadInput, match="markers are seen"):
        kamali({"gait": gait()}, markers=(37,))
    with pytest.raises(UnknownName):
        kamali({"gait": gait()}, markers=(MARKERS,), methods=("magic",))
    with pytest.raises(BadInput, match="Nothing"):
        kamali({}, markers=(MARKERS,))
    with pytest.raises(BadInput, match="twice"):
        kamali({"gait": gait(seconds=3.0)}, markers=(MARKERS,), cycle_s=1.6)
