"""What an error may quote, and how much of it."""

import inspect
import pickle

import pytest
from hypothesis import given
from hypothesis import strategies as st

from markermend.errors import BadInput, MarkerMendError, UnknownName, legible


@given(st.text())
def test_a_message_holds_nothing_that_cannot_be_seen(text: str) -> None:
    said = str(BadInput(text))
    assert said == legible(said)
    assert not set(said) & set("\n\r\t\0\x1b\u202e\u2066\u200b\ufeff\u2028")
    said.encode()  # no halves of surrogate pairs


def test_letters_of_every_script_stay() -> None:
    for text in ("Knie links", "كاحل", "קרסול", "膝", "genou é", "a\xa0b"):
        assert legible(text) == text
    assert legible("a\u202eb\nc\ud800") == "ab c\ufffd"


def every_error() -> list[type[MarkerMendError]]:
    found, rim = [], [MarkerMendError]
    while rim:
        found += rim
        rim = [kind for parent in rim for kind in parent.__subclasses__()]
    return [kind for kind in found if kind.__module__ == "markermend.errors"]


@pytest.mark.parametrize("kind", every_error())
def test_every_error_comes_out_of_another_process_whole(kind: type[MarkerMendError]) -> None:
    wanted = list(inspect.signature(kind).parameters.values())[1:]
    more = ["units"] * sum(p.default is p.empty and p.kind is not p.VAR_POSITIONAL for p in wanted)
    error = kind("It lacks its unit; give it.", *more)
    again = pickle.loads(pickle.dumps(error))
    assert (type(again), str(again), vars(again)) == (kind, str(error), vars(error))


def test_many_names_are_not_all_said() -> None:
    said = str(UnknownName.among("marker", "x" * 5000, [f"m{i}" for i in range(20_000)]))
    assert len(said) < 700
    assert said.endswith("and 19940 more.")
    assert str(UnknownName.among("kind", "q", [])) == "There is no kind 'q'; known are none."
