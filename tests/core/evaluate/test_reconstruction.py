"""Experiment E3 on a small take: perfect spans mend, the figures hang together."""

import numpy as np
import pytest

import markermend as mm
from markermend.errors import BadInput, UnknownName
from markermend.evaluate.reconstruction import e3


@pytest.fixture(scope="module")
def take() -> mm.Take:
    """Ten markers of one stiff body that swings, without noise."""
    rng = np.random.default_rng(3)
    t = np.arange(800) / 100
    path = np.column_stack([200 * np.sin(t), 150 * np.cos(0.7 * t), 900 + 30 * np.sin(2 * t)])
    return mm.Take(path[:, None] + rng.normal(0, 100, (10, 3)), 100, [f"M{i}" for i in range(10)])


def test_perfect_spans_and_exact_methods_leave_nothing(take: mm.Take):
    result = e3(
        take, methods=("rigid", "unstep"), shares=(0.1,), kinds=("step",), simulations=2,
        detector="published",
    )  # fmt: skip
    for cell in result.cells:
        if cell.spans == "perfect":
            assert cell.in_span_mm < 1e-2 * 10, cell
            assert cell.rmse_mm < cell.distorted_mm / 20


def test_error_over_everything_is_error_in_the_spans(take: mm.Take):
    undone = e3(
        take, methods=("unslow",), shares=(0.1,), kinds=("peak",), simulations=3,
        detector="published",
    ).cells[0]  # fmt: skip
    assert undone.refused == undone.repaired, "a single frame is no hill"
    share = np.sqrt(0.1 / (3 * take.n_markers))
    assert undone.rmse_mm == pytest.approx(undone.in_span_mm * share, rel=0.15)


def test_seeded(take: mm.Take):
    def run() -> dict[str, object]:
        return e3(
            take, methods=("linear",), shares=(0.05,), kinds=("peak",), simulations=2,
            detector="published",
        ).to_json()  # fmt: skip

    assert run() == run()


def test_refusals(take: mm.Take):
    with pytest.raises(UnknownName):
        e3(take, methods=("magic",), detector="published")
    with pytest.raises(BadInput):
        e3(take, simulations=0, detector="published")
    with pytest.raises(BadInput):
        e3(take, methods=("leave",), detector="published")
