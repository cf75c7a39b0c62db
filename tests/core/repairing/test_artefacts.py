"""Repairs that undo what happened: join, swap, unstep, unslow, and smoothing."""

import re

import numpy as np
import pytest

from markermend.errors import CannotRepair
from markermend.model import Span, Take
from markermend.repairing.continuity import jumps
from markermend.repairing.run import apply, repair

SPAN = Span(110, 130)


class TestJoin:
    def test_takes_the_fragment_and_names_the_evidence(self, lab):
        given = lab.case("gap")
        done = repair(given.take, given.marker, SPAN, "join")
        np.testing.assert_array_equal(done.values, given.truth)
        assert done.note.startswith("*1 goes on from KNEE_B within ")
        assert "keeps its distances within" in done.note

    def test_bridges_a_few_frames_that_the_fragment_lacks(self, lab):
        given = lab.case("gap")
        positions = given.take.positions.copy()
        fragment = given.take.index("*1")
        positions[110:112, fragment] = positions[129, fragment] = np.nan
        take = given.take.with_positions(positions)
        done = repair(take, given.marker, SPAN, "join")
        np.testing.assert_array_equal(done.values[2:-1], given.truth[2:-1])
        np.testing.assert_allclose(done.values, given.truth, atol=3)
        with pytest.raises(CannotRepair, match="None of 1 unlabelled fragments"):
            repair(take, given.marker, SPAN, "join", missing=1)

    @pytest.mark.parametrize("offset", [[40.0, 0, 0], [0, 0, -25.0]])
    def test_refuses_a_fragment_that_is_somebody_else(self, lab, offset):
        given = lab.case("gap")
        positions = given.take.positions.copy()
        positions[:, given.take.index("*1")] += offset
        with pytest.raises(CannotRepair, match="keeps its distances; choose another method"):
            repair(given.take.with_positions(positions), given.marker, SPAN, "join")

    def test_refuses_a_fragment_that_drifts_away_between_its_ends(self, lab):
        given = lab.case("gap")
        positions = given.take.positions.copy()
        positions[SPAN.frames, given.take.index("*1")] += 90 * np.hanning(20)[:, None]
        with pytest.raises(CannotRepair, match="keeps its distances"):
            repair(given.take.with_positions(positions), given.marker, SPAN, "join")

    def test_chooses_the_best_of_several(self, lab):
        given = lab.case("gap")
        right = given.take.positions[:, given.take.index("*1")]
        others = np.stack(
            [right + np.array([6.0, 0, 0]), right, right - np.array([0, 7.0, 0])], axis=1
        )
        take = Take(
            np.concatenate([given.take.positions[:, :8], others], axis=1),
            lab.RATE,
            (*lab.LABELS, "*1", "*2", "*3"),
        )
        assert repair(take, given.marker, SPAN, "join").note.startswith("*2 ")


class TestSwap:
    def test_finds_the_counterpart_and_gives_its_values_too(self, lab):
        given = lab.case("step", swapped=True)
        truth = lab.walker()
        for partner in (lab.PARTNER, None):
            done = repair(given.take, given.marker, SPAN, "swap", kind="step", partner=partner)
            ((other, values),) = done.also
            assert other == lab.PARTNER
            np.testing.assert_array_equal(done.values, given.truth)
            np.testing.assert_array_equal(values, truth[SPAN.frames, lab.LABELS.index(other)])
            np.testing.assert_array_equal(apply(given.take, [done]).positions, truth)

    def test_leaves_alone_what_is_not_exchanged(self, lab):
        take = Take(lab.walker(), lab.RATE, lab.LABELS)
        with pytest.raises(CannotRepair, match="No exchange of KNEE_B with another marker"):
            repair(take, lab.MARKER, SPAN, "swap", kind="step")
        with pytest.raises(CannotRepair, match="No exchange of KNEE_B with KNEE_C"):
            repair(take, lab.MARKER, SPAN, "swap", kind="step", partner=lab.PARTNER)


class TestUnstep:
    @pytest.mark.parametrize("height", [5.0, 25.0, 300.0])
    @pytest.mark.parametrize("axis", [0, 2])
    def test_finds_the_height_and_leaves_the_other_axes(self, lab, height, axis):
        truth = lab.walker()
        spoilt = truth.copy()
        spoilt[SPAN.frames, 5, axis] += height
        done = repair(Take(spoilt, lab.RATE, lab.LABELS), "KNEE_B", SPAN, "unstep", kind="step")
        rest = done.values - truth[SPAN.frames, 5]
        assert np.sqrt(np.square(rest).mean()) < 0.5
        kept = [a for a in range(3) if a != axis]
        np.testing.assert_array_equal(rest[:, kept], 0.0)
        assert np.ptp(rest, axis=0).max() < 1e-9

    def test_refuses_where_there_is_no_step(self, lab):
        truth = lab.walker()
        with pytest.raises(CannotRepair, match="is no step"):
            repair(Take(truth, lab.RATE, lab.LABELS), "KNEE_B", SPAN, "unstep", kind="step")
        truth[SPAN.frames, 5] += np.random.default_rng(0).normal(0, 20, (20, 3))
        with pytest.raises(CannotRepair, match="is no step"):
            repair(Take(truth, lab.RATE, lab.LABELS), "KNEE_B", SPAN, "unstep", kind="step")


class TestUnslow:
    @pytest.mark.parametrize("top", [30, 45])
    def test_finds_height_and_apex(self, lab, top):
        truth, span = lab.walker(400), Span(150, 226)
        at = np.arange(76)
        hill = np.minimum((at + 1) / (top + 1), (76 - at) / (76 - top))
        spoilt = truth.copy()
        spoilt[span.frames, 5, 1] += 20 * hill
        done = repair(Take(spoilt, lab.RATE, lab.LABELS), "KNEE_B", span, "unslow", kind="slow")
        rest = done.values - truth[span.frames, 5]
        assert np.sqrt(np.square(rest).sum(axis=1).mean()) < 0.5
        assert (rest[:, [0, 2]] == 0).all()
        found = int(re.search(r"apex (\d+) frames", done.note)[1])
        assert abs(found - top) <= 4

    def test_refuses_where_there_is_no_hill(self, lab):
        take = Take(lab.walker(400), lab.RATE, lab.LABELS)
        with pytest.raises(CannotRepair, match="no slow rise and fall"):
            repair(take, "KNEE_B", Span(150, 226), "unslow", kind="slow")

    def test_works_without_neighbours_on_calm_motion(self, lab):
        rng = np.random.default_rng(2)
        drift = np.cumsum(rng.normal(0, 0.05, (400, 1, 3)), axis=0)
        spoilt = drift.copy()
        spoilt[150:226, 0, 0] += 20 * np.minimum(np.arange(1, 77), np.arange(76, 0, -1)) / 38.5
        take = Take(spoilt, lab.RATE, ["A"])
        done = repair(take, "A", Span(150, 226), "unslow", kind="slow")
        assert np.abs(done.values - drift[150:226, 0]).max() < 2.0


class TestButterworth:
    def smooth(self, values, span, **parameters):
        positions = np.repeat(values[:, None, None], 3, axis=2)
        return repair(
            Take(positions, 100.0, ["A"]), "A", span, "butterworth", kind="noise", **parameters
        ).values[:, 0]

    @pytest.mark.parametrize("order", [1, 2, 4])
    def test_leaves_half_the_power_at_the_cutoff_and_does_not_lag(self, order):
        time = np.arange(2000) / 100.0
        for hertz, gain in ((8.0, 0.5**0.5), (0.2, 1.0)):
            wave = 10 * np.sin(2 * np.pi * hertz * time)
            found = self.smooth(wave, Span(900, 1100), cutoff=8.0, order=order)
            np.testing.assert_allclose(found, gain * wave[900:1100], atol=0.1)

    def test_refuses_gaps_and_cutoffs_beyond_the_rate(self):
        values = np.zeros(200)
        with pytest.raises(CannotRepair, match="not the 100 Hz"):
            self.smooth(values, Span(50, 60), cutoff=50.0)
        values[55] = np.nan
        with pytest.raises(CannotRepair, match="nothing to smooth"):
            self.smooth(values, Span(50, 60))


def test_jumps_are_measured_beyond_the_straight_continuation():
    line = np.arange(20.0)[:, None] * [1.0, 2.0, 0.0]
    span = Span(8, 12)
    assert jumps(line, line[span.frames], span) == pytest.approx((0, 0), abs=1e-12)
    assert jumps(line, line[span.frames] + [3.0, 0, 4.0], span) == pytest.approx((5, 5))
    line[12:] = np.nan
    assert jumps(line, line[span.frames], span)[1] == np.inf
