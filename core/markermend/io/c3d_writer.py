"""Write a take as a C3D file of its own: Intel byte order, floats, millimetres.

What the take does not know (analog channels, force plates, camera masks, the lab's parameters) is
not in such a file; a take that came from a C3D file is exported by patching that file instead.
Frames beyond 65,535 are counted in POINT:LONG_FRAMES and the two-word fields of TRIAL.
"""

import math
import struct
from collections.abc import Sequence

import numpy as np

from markermend.errors import CannotWrite
from markermend.model import Take

_BLOCK = 512
_CHAR, _INT, _FLOAT = -1, 2, 4


def write_c3d(take: Take) -> bytes:
    """Give the bytes of a C3D file with the points and events of a take.

    Raises
    ------
    CannotWrite
        If the take is two-dimensional or has more points than C3D can count.
    """
    if take.n_dims != 3:
        raise CannotWrite("C3D holds three dimensions, this take has two; write it as .npz.")
    if take.n_markers > 16000:
        raise CannotWrite(f"C3D cannot count {take.n_markers} points; write the take as .npz.")
    last = take.first_frame + take.n_frames - 1
    section = _Parameters()
    section.group("POINT")
    section.ints("USED", take.n_markers)
    section.floats("SCALE", -1.0)
    section.floats("RATE", take.rate)
    section.ints("DATA_START", 0)
    section.ints("FRAMES", min(take.n_frames, 65535))
    section.floats("LONG_FRAMES", take.n_frames)
    section.texts("UNITS", ["mm"])
    section.texts("LABELS", take.labels)
    models = [label for label, role in zip(take.labels, take.roles, strict=True) if role == "model"]
    if models:
        section.texts("MODELED_MARKERS", models)
    section.group("ANALOG")
    section.ints("USED", 0)
    section.group("TRIAL")
    section.ints("ACTUAL_START_FIELD", *divmod(max(take.first_frame, 0), 65536)[::-1])
    section.ints("ACTUAL_END_FIELD", *divmod(max(last, 0), 65536)[::-1])
    events = [event for event in take.events if math.isfinite(event.time_s)][:255]
    if events:
        section.group("EVENT")
        section.ints("USED", len(events))
        section.texts("LABELS", [event.label for event in events])
        section.texts("CONTEXTS", [event.context for event in events])
        times = [divmod(event.time_s, 60.0) for event in events]
        section.floats("TIMES", *(x for pair in times for x in pair), columns=2)
    parameters, blocks = section.done()
    header = struct.pack(
        "<BBHHHHHfHHf",
        2,
        0x50,
        take.n_markers,
        0,
        min(max(take.first_frame, 0), 65535),
        min(max(last, 0), 65535),
        0,
        -1.0,
        2 + blocks,
        0,
        take.rate,
    )
    points = np.zeros((take.n_frames, take.n_markers, 4), "<f4")
    points[..., :3] = np.nan_to_num(take.positions)
    points[..., 3] = np.where(take.seen, 0.0, -1.0)
    data = points.tobytes()
    return header.ljust(_BLOCK, b"\0") + parameters + data + bytes(-len(data) % _BLOCK)


class _Parameters:
    """The parameter section as it grows."""

    def __init__(self) -> None:
        self.bytes = bytearray(b"\x01\x50\x00\x54")
        self.n_groups = 0
        self.start_at = 0

    def group(self, name: str) -> None:
        self.n_groups += 1
        self._add(name, -self.n_groups, b"\0")

    def ints(self, name: str, *values: int) -> None:
        if name == "DATA_START":
            self.start_at = len(self.bytes) + 2 + len(name) + 4
        body = struct.pack(f"<{len(values)}H", *values)
        self._parameter(name, _INT, (len(values),) if len(values) > 1 else (), body)

    def floats(self, name: str, *values: float, columns: int = 0) -> None:
        dims = (columns, len(values) // columns) if columns else ()
        self._parameter(name, _FLOAT, dims, struct.pack(f"<{len(values)}f", *values))

    def texts(self, name: str, values: Sequence[str]) -> None:
        """Write texts, 255 in each of NAME, NAME2, NAME3..."""
        for part, first in enumerate(range(0, len(values), 255), 1):
            encoded = [text.encode()[:255] for text in values[first : first + 255]]
            width = max(map(len, encoded))
            body = b"".join(text.ljust(width) for text in encoded)
            own = name if part == 1 else f"{name}{part}"
            self._parameter(own, _CHAR, (width, len(encoded)), body)

    def _parameter(self, name: str, kind: int, dims: tuple[int, ...], body: bytes) -> None:
        head = struct.pack(f"<bB{len(dims)}B", kind, len(dims), *dims)
        self._add(name, self.n_groups, head + body + b"\0")

    def _add(self, name: str, number: int, body: bytes) -> None:
        if 2 + len(body) > 32767:
            raise CannotWrite(
                f"The C3D parameter {name} would be too long; write the take as .npz."
            )
        self.bytes += struct.pack("<bb", len(name), number) + name.encode()
        self.bytes += struct.pack("<h", 2 + len(body)) + body

    def done(self) -> tuple[bytes, int]:
        self.bytes += b"\0\0"
        blocks = -(-len(self.bytes) // _BLOCK)
        if blocks > 255:
            raise CannotWrite("The labels are too many for a C3D file; write the take as .npz.")
        self.bytes[2] = blocks
        struct.pack_into("<H", self.bytes, self.start_at, 2 + blocks)
        return bytes(self.bytes.ljust(blocks * _BLOCK, b"\0")), blocks
