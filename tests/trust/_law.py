"""The law of everything that is handed in: a take, or one sentence; nothing else, and soon."""

import contextlib
import math
import unicodedata
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np

from markermend.errors import Lacking, MarkerMendError
from markermend.io import Contents, Reading
from markermend.io.format import format_of
from markermend.model import Take

LONGEST_SENTENCE = 700
_UNSEEN = {"Cc", "Cf", "Cs", "Zl", "Zp"}


def opened(path: Path) -> Contents:
    """Read a file with our own parser alone."""
    return format_of(path).open(path, Reading(second_opinion=False))


def fault_of(act: Callable[[], object]) -> str:
    """Say how a call broke the law, in a few words; empty where it kept it."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            act()
        except MarkerMendError as refusal:
            return fault_of_sentence(str(refusal))
        except (Exception, RecursionError) as error:  # noqa: BLE001 - this is what is looked for
            return f"{type(error).__name__}: {str(error)[:120]}{_place(error)}"
    return ""


def _place(error: BaseException) -> str:
    trace = error.__traceback__
    place = ""
    while trace is not None:
        code = trace.tb_frame.f_code
        if "markermend" in code.co_filename:
            place = f" at {Path(code.co_filename).name}:{trace.tb_lineno}"
        trace = trace.tb_next
    return place


def fault_of_sentence(text: str) -> str:
    """Say what is wrong with a refusal: it must be one sentence that any screen can show."""
    if not 10 <= len(text) <= LONGEST_SENTENCE:
        return f"a refusal of {len(text)} characters: {text[:80]!r}"
    if not text.endswith("."):
        return f"a refusal without an end: {text[-80:]!r}"
    if any(unicodedata.category(c) in _UNSEEN for c in text):
        return f"a refusal with characters that cannot be seen: {text[:80]!r}"
    return ""


def read_wholly(path: Path) -> Take | None:
    """Read a file and check what it gives; None where it lacks its unit or rate.

    Raises
    ------
    AssertionError
        If the take is not as the model promises it.
    MarkerMendError
        If the file is refused.
    """
    contents = opened(path)
    shape = contents.positions.shape
    assert shape == (contents.n_frames, len(contents.labels), shape[2]), "shape"
    assert shape[0] > 0, "no frames"
    assert shape[1] > 0, "no points"
    assert len(contents.roles) == shape[1], "roles"
    for sentence in contents.warnings:
        fault = fault_of_sentence(sentence)
        assert not fault, f"warning: {fault}"
    with contextlib.suppress(Lacking):
        contents.take()
    units = "px" if shape[2] == 2 else contents.units or "mm"
    take = contents.take(units=units, rate=contents.rate or 100.0)
    assert len(set(take.labels)) == take.n_markers, "labels not unique"
    for label in take.labels:
        assert label == label.strip() != "", f"label {label[:40]!r}"
        assert not any(unicodedata.category(c) in _UNSEEN for c in label), f"label {label[:40]!r}"
    seen = np.isfinite(take.positions)
    assert (seen.all(axis=2) == seen.any(axis=2)).all(), "half a position"
    assert math.isfinite(take.rate), "rate"
    return take
