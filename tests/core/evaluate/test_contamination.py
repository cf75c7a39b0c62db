"""The contamination procedure (section 4.1.3)."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from markermend.errors import BadInput, UnknownName
from markermend.evaluate import contaminate
from markermend.model import Take


def still(n_frames=2000, n_markers=8, rate=100.0):
    return Take(np.zeros((n_frames, n_markers, 3)), rate, [f"m{i}" for i in range(n_markers)])


KINDS = st.lists(st.sampled_from(["peak", "noise", "step", "slow"]), min_size=1, unique=True)


@settings(max_examples=30, deadline=None)
@given(kinds=KINDS, share=st.floats(0.02, 0.2), seed=st.integers(0, 10**6))
def test_the_log_says_exactly_what_changed(kinds, share, seed):
    take = still()
    dirty, truths = contaminate(take, kinds, share=share, seed=seed)
    changed = np.zeros((take.n_frames, take.n_markers), bool)
    per_frame = np.zeros(take.n_frames, int)
    for truth in truths:
        changed[truth.span.frames, take.index(truth.marker)] = True
        per_frame[truth.span.frames] += 1
    assert not dirty.positions[~changed].any()
    assert per_frame.max() == 1  # one distortion at a time
    for kind in kinds:  # each kind takes the whole share
        assert sum(len(t.span) for t in truths if t.kind == kind) == round(share * take.n_frames)
    assert {truth.kind for truth in truths} == set(kinds)


def test_same_seed_same_result_and_another_another():
    first, log = contaminate(still(), seed=5)
    again, same = contaminate(still(), seed=5)
    other, different = contaminate(still(), seed=6)
    assert np.array_equal(first.positions, again.positions)
    assert log == same
    assert log != different
    assert not np.array_equal(first.positions, other.positions)


def test_it_adds_to_whatever_is_there():
    rng = np.random.default_rng(0)
    moving = still().with_positions(rng.normal(0, 100, (2000, 8, 3)))
    on_still, log = contaminate(still(), seed=9)
    on_moving, same = contaminate(moving, seed=9)
    assert log == same
    assert on_moving.positions - moving.positions == pytest.approx(on_still.positions, abs=1e-9)


def test_shapes():
    dirty, truths = contaminate(still(20000), seed=1)
    for truth in truths:
        m, a = dirty.index(truth.marker), "xyz".index(truth.axes[0])
        values = dirty.positions[truth.span.frames, m, a]
        if truth.kind in ("step", "peak"):
            assert values == pytest.approx(truth.sign * truth.amplitude)
        if truth.kind == "peak":
            assert len(truth.span) == 1
        if truth.kind == "slow":
            size = truth.sign * values
            assert (size > 0).all()
            assert size == pytest.approx(size[::-1])
            assert 0.95 * truth.amplitude <= size.max() <= truth.amplitude
            assert np.diff(size, 2).max() < 1e-9
        if truth.kind == "noise":
            assert values.std() == pytest.approx(truth.amplitude, rel=0.5)


def test_distributions():
    _, truths = contaminate(still(200_000), amplitude_mm=10, seed=2)
    size = np.array([t.sign * t.amplitude for t in truths])
    assert np.abs(size).mean() == pytest.approx(10, abs=0.3)
    assert np.abs(size).std() == pytest.approx(4, abs=0.3)
    assert (size > 0).mean() == pytest.approx(0.5, abs=0.03)
    lengths = np.array([len(t.span) for t in truths if t.kind != "peak"])
    assert lengths.mean() == pytest.approx(50, abs=1.5)
    assert lengths.std() == pytest.approx(50**0.5, abs=1.5)
    axes = [t.axes[0] for t in truths]
    assert min(axes.count(a) for a in "xyz") > 0.3 * len(axes)


def test_lengths_follow_the_rate():
    _, truths = contaminate(still(40_000, rate=200.0), ["step"], seed=2)
    assert np.mean([len(t.span) for t in truths]) == pytest.approx(100, abs=4)


def test_peaks_are_isolated_on_their_marker():
    _, truths = contaminate(still(), ["peak"], share=0.3, seed=0)
    places = {(t.marker, t.span.start) for t in truths}
    assert not any((marker, start + 1) in places for marker, start in places)


def test_gaps_stay_gaps_and_get_no_artefact():
    positions = np.zeros((2000, 3, 3))
    positions[:, 0] = np.nan
    positions[300:900, 1] = np.nan
    take = Take(positions, 100.0, list("abc"))
    dirty, truths = contaminate(take, seed=3)
    assert np.array_equal(dirty.seen, take.seen)
    assert all(take.seen[t.span.frames, take.index(t.marker)].all() for t in truths)
    assert truths


def test_all_axes_and_two_dimensions():
    dirty, truths = contaminate(still(), ["step"], axes="all", seed=1)
    values = dirty.positions[truths[0].span.frames, dirty.index(truths[0].marker)]
    assert values == pytest.approx(truths[0].sign * truths[0].amplitude)
    flat = Take(np.zeros((500, 3, 2)), 30.0, list("abc"), units="px")
    assert {t.axes[0] for t in contaminate(flat, seed=1)[1]} == {"x", "y"}


def test_refusals():
    with pytest.raises(UnknownName, match="'gap'"):
        contaminate(still(), ["gap"])
    with pytest.raises(BadInput, match="share"):
        contaminate(still(), share=0.3)
    with pytest.raises(BadInput, match="amplitude"):
        contaminate(still(), amplitude_mm=0)
    with pytest.raises(BadInput, match="empty"):
        contaminate(still(), [])
