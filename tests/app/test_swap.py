"""A swap as a what-if: both markers exchanged, lengths before and after, one deed for both."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

import markermend as mm
from markermend.model import Finding, Span
from markermend.review import AddFinding
from markermend_app.state import curves
from markermend_app.state.desk import Desk
from markermend_app.state.intents import perform
from markermend_app.views import repairs as table

from .conftest import Ticks, made_take, settle

MakeDesk = Callable[..., tuple[Desk, Ticks]]
SPAN = Span(300, 340)


def test_both_markers_are_shown_and_swapped_back(make_desk: MakeDesk, take_path: Path):
    made = made_take()
    exchanged = made.positions.copy()
    exchanged[SPAN.frames, [0, 1]] = made.positions[SPAN.frames, [1, 0]]
    take_path.unlink()
    mm.write(mm.Take(exchanged, made.rate, made.labels), take_path)
    desk, ticks = make_desk()
    take = desk.opened.take
    desk.do(AddFinding((Finding("M0", SPAN, "step", partner="M1", amplitude=80.0),)))
    desk.select(next(f for f in desk.findings if f.span == SPAN and f.partner))
    settle(desk, ticks)
    perform(desk, "choose", "swap")

    assert desk.signal == "distance"
    lanes, repairs = curves.lanes(desk), curves.repairs(desk)
    inside = lanes.evidence.time * take.rate
    inside = (inside > SPAN.start - 0.5) & (inside < SPAN.stop - 0.5)
    assert np.nanmax(repairs.after.values) < 3 < np.nanmin(lanes.evidence.signal[inside])
    at = np.round(lanes.partner.time * take.rate).astype(int)
    np.testing.assert_allclose(lanes.partner.values, take.positions[at, take.index("M1")])
    np.testing.assert_allclose(
        repairs.chosen.values[1:-1], made.positions[SPAN.frames, 0], atol=1e-3
    )
    np.testing.assert_allclose(repairs.also.values[1:-1], made.positions[SPAN.frames, 1], atol=1e-3)
    assert "Swap M0 and M1 back" in table.verdict(desk)

    perform(desk, "accept")
    perform(desk, "export")
    settle(desk, ticks)
    mended = desk.plan.mended.repaired.positions
    np.testing.assert_allclose(mended[:, :2], made.positions[:, :2], atol=1e-3)
