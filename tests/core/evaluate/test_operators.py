"""Experiment E2."""

import json
from dataclasses import replace

import numpy as np
import pytest

from markermend.errors import BadInput, UnknownName
from markermend.evaluate.operators import Operator, Verdicts, e2, judge
from markermend.model import Finding, Span, Take

PERFECT = Operator("perfect", 1.0, 0.0, "")
IDLE = Operator("idle", 0.0, 0.0, "linear")
HARMFUL = Operator("harmful", 0.0, 40.0, "linear")


def body(n_frames=500):
    """Six markers of one rigid body."""
    rng = np.random.default_rng(0)
    t = np.arange(n_frames)[:, None, None] / 100.0
    base = 200 * np.sin(t * np.array([2.1, 1.7, 2.4]))
    return Take(base + rng.normal(0, 150, (6, 3)), 100.0, [f"m{i}" for i in range(6)])


def test_judge_by_hand():
    reference = body()
    positions = reference.positions.copy()
    positions[100:120, 2, 0] += 10.0
    positions[125:130, 2, 0] += 10.0  # ten frames apart at most: the same error
    positions[300:310, 4, 1] += 10.0
    positions[480:490, 4, 1] += 2.0  # within tolerance
    version = reference.with_positions(positions)
    found = [
        Finding("m2", Span(118, 121), "peak"),
        Finding("m4", Span(480, 490), "slow"),
        Finding("m0", Span(0, 5), "gap"),
    ]
    assert judge(version, reference, found) == Verdicts(approved=1, rejected=1, missed=1)
    assert judge(version, reference, []) == Verdicts(0, 0, 2)
    assert judge(reference, reference, found[:1]) == Verdicts(0, 1, 0)


def test_judge_refuses_another_take():
    with pytest.raises(BadInput, match="other frames or markers"):
        judge(body(100), body(200), [])


@pytest.fixture(scope="module")
def comparison():
    return e2(body(), operators=[PERFECT, IDLE, HARMFUL], detector="published", seed=3)


def test_skill_shows_in_the_rows(comparison):
    none, perfect, idle, harmful = comparison.rows
    assert [row.operator for row in comparison.rows] == ["none", "perfect", "idle", "harmful"]
    assert replace(idle, operator="none", human=none.human) == none
    assert idle.human == 0
    # Nothing is left of what was brought back, so nothing can be approved or missed.
    assert perfect.human == none.human
    assert (perfect.approved, perfect.missed) == (0, 0)
    assert none.approved > 0
    # Whoever straightens what was right makes errors that were not there.
    assert harmful.approved + harmful.missed > none.approved + none.missed


def test_same_with_any_number_of_jobs(comparison):
    settings = {"operators": [PERFECT], "detector": "published", "simulations": 2, "seed": 3}
    alone, two = e2(body(), **settings), e2(body(), jobs=2, **settings)
    assert alone == two
    assert json.loads(json.dumps(two.to_json(), allow_nan=False))["experiment"] == "e2"
    columns, rows = two.table()
    assert {len(row) for row in rows} == {len(columns)}


def test_refusals():
    with pytest.raises(UnknownName, match="'glue'"):
        e2(body(), operators=[replace(IDLE, method="glue")])
    with pytest.raises(UnknownName, match="'guess'"):
        e2(body(), detector="guess")
    with pytest.raises(BadInput, match="simulations"):
        e2(body(), simulations=0)
