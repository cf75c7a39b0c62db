"""Repairs that learn from other takes, from a donor, from a segment, from a subspace."""

import numpy as np
import pytest

from markermend.errors import CannotRepair
from markermend.model import Span, Take
from markermend.repairing.eigenspace import map_rows, weighted_rows
from markermend.repairing.run import repair
from markermend.repairing.subspace import learn, smooth

SPAN = Span(110, 130)


def low_rank(n, rank, columns, seed=0):
    rng = np.random.default_rng(seed)
    return rng.normal(0, 50, (n, rank)) @ rng.normal(0, 1, (rank, columns))


def test_rows_of_the_learnt_space_are_completed_exactly():
    training = low_rank(200, 4, 18)
    missing = np.arange(18) < 3
    rows = training[:20].copy()
    rows[:, missing] = np.nan
    found = map_rows(training[20:], rows, missing, 1 - 1e-12)
    np.testing.assert_allclose(found[:, missing], training[:20, missing], atol=1e-5)


@pytest.mark.parametrize("candidates", [1, 3])
def test_columns_of_the_learnt_space_are_completed_exactly(candidates):
    training = low_rank(80, 4, 300)
    missing = (np.arange(80) >= 30) & (np.arange(80) < 50)
    column = training[:, :3].copy()
    weights = [np.ones(80), *(np.exp(-np.abs(np.arange(80) - 40) / s) for s in (10, 20))]
    found = weighted_rows(training[:, 3:], column, missing, [1, 2, 4], weights[:candidates])
    np.testing.assert_allclose(found, training[:, :3], atol=1e-5)


@pytest.mark.parametrize("name", ["li_eq4", "li_eq8", "li_eq16"])
class TestTrainingSet:
    def test_is_used(self, name, lab):
        given = lab.case("gap")
        first, taught = (
            repair(given.take, given.marker, SPAN, name, training=training).values
            for training in (given.training[:1], given.training)
        )
        assert not np.array_equal(first, taught)
        assert np.linalg.norm(taught - given.truth, axis=1).mean() < 30

    def test_that_lacks_labels_is_refused_by_their_names(self, name, lab):
        given = lab.case("gap")
        poor = Take(lab.walker(seed=2)[:, [0, 1, 2, 3, 4, 5]], lab.RATE, lab.LABELS[:6])
        with pytest.raises(CannotRepair, match=r"lacks KNEE_C, KNEE_D; give takes with the same"):
            repair(given.take, given.marker, SPAN, name, training=[poor])

    def test_of_another_rate_is_refused(self, name, lab):
        given = lab.case("gap")
        other = Take(lab.walker(seed=2), 50.0, lab.LABELS)
        with pytest.raises(CannotRepair, match="at 50 Hz, and this one 3 at 100 Hz"):
            repair(given.take, given.marker, SPAN, name, training=[other])


def test_a_blackout_is_bridged_from_other_takes(lab):
    """Everything is hidden: postures cannot help, learnt trajectories can."""
    truth = lab.walker()
    spoilt = truth.copy()
    spoilt[SPAN.frames] = np.nan
    take = Take(spoilt, lab.RATE, lab.LABELS)
    training = [Take(lab.walker(1000, seed=s), lab.RATE, lab.LABELS) for s in (2, 3)]
    with pytest.raises(CannotRepair, match="choose a method that needs none"):
        repair(take, "KNEE_B", SPAN, "li_eq4", training=training)
    for name in ("li_eq8", "li_eq16"):
        found = repair(take, "KNEE_B", SPAN, name, training=training).values
        straight = repair(take, "KNEE_B", SPAN, "linear").values
        error, chord = (
            np.linalg.norm(x - truth[SPAN.frames, 5], axis=1).mean() for x in (found, straight)
        )
        assert error < 0.5 * chord


def test_the_smoother_reads_hidden_columns_off_the_others():
    time = np.arange(300) / 50.0
    waves = np.column_stack([np.sin(time * k + k) for k in (1, 2, 3)]) * 100
    data = waves @ np.random.default_rng(1).normal(0, 1, (3, 12))
    model = learn(data, 3, 0.999999)
    hidden = data.copy()
    hidden[120:160, :3] = np.nan
    assert np.abs(smooth(model, hidden) - data).max() < 1.0
    hidden[130:150] = np.nan
    blind = np.abs(smooth(model, hidden) - data)
    assert blind[:125].max() < 1.0
    assert np.isfinite(blind).all()


def test_the_donor_is_named_and_can_be_changed(lab):
    given = lab.case("gap")
    notes = [repair(given.take, given.marker, SPAN, "pattern", donor=d).note for d in (1, 2, 7, 50)]
    assert notes[0] != notes[1]
    assert notes[0] in {f"The donor is KNEE_{x}." for x in "ACD"}
    assert notes[2] == notes[3]


def test_a_donor_that_moves_in_parallel_gives_the_truth(lab):
    path = lab.walker(noise=0)[:, :1]
    truth = np.concatenate([path, path + np.array([0, 50.0, 10.0]), lab.walker(seed=4)], axis=1)
    spoilt = truth.copy()
    spoilt[SPAN.frames, 0] = np.nan
    take = Take(spoilt, lab.RATE, ["A", "TWIN", *lab.LABELS])
    done = repair(take, "A", SPAN, "pattern")
    assert done.note == "The donor is TWIN."
    np.testing.assert_allclose(done.values, truth[SPAN.frames, 0], atol=1e-9)


@pytest.mark.parametrize(("name", "within"), [("rigid", 3.0), ("kinematic", 1e-6)])
def test_a_segment_carries_its_marker(name, within, lab):
    """Exactly, where all that carry it are of the segment; a fourth marker is not."""
    truth = lab.walker(noise=0)
    spoilt = truth.copy()
    spoilt[60:160, 5] = np.nan
    found = repair(Take(spoilt, lab.RATE, lab.LABELS), "KNEE_B", Span(60, 160), name).values
    np.testing.assert_allclose(found, truth[60:160, 5], atol=within)


@pytest.mark.parametrize("name", ["polynomial", "ffnn"])
def test_predictors_are_seeded_and_near(name, lab):
    given = lab.case("gap", truth=lab.walker(600), span=Span(300, 320))
    error = np.linalg.norm(given.solve(name) - given.truth, axis=1).mean()
    assert error < 8.0
    if name == "ffnn":
        assert not np.array_equal(given.solve(name, seed=1), given.solve(name, seed=2))
