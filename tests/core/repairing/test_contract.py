"""Laws that hold for every registered repair method, named or of another package."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from markermend.errors import BadParameter, CannotRepair
from markermend.model import Span, Take
from markermend.params import OneOf, Within
from markermend.repairing.run import REPAIRS, apply, repair

NAMES = REPAIRS.names()

# Laws that a method does not promise, each with the reason.
NO_ROTATION = {
    "pchip": "monotone along each axis",
    **dict.fromkeys(("li", "lpr", "glr", "lgrnn", "pma"), "smooths by the median of each axis"),
    **dict.fromkeys(("wpca", "pca_r1"), "scales each axis to unit variance"),
    "polynomial": "raises each axis to powers",
    "ffnn": "squares each axis",
    "unslow": "decides on each axis by itself",
    "slr": "sums the frequencies of each axis",
}
NO_REVERSAL = {
    "unslow": "takes the posture before the span for its frame of reference",
    "polynomial": "looks at past frames",
    "ffnn": "looks at past frames",
    "rlk": "its shape of reference is the posture before the span",
    **dict.fromkeys(("li_eq8", "li_eq16"), "cuts pieces from the first frame on"),
    "auto": "its shape of reference is the posture before the span",
}
TURN = Rotation.from_rotvec([0.7, -0.4, 1.1]).as_matrix()
AWAY = np.array([2500.0, -1300.0, 400.0])


@pytest.fixture(params=NAMES)
def method(request):
    return REPAIRS.get(request.param)


def assert_refuses_or_fills(solve) -> None:
    """Either finite numbers, or one sentence with a way out."""
    try:
        values = solve()
    except CannotRepair as refusal:
        assert_sentence(str(refusal))
    else:
        assert np.isfinite(values).all()


def assert_sentence(text: str) -> None:
    assert re.fullmatch(r"[^\n]{20,300}\.", text), text
    assert "; " in text, f"no way out is offered: {text}"


def test_gives_the_shape_and_changes_no_input(method, lab):
    given = lab.for_method(method)
    before = given.take.positions.copy()
    once, again = given.solve(method.name), given.solve(method.name)
    assert once.shape == given.truth.shape
    assert np.isfinite(once).all() or method.name == "leave"
    np.testing.assert_array_equal(once, again)
    np.testing.assert_array_equal(given.take.positions, before)
    assert not given.take.positions.flags.writeable


def test_touches_nothing_outside_the_span(method, lab):
    given = lab.for_method(method)
    done = repair(
        given.take, given.marker, given.span, method.name, kind=given.kind, partner=given.partner,
        training=given.training,
    )  # fmt: skip
    written = apply(given.take, [done]).positions
    changed = ~np.isclose(written, given.take.positions, rtol=0, atol=0, equal_nan=True)
    frames, markers, _ = np.nonzero(changed)
    allowed = {given.take.index(label) for label in (done.marker, *dict(done.also))}
    assert set(markers) <= allowed
    assert set(frames) <= set(range(given.span.start, given.span.stop))


def test_is_documented(method):
    assert method.summary.endswith(".")
    assert len(method.title) > 2
    assert len(method.source) > 10
    assert method.kinds
    for parameter in method.parameters:
        assert parameter.doc, f"{parameter.name} is not described"
        assert parameter.bounds or parameter.type is bool, f"{parameter.name} has no bounds"
        assert parameter.check(parameter.default) == parameter.default


def test_accepts_what_is_within_bounds_and_refuses_the_rest(method, lab):
    given = lab.for_method(method)
    for parameter in method.parameters:
        bounds = parameter.bounds
        good = bounds.choices if isinstance(bounds, OneOf) else (True, False)
        bad = ("no such word",)
        if isinstance(bounds, Within):
            good = (parameter.type(bounds.low), parameter.type(bounds.high))
            bad = (bounds.low - 1, bounds.high * 2 + 1, float("nan"), "many")
        for value in good:
            assert_refuses_or_fills(lambda v=value, n=parameter.name: given.solve(
                method.name, **{n: v}) if method.name != "leave" else given.truth)  # fmt: skip
        for value in bad:
            with pytest.raises(BadParameter, match=parameter.name):
                given.solve(method.name, **{parameter.name: value})


@pytest.mark.parametrize("name", [n for n in NAMES if n != "leave"])
class TestRefuses:
    def solve(self, given, name, positions, span=None, labels=None):
        take = Take(positions, given.take.rate, labels or given.take.labels)
        return repair(
            take, given.marker, span or given.span, name, kind=given.kind, partner=given.partner,
            training=given.training,
        ).values  # fmt: skip

    def test_a_marker_that_is_never_seen(self, name, lab):
        given = lab.for_method(REPAIRS.get(name))
        positions = given.take.positions.copy()
        positions[:, given.take.index(given.marker)] = np.nan
        with pytest.raises(CannotRepair) as refusal:
            self.solve(given, name, positions)
        assert_sentence(str(refusal.value))

    def test_a_take_of_which_nothing_is_seen(self, name, lab):
        given = lab.for_method(REPAIRS.get(name))
        with pytest.raises(CannotRepair) as refusal:
            self.solve(given, name, np.full_like(given.take.positions, np.nan))
        assert_sentence(str(refusal.value))

    def test_a_take_of_one_frame(self, name, lab):
        given = lab.for_method(REPAIRS.get(name))
        with pytest.raises(CannotRepair) as refusal:
            self.solve(given, name, given.take.positions[:1], Span(0, 1))
        assert_sentence(str(refusal.value))

    def test_or_fills_a_marker_without_neighbours(self, name, lab):
        given = lab.for_method(REPAIRS.get(name))
        alone = given.take.positions[:, [given.take.index(given.marker)]]
        if given.partner is None:
            assert_refuses_or_fills(lambda: self.solve(given, name, alone, labels=(given.marker,)))

    @pytest.mark.parametrize("span", [Span(0, 20), Span(220, 240)])
    def test_or_fills_at_the_ends_of_the_take(self, name, span, lab):
        given = lab.for_method(REPAIRS.get(name), span=span)
        assert_refuses_or_fills(lambda: given.solve(name))

    def test_or_fills_two_dimensions(self, name, lab):
        given = lab.for_method(REPAIRS.get(name), n_dims=2)
        assert_refuses_or_fills(lambda: given.solve(name))

    @pytest.mark.parametrize("n_frames", [2, 3, 5])
    def test_or_fills_takes_of_a_few_frames(self, name, n_frames, lab):
        given = lab.for_method(REPAIRS.get(name))
        start = given.span.start - n_frames // 2
        assert_refuses_or_fills(
            lambda: self.solve(
                given,
                name,
                given.take.positions[start : start + n_frames],
                Span(n_frames // 2, n_frames // 2 + 1),
            )
        )


def promising(*but: str) -> list[str]:
    """All methods that give values, less some."""
    return [name for name in NAMES if name not in ("leave", *but)]


class TestKeepsTo:
    @pytest.mark.parametrize("name", promising())
    def test_the_truth_roughly(self, name, lab):
        """A figure of merit no method may miss: the marker moves by 200 mm over the span."""
        given = lab.for_method(REPAIRS.get(name))
        error = np.linalg.norm(given.solve(name) - given.truth, axis=1).mean()
        assert error < 40.0

    @pytest.mark.parametrize("name", promising())
    def test_a_shift(self, name, lab):
        self.assert_moves_along(lab.for_method(REPAIRS.get(name)), name, lambda x: x + AWAY)

    @pytest.mark.parametrize("name", promising(*NO_ROTATION))
    def test_a_rotation(self, name, lab):
        self.assert_moves_along(lab.for_method(REPAIRS.get(name)), name, lambda x: x @ TURN.T)

    @pytest.mark.parametrize(("kind", "n_frames"), [("gap", 120), ("noise", 400)])
    def test_a_rotation_in_short_windows_and_under_noise(self, kind, n_frames, lab):
        """Where `auto` fills in other ways than by a tested mix, it turns with the room too."""
        truth = lab.walker(n_frames)
        given = lab.case(kind, truth=truth, span=Span(40, 60))
        if kind == "gap":
            positions = given.take.positions.copy()
            positions[30:75, :4:2] = np.nan
            given = replace(given, take=given.take.with_positions(positions))
        self.assert_moves_along(given, "auto", lambda x: x @ TURN.T)

    @pytest.mark.parametrize("axes", [(0,), (0, 1, 2)])
    def test_a_rotation_under_peaks_unless_an_axis_is_as_usual(self, axes, lab):
        """An axis of the room that is as usual stays as recorded: that cannot turn with it."""
        truth = lab.walker(400)
        given = lab.case("gap", truth=truth, span=Span(180, 184))
        spoilt = truth.copy()
        at = (slice(180, 184), lab.LABELS.index(lab.MARKER))
        spoilt[at][:, list(axes)] += 60.0
        given = replace(given, take=Take(spoilt, lab.RATE, lab.LABELS), kind="peak")
        if len(axes) == 3:
            self.assert_moves_along(given, "auto", lambda x: x @ TURN.T)
        else:
            np.testing.assert_array_equal(given.solve("auto")[:, 1:], truth[at][:, 1:])

    def assert_moves_along(self, given, name, change):
        moved = given.moved(change).solve(name)
        np.testing.assert_allclose(moved, change(given.solve(name)), rtol=0, atol=1e-3)

    @pytest.mark.parametrize("name", promising())
    def test_a_change_of_unit(self, name, lab):
        given = lab.for_method(REPAIRS.get(name))
        metres = lab.Case(
            Take(given.take.positions / 1000, given.take.rate, given.take.labels, units="m"),
            given.truth, given.kind, given.marker, given.span, given.partner, given.training,
        )  # fmt: skip
        np.testing.assert_allclose(metres.solve(name), given.solve(name), rtol=0, atol=1e-4)

    @pytest.mark.parametrize("name", promising(*NO_REVERSAL))
    def test_the_other_direction_of_time(self, name, lab):
        given = lab.for_method(REPAIRS.get(name))
        n = given.take.n_frames
        back = lab.Case(
            given.take.with_positions(given.take.positions[::-1]),
            given.truth[::-1],
            given.kind,
            span=Span(n - given.span.stop, n - given.span.start),
            partner=given.partner,
            training=tuple(t.with_positions(t.positions[::-1]) for t in given.training),
        )
        np.testing.assert_allclose(back.solve(name)[::-1], given.solve(name), rtol=0, atol=1e-3)

    @pytest.mark.parametrize("name", promising())
    @pytest.mark.parametrize("velocity", [[0, 0, 0], [3.0, -1.0, 0.5]])
    def test_a_body_that_stands_or_glides(self, name, velocity, lab):
        pose = lab.walker(noise=0)[:1]
        truth = pose + np.arange(240)[:, None, None] * np.array(velocity, float)
        given = lab.for_method(REPAIRS.get(name), truth=truth)
        tolerance = 15.0 if given.kind == "noise" else 1.0
        try:
            values = given.solve(name)
        except CannotRepair as refusal:
            assert_sentence(str(refusal))
        else:
            assert np.abs(values - given.truth).max() < tolerance
