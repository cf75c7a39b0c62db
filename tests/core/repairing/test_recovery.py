"""LI, LPR, LGRNN, GLR, PMA and weighted PCA: laws, examples, and the authors' own programs."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from markermend.errors import CannotRepair
from markermend.evaluate.masks import against, evaluate_masks, read_peers
from markermend.model import Span, Take
from markermend.repairing.run import repair
from markermend.repairing.smoothing import odd_width, smooth_runs
from markermend.repairing.triads import keep_distances

FAMILY = {
    "li": "LI", "lpr": "LPR", "lgrnn": "LGRNN", "glr": "GLR", "pma": "PMA", "wpca": "WPCA_R2",
}  # fmt: skip


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 1000), st.sampled_from([3, 5, 7, 9]), st.integers(1, 40))
def test_smoothing_has_no_direction_and_keeps_lines_and_gaps(seed, width, n):
    rng = np.random.default_rng(seed)
    values = rng.normal(0, 10, (n, 2))
    values[rng.random(n) < 0.1] = np.nan
    smooth = smooth_runs(values, width)
    np.testing.assert_array_equal(np.isnan(smooth), np.isnan(values))
    np.testing.assert_allclose(smooth_runs(values[::-1], width)[::-1], smooth)
    line = np.where(np.isnan(values), np.nan, np.arange(n)[:, None] * [2.0, -1.0])
    np.testing.assert_allclose(smooth_runs(line, width), line)


@pytest.mark.parametrize(("rate", "width"), [(50, 3), (100, 7), (120, 9), (60, 5), (250, 17)])
def test_the_window_is_odd_at_every_rate(rate, width):
    assert odd_width(0.07, rate) == width


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 1000))
def test_distances_are_pulled_into_what_is_usual_and_no_further(seed):
    rng = np.random.default_rng(seed)
    references = rng.normal(0, 100, (5, 3, 3))
    usual = np.sort(rng.uniform(20, 300, (2, 3)), axis=0)
    points = rng.normal(0, 100, (5, 3))
    pulled = keep_distances(points, references, usual)
    nearest = np.linalg.norm(pulled - references[:, 0], axis=1)
    assert (nearest > usual[0, 0] - 1e-6).all()
    assert (nearest < usual[1, 0] + 1e-6).all()
    wide = np.array([[0.0] * 3, [1e6] * 3])
    np.testing.assert_allclose(keep_distances(points, references, wide), points)


@pytest.mark.parametrize("name", ["li", "lpr", "lgrnn", "glr"])
def test_a_rigid_body_is_followed_exactly(name, lab):
    truth = lab.walker(noise=0)[:, :4]
    spoilt = truth.copy()
    spoilt[100:140, 0] = np.nan
    take = Take(spoilt, lab.RATE, lab.LABELS[:4])
    found = repair(take, "HIP_A", Span(100, 140), name, smoothing=0, quantile=0).values
    assert np.abs(found - truth[100:140, 0]).max() < 0.5


@pytest.mark.parametrize("name", ["li", "lpr", "lgrnn", "glr", "pma"])
def test_both_edges_are_met(name, lab):
    truth = lab.walker(noise=0)
    spoilt = truth.copy()
    spoilt[100:160, 5] = np.nan
    take = Take(spoilt, lab.RATE, lab.LABELS)
    found = repair(take, "KNEE_B", Span(100, 160), name, quantile=0).values
    step = np.linalg.norm(np.diff(truth[95:165, 5], axis=0), axis=1).max()
    assert np.linalg.norm(found[0] - truth[99, 5]) < 1.5 * step
    assert np.linalg.norm(found[-1] - truth[160, 5]) < 1.5 * step


def test_averaging_follows_the_model_whose_distances_are_usual(lab):
    """PMA is no worse than twice the best of its members."""
    given = lab.case("gap", truth=lab.walker(600), span=Span(280, 340))
    errors = {
        name: np.linalg.norm(given.solve(name) - given.truth, axis=1).mean() for name in FAMILY
    }
    assert errors["pma"] < 2 * min(errors.values())


def test_components_fill_what_others_determine(lab):
    """A marker that is a mixture of others is found although it is rigid with none."""
    rng = np.random.default_rng(0)
    base = rng.normal(0, 50, (300, 2)).cumsum(axis=0) / 10
    mix = rng.normal(0, 1, (2, 6 * 3))
    truth = (base @ mix).reshape(300, 6, 3) + rng.normal(0, 300, (6, 3))
    spoilt = truth.copy()
    spoilt[100:150, 2] = np.nan
    take = Take(spoilt, 100.0, list("ABCDEF"))
    for name in ("wpca", "pca_r1"):
        found = repair(
            take, "C", Span(100, 150), name, sigma=2000, own_weight=0.001, cumulative=0.9999
        ).values
        assert np.abs(found - truth[100:150, 2]).max() < 0.1


def test_gapped_neighbours_help_r2_and_not_r1(lab):
    truth = lab.walker()
    spoilt = truth.copy()
    spoilt[100:140, 5] = np.nan
    spoilt[:, 6][::2] = np.nan
    spoilt[:, 7][1::2] = np.nan
    take = Take(spoilt, lab.RATE, lab.LABELS)
    with pytest.raises(CannotRepair, match="choose a method that looks at a few neighbours"):
        repair(take, "KNEE_B", Span(100, 140), "pca_r1")
    found = repair(take, "KNEE_B", Span(100, 140), "wpca").values
    assert np.linalg.norm(found - truth[100:140, 5], axis=1).mean() < 60


@pytest.mark.parametrize("name", FAMILY)
def test_the_errors_are_those_of_the_programs_re_implemented(name, shared):
    """Protocol T, a part of one short recording: 20 gaps of 50 frames.

    Longer recordings are looked at in part, so that single gaps differ.
    """
    folder = shared / "protocols" / "gapfill"
    peers = read_peers(folder / "peers_per_gap.csv")[FAMILY[name]]
    errors = evaluate_masks(
        folder / "masks_T.json", [name], datasets=["cmu_85_02"], lengths=[50],
        seeds=[0, 1, 2, 3],
    )  # fmt: skip
    n, ours, theirs = against(errors, peers)
    assert n == 20
    assert ours == pytest.approx(theirs, rel=0.12)


def test_smoothing_keeps_what_is_many_powers_of_ten_smaller():
    """Weights of models are densities: some hundred powers of ten lie between two frames."""
    values = np.ones((60, 1))
    values[20:] = 1e-200
    smooth = smooth_runs(values, 7)
    np.testing.assert_allclose(smooth[30:], 1e-200, rtol=1e-12)
    assert (smooth > 0).all()
