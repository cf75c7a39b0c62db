"""Where a C3D file stores its points: what reading without ezc3d and patching need.

C3D says many things twice, in its header and in its parameters, and real files contradict
themselves. Of all combinations of what a file says, the first that fits its size is taken; what
was overruled is named in a warning. (C3D User Guide, Motion Lab Systems, 2008.)
"""

import itertools
import math
import struct
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from markermend.errors import UnreadableTake
from markermend.io.c3d_numbers import ByteOrder, to_floats
from markermend.io.c3d_parameters import (
    BLOCK,
    LARGEST_SECTION,
    C3DParameters,
    read_parameters,
    text,
)

MOST_BY_EZC3D = 65535
"""16 bits hold no more frames: what ezc3d reads of a longer file ends there."""

_PADDING = 2 * BLOCK
"""So many bytes after the last frame are the filling of a block and no sign of a lie."""


@dataclass(frozen=True)
class C3DLayout:
    """Offsets, counts and number format of the point data.

    Attributes
    ----------
    order, is_float, scale
        Number format; integers times `scale` are the file's unit.
    data_start
        Byte of the first sample.
    n_points, n_analog
        Points, and analog values, of each frame.
    n_frames, n_announced
        Frames that are wholly there, and frames that the file says it has.
    rate
        Hz, or None.
    first_frame
        Number that the file gives its first frame.
    parameters
        All parameters.
    header_events
        ``(label, time in s)`` of the events in the header.
    warnings
        What the file says wrongly.
    """

    order: ByteOrder
    is_float: bool
    scale: float
    data_start: int
    n_points: int
    n_analog: int
    n_frames: int
    n_announced: int
    rate: float | None
    first_frame: int
    parameters: C3DParameters
    header_events: tuple[tuple[str, float], ...] = ()
    warnings: tuple[str, ...] = ()

    @property
    def value_bytes(self) -> int:
        """Size of a stored number."""
        return 4 if self.is_float else 2

    @property
    def frame_bytes(self) -> int:
        """Size of a frame, points and analog samples."""
        return (4 * self.n_points + self.n_analog) * self.value_bytes

    def stored(self, data: NDArray[np.uint8]) -> NDArray[Any]:
        """View the points in the bytes of the file as (n_frames, n_points, 4) stored numbers."""
        block = data[self.data_start : self.data_start + self.n_frames * self.frame_bytes]
        kind = self.order.float32 if self.is_float else self.order.int16
        values = block.view(kind).reshape(self.n_frames, -1)[:, : 4 * self.n_points]
        return values.reshape(self.n_frames, self.n_points, 4)

    def samples(self, data: NDArray[np.uint8]) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
        """Decode the points of the file's bytes.

        Returns
        -------
        positions, words
            (n_frames, n_points, 3) in the file's unit, and (n_frames, n_points) residual words:
            camera mask in the high byte, residual in the low one, negative where not valid.
        """
        stored = self.stored(data)
        words = self.words(stored[..., 3])
        if not self.is_float:
            return stored[..., :3] * self.scale, words
        with np.errstate(invalid="ignore"):  # signalling NaNs
            return to_floats(stored[..., :3], self.order).astype(np.float64), words

    def words(self, stored: NDArray[Any]) -> NDArray[np.int32]:
        """Decode residual words of any shape."""
        if not self.is_float:
            return stored.astype(np.int32)
        floats = np.nan_to_num(to_floats(stored, self.order), nan=-1.0, posinf=-1.0, neginf=-1.0)
        return np.clip(floats, -32768, 32767).astype(np.int32)


def read_layout(path: Path) -> C3DLayout:
    """Find the point data of a C3D file.

    Raises
    ------
    UnreadableTake
        If the file is no C3D file, holds no points, or contradicts itself beyond repair.
    """
    size = path.stat().st_size
    with path.open("rb") as file:
        head = file.read(LARGEST_SECTION)
        file.seek(max(0, size - _PADDING))
        return _without_padding(layout_of(head, size), file.read(), size)


def layout_in(data: bytes) -> C3DLayout:
    """Find the point data in all bytes of a C3D file; as `read_layout`."""
    return _without_padding(
        layout_of(data[:LARGEST_SECTION], len(data)), data[-_PADDING:], len(data)
    )


def _without_padding(layout: C3DLayout, tail: bytes, size: int) -> C3DLayout:
    """Leave out frames of zeros that fill the last block of a file too long for its header."""
    if layout.n_frames < MOST_BY_EZC3D:
        return layout
    zeros = len(tail) - len(tail.rstrip(b"\0"))
    n_frames = -(-(size - zeros - layout.data_start) // layout.frame_bytes)
    n_frames = min(layout.n_frames, n_frames)
    return replace(layout, n_frames=n_frames, n_announced=n_frames)


def layout_of(head: bytes, size: int) -> C3DLayout:
    """Find the point data of a C3D file of `size` bytes from its first bytes."""
    parameters = read_parameters(head)
    header = _Header.read(head, parameters.order)
    order = parameters.order
    chosen, warnings = _choose(header, parameters, size)
    if chosen.points == 0:
        raise UnreadableTake("The C3D file holds no points, only analog channels or nothing.")
    scale = abs(chosen.scale) if math.isfinite(chosen.scale) else 0.0
    if chosen.scale > 0 and scale == 0:
        raise UnreadableTake("POINT:SCALE of the C3D file is 0; export the take again.")
    announced, n_frames = chosen.frames, min(chosen.frames, chosen.capacity(size))
    if announced >= MOST_BY_EZC3D and chosen.capacity(size) > announced:
        n_frames = announced = chosen.capacity(size)
        warnings.append(
            f"The header can count to {MOST_BY_EZC3D} frames only; all that the file holds "
            "were read."
        )
    if n_frames <= 0:
        raise UnreadableTake(
            f"The C3D file announces {announced} frames and holds none of them whole; "
            "copy it again from its origin."
        )
    if n_frames < announced:
        warnings.append(
            f"The file is cut off: {n_frames} of the {announced} frames that it announces are "
            "there."
        )
    if not parameters.complete:
        warnings.append("Some parameters of the file are damaged and were left out.")
    rate, rate_warnings = _rate(header, parameters)
    warnings += rate_warnings
    if header.first > header.last > 0:
        warnings.append(
            f"The header's first frame, {header.first}, comes after its last, {header.last}."
        )
    return C3DLayout(
        order=order,
        is_float=chosen.scale < 0,
        scale=scale,
        data_start=chosen.start,
        n_points=chosen.points,
        n_analog=chosen.analog,
        n_frames=n_frames,
        n_announced=announced,
        rate=rate,
        first_frame=_start_field(parameters) or header.first,
        parameters=parameters,
        header_events=header.events,
        warnings=tuple(warnings),
    )


@dataclass(frozen=True)
class _Header:
    """The first block."""

    points: int
    analog: int
    first: int
    last: int
    scale: float
    start_block: int
    per_frame: int
    rate: float
    events: tuple[tuple[str, float], ...]

    @classmethod
    def read(cls, head: bytes, order: ByteOrder) -> "_Header":
        mark = ">" if order is ByteOrder.MIPS else "<"
        words = struct.unpack(f"{mark}256H", head[:BLOCK])

        def floats(word: int, n: int) -> list[float]:
            stored = np.frombuffer(head, order.float32, n, 2 * (word - 1))
            return [float(x) for x in to_floats(stored, order)]

        events: list[tuple[str, float]] = []
        if words[149] == 12345:  # word 150: the key of labels of four characters
            times = floats(153, 18)
            for i, time in enumerate(times[: min(words[150], 18)]):
                label = text(head[2 * 198 + 4 * i : 2 * 198 + 4 * i + 4])
                if math.isfinite(time):
                    events.append((label, time))
        (scale,), (rate,) = floats(7, 1), floats(11, 1)
        return cls(
            points=words[1],
            analog=words[2],
            first=words[3],
            last=words[4],
            scale=scale,
            start_block=words[8],
            per_frame=words[9],
            rate=rate,
            events=tuple(events),
        )


class _Claim(NamedTuple):
    """One combination of what the file says of its data."""

    start: int
    points: int
    analog: int
    scale: float
    frames: int

    @property
    def frame_bytes(self) -> int:
        return (4 * self.points + self.analog) * (4 if self.scale < 0 else 2)

    def capacity(self, size: int) -> int:
        return max(0, size - self.start) // self.frame_bytes if self.frame_bytes else 0

    def fits(self, size: int) -> bool:
        """Whether the frames fill the file up to the padding of its last block."""
        left = size - self.start - self.frames * self.frame_bytes
        return 0 <= left < _PADDING + self.frame_bytes * (self.frames >= MOST_BY_EZC3D)


def _choose(header: _Header, parameters: C3DParameters, size: int) -> tuple[_Claim, list[str]]:
    """Choose the first combination that fits the size of the file, else the first."""
    said: dict[str, list[float]] = {
        "start block": _said(header.start_block, parameters.count("POINT:DATA_START"), least=3),
        "points": _said(parameters.count("POINT:USED"), header.points),
        "analog values per frame": _said(header.analog, _analog(header, parameters), zero=True),
        "scale": _said(parameters.number("POINT:SCALE"), header.scale),
        "frames": [float(count) for count in _frames(header, parameters)],
    }
    if not said["points"] and (header.points == 0 or parameters.count("POINT:USED") == 0):
        raise UnreadableTake("The C3D file holds no points, only analog channels or nothing.")
    for what, values in said.items():
        if not values:
            raise UnreadableTake(
                f"The C3D file does not say its {what}; export it again from its own program."
            )
    claims = [
        _Claim((int(start) - 1) * BLOCK, int(points), int(analog), float(scale), int(frames))
        for start, points, analog, scale, frames in itertools.product(*said.values())
    ]
    chosen = next((claim for claim in claims if claim.fits(size)), claims[0])
    warnings = []
    given = ((chosen.start // BLOCK) + 1, *chosen[1:])
    for (what, values), value in zip(said.items(), given, strict=True):
        others = [f"{v:g}" for v in values if not _same(what, v, value)]
        if what == "frames" and value > MOST_BY_EZC3D:
            others = []  # 16 bits cannot say more: no contradiction
        if others:
            warnings.append(
                f"The file contradicts itself about its {what}: {value:g} was taken, "
                f"{' and '.join(others)} overruled."
            )
    return chosen, warnings


def _rate(header: _Header, parameters: C3DParameters) -> tuple[float | None, list[str]]:
    """Choose between POINT:RATE and the header's rate."""
    said = [parameters.number("POINT:RATE"), header.rate]
    sensible = [rate for rate in said if rate is not None and math.isfinite(rate) and rate > 0]
    if not sensible:
        return None, []
    rate = sensible[0]
    others = [f"{x:g}" for x in said if x is not None and not math.isclose(x, rate, rel_tol=1e-4)]
    if not others:
        return rate, []
    return rate, [
        f"The file contradicts itself about its rate: {rate:g} Hz was taken, {others[0]} overruled."
    ]


def _said(*values: float | None, zero: bool = False, least: float = -math.inf) -> list[float]:
    """Keep the different sensible values, in order."""
    sensible = [
        value
        for value in values
        if value is not None and math.isfinite(value) and (value != 0 or zero) and value >= least
    ]
    return list(dict.fromkeys(sensible))


def _same(what: str, one: float, other: float) -> bool:
    # Of the scale only the sign changes the layout, and programs round it differently.
    return (one < 0) == (other < 0) if what == "scale" else one == other


def _analog(header: _Header, parameters: C3DParameters) -> int | None:
    used = parameters.count("ANALOG:USED")
    return None if used is None else used * header.per_frame


def _start_field(parameters: C3DParameters) -> int | None:
    return _field(parameters, "TRIAL:ACTUAL_START_FIELD")


def _field(parameters: C3DParameters, name: str) -> int | None:
    """Read a 32-bit frame number that is stored as two 16-bit words."""
    words = parameters.numbers.get(name, ())
    if len(words) != 2 or not all(math.isfinite(word) for word in words):
        return None
    low, high = (int(word) % 65536 for word in words)
    return low + 65536 * high


def _frames(header: _Header, parameters: C3DParameters) -> Iterator[int]:
    """Yield the different counts of frames that the file gives, the likeliest first."""
    start, end = _start_field(parameters), _field(parameters, "TRIAL:ACTUAL_END_FIELD")
    long = parameters.number("POINT:LONG_FRAMES")
    candidates = [
        parameters.count("POINT:FRAMES"),
        int(long) if long is not None and math.isfinite(long) else None,
        end - start + 1 if start is not None and end is not None else None,
        header.last - header.first + 1,
    ]
    seen: set[int] = set()
    for count in candidates:
        if count is not None and 0 < count < 2**31 and count not in seen:
            seen.add(count)
            yield count
