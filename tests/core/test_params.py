"""Parameters are read from signatures, and checked by them."""

from typing import Annotated

import pytest

from markermend.errors import BadParameter, UnknownName
from markermend.params import OneOf, Within, checked, parameters_of


def blur(
    take: object,
    *,
    window: Annotated[int, Within(3, 101, "frames")] = 5,
    share: Annotated[float, Within(0, 1)] = 0.5,
    mode: Annotated[str, OneOf("soft", "hard")] = "soft",
    both: bool = False,
) -> None:
    """Blur.

    Parameters
    ----------
    window
        Width of the window,
        in frames.
    share, mode
        Shared words.

    Returns
    -------
    Nothing.
    """


def test_names_defaults_bounds_and_words_come_from_the_function():
    found = {p.name: p for p in parameters_of(blur)}
    assert list(found) == ["window", "share", "mode", "both"]
    assert found["window"].bounds == Within(3, 101, "frames")
    assert found["window"].doc == "Width of the window, in frames."
    assert found["share"].doc == found["mode"].doc == "Shared words."
    assert found["both"].doc == ""


def test_what_is_not_given_gets_its_default():
    assert checked(blur, {"window": 7}) == {
        "window": 7,
        "share": 0.5,
        "mode": "soft",
        "both": False,
    }


@pytest.mark.parametrize(
    ("given", "wanted"),
    [
        ({"window": "9"}, 9),
        ({"share": 1}, 1.0),
        ({"both": "yes"}, True),
        ({"both": False}, False),
        ({"mode": "hard"}, "hard"),
    ],
)
def test_words_of_a_command_line_are_converted(given: dict[str, object], wanted: object):
    (name,) = given
    value = checked(blur, given)[name]
    assert value == wanted
    assert type(value) is type(wanted)


@pytest.mark.parametrize(
    "given",
    [
        {"window": 2},
        {"window": 102},
        {"window": 3.5},
        {"window": "wide"},
        {"share": float("nan")},
        {"share": -0.1},
        {"mode": "medium"},
        {"both": "perhaps"},
        {"both": 3},
    ],
)
def test_values_out_of_bounds_are_refused_with_the_bounds(given: dict[str, object]):
    (name,) = given
    with pytest.raises(BadParameter, match=rf"^{name} must be .*; got "):
        checked(blur, given)


def test_unknown_parameters_are_refused_with_those_known():
    with pytest.raises(UnknownName, match="known are window, share, mode, both"):
        checked(blur, {"width": 3})
