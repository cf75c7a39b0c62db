"""All that passes between a page and its server, and what is to be found in it."""

import re
from base64 import b64decode
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from playwright.sync_api import Page, Response

from markermend.model import FloatArray, Take
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


def values(true: FloatArray, other: FloatArray) -> Iterator[bytes]:
    """Give how the true values could be written where they are not the other ones.

    Parameters
    ----------
    true, other
        (n, n_dims) mm of one marker over one span, as it was and as it is shown.
    """
    differs = ~np.isclose(true, other, atol=0.01)  # NaN is shown in a gap
    for (i, j), value in np.ndenumerate(true):
        if not differs[i, j]:
            continue
        yield value.tobytes()
        yield repr(float(value)).encode()
        yield f"{value:.6f}"[:-1].encode()  # the last digit could be rounded otherwise
        # Four bytes alone are somewhere by chance: two neighbours are not.
        if j + 1 < true.shape[1]:
            yield true[i, j : j + 2].astype(np.float32).tobytes()
        if i + 1 < len(true):
            yield true[i : i + 2, j].astype(np.float32).tobytes()


def spans(starts_and_stops: Iterable[tuple[int, int]], rate: float) -> Iterator[re.Pattern[bytes]]:
    """Give how the edges of spans could be written: as frames or seconds, in text or in bytes."""
    for start, stop in starts_and_stops:
        for last in (stop, stop - 1):
            yield _beside(f"{start}", f"{last}")
            yield _beside(f"{start / rate:.2f}", f"{last / rate:.2f}")
            for kind in (np.int32, np.int64, np.float32, np.float64):
                yield re.compile(re.escape(np.array([start, last], kind).tobytes()))
        for time in ((start - 0.5) / rate, (stop - 0.5) / rate):
            yield re.compile(re.escape(np.float64(time).tobytes()))


def _beside(one: str, other: str) -> re.Pattern[bytes]:
    return re.compile(rf"(?<![\d.]){re.escape(one)}[^\d]{{1,20}}{re.escape(other)}(?!\d)".encode())


def kinds(exercise: Exercise) -> Iterator[re.Pattern[bytes]]:
    """Give how the kinds of all artefacts could be written one after another."""
    by_time = sorted(exercise.truths, key=lambda truth: truth.span)
    for truths in (exercise.truths, by_time):
        yield re.compile(r"\W{1,8}".join(truth.kind for truth in truths).encode())


def told(heard: bytes, exercise: Exercise, shown: Iterable[tuple[int, int]] = ()) -> list[str]:
    """Give what can be found of the truth of an exercise; the spans shown may be known."""
    found = []
    for answer in exercise.answers:
        given = _part(exercise.take, answer.marker, answer.span.frames)
        found += [
            f"a value of {answer.marker}"
            for needle in values(answer.values, given)
            if needle in heard
        ]
    pairs = {(a.span.start, a.span.stop) for a in exercise.answers} - set(shown)
    found += [f"span {p.pattern!r}" for p in spans(pairs, exercise.take.rate) if p.search(heard)]
    found += [f"kinds {p.pattern!r}" for p in kinds(exercise) if p.search(heard)]
    return found


def _part(take: Take, marker: str, frames: slice) -> FloatArray:
    part: FloatArray = take.positions[frames, take.index(marker)]
    return part
