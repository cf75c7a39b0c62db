"""All that passes between a page and its server, and what is to be found in it."""

import re
from base64 import b64decode
from collections.abc import Iterable, Iterator
from itertools import product
from typing import Any

import numpy as np
from playwright.sync_api import Page, Response

from markermend.model import FloatArray
from markermend.train import Exercise

BASE64 = re.compile(rb"[A-Za-z0-9+/]{16,}={0,2}")
STATIC = ("/static/", "/components/")
"""Files of the packages: they are the same whatever is practised."""


class Traffic:
    """Listens to a page from before its first request; frames of its socket, and fetches."""

    def __init__(self, page: Page) -> None:
        self._frames: list[bytes] = []
        self._responses: list[Response] = []
        page.on("websocket", self._socket)
        page.on("response", self._response)

    def _socket(self, socket: Any) -> None:
        for event in ("framereceived", "framesent"):
            socket.on(event, self._frame)

    def _response(self, response: Response) -> None:
        self._responses.append(response)

    def _frame(self, payload: str | bytes) -> None:
        self._frames.append(payload.encode() if isinstance(payload, str) else payload)

    def forget(self) -> None:
        """Begin anew."""
        self._frames.clear()
        self._responses.clear()

    def heard(self) -> bytes:
        """Give everything so far, and once more what stands in it as base64."""
        fetched = [
            response.body()
            for response in self._responses
            if response.ok and not any(part in response.url for part in STATIC)
        ]
        plain = b"\n".join([*self._frames, *fetched])
        return plain + b"\n" + b"\n".join(_decoded(plain))


def _decoded(plain: bytes) -> Iterator[bytes]:
    for found in BASE64.findall(plain):
        whole = len(found) // 4 * 4
        yield b64decode(found[:whole])


MOST_FRAMES = 8
"""Frames of a span whose values are searched for: who sent the others would send these."""


def values(true: FloatArray, other: FloatArray) -> Iterator[bytes]:
    """Give how the true values could be written where they are not the other ones.

    Parameters
    ----------
    true, other
        (n, n_dims) mm of one marker over one span, as it was and as it is shown.
    """
    differs = ~np.isclose(true, other, atol=0.01)  # NaN is shown in a gap
    frames = np.unique(np.linspace(0, len(true) - 1, MOST_FRAMES).astype(int))
    for i, j in product(frames, range(true.shape[1])):
        if not differs[i, j]:
            continue
        value = true[i, j]
        yield value.tobytes()
        yield repr(float(value)).encode()
        yield f"{value:.6f}"[:-1].encode()  # the last digit could be rounded otherwise
        # Four bytes alone are somewhere by chance: two neighbours are not.
        if j + 1 < true.shape[1]:
            yield true[i, j : j + 2].astype(np.float32).tobytes()
        if i + 1 < len(true):
            yield true[i : i + 2, j].astype(np.float32).tobytes()


def edges(start: int, stop: int, rate: float) -> tuple[list[str], list[bytes]]:
    """Give how the edges of a span could be written, in frames or seconds: as text, as bytes."""
    texts, plain = [], []
    for last in (stop, stop - 1):
        texts += [
            _beside(f"{start}", f"{last}"),
            _beside(f"{start / rate:.2f}", f"{last / rate:.2f}"),
        ]
        plain += [
            np.array([start, last], kind).tobytes()
            for kind in (np.int32, np.int64, np.float32, np.float64)
        ]
    plain += [np.float64((frame - 0.5) / rate).tobytes() for frame in (start, stop)]
    return texts, plain


def _beside(one: str, other: str) -> str:
    return rf"(?<![\d.]){re.escape(one)}[^\d]{{1,20}}{re.escape(other)}(?!\d)"


def kinds(exercise: Exercise) -> list[str]:
    """Give how the kinds of all artefacts could be written one after another."""
    by_time = sorted(exercise.truths, key=lambda truth: truth.span)
    return [
        r"\W{1,8}".join(truth.kind for truth in truths) for truths in (exercise.truths, by_time)
    ]


def told(heard: bytes, exercise: Exercise, shown: Iterable[tuple[int, int]] = ()) -> list[str]:
    """Give what can be found of the truth of an exercise; the spans shown may be known."""
    take, found, patterns = exercise.take, [], kinds(exercise)
    for answer in exercise.answers:
        given = take.positions[answer.span.frames, take.index(answer.marker)]
        needles = set(values(answer.values, given))
        found += [f"a value of {answer.marker}" for needle in needles if needle in heard]
    for start, stop in {(a.span.start, a.span.stop) for a in exercise.answers} - set(shown):
        texts, plain = edges(start, stop, take.rate)
        patterns += texts
        found += [f"span {start}-{stop}" for needle in plain if needle in heard]
    met = re.finditer("|".join(patterns).encode(), heard)
    return [*found, *(match[0].decode() for match in met)]
