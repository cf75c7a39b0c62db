"""The parameter section of a C3D file, read without trusting it.

Every offset and length is checked against the section before anything is read, and the section is
walked strictly forward, so that no file can make it crash or loop.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from markermend.errors import UnreadableTake
from markermend.io.c3d_numbers import ByteOrder, to_floats

BLOCK = 512
LARGEST_SECTION = 1024 * BLOCK
"""No parameter section is longer: 255 blocks are the format's own limit."""


@dataclass(frozen=True)
class C3DParameters:
    """All parameters by ``"GROUP:NAME"``, upper case: numbers as floats, texts as strings."""

    order: ByteOrder
    numbers: Mapping[str, tuple[float, ...]]
    texts: Mapping[str, tuple[str, ...]]
    complete: bool

    def number(self, name: str) -> float | None:
        """First value of a numeric parameter, or None."""
        values = self.numbers.get(name, ())
        return values[0] if values else None

    def count(self, name: str) -> int | None:
        """First value as an unsigned 16-bit count, or None where there is no sensible one."""
        value = self.number(name)
        if value is None or not math.isfinite(value):
            return None
        whole = int(value)
        return whole + 65536 if -32768 <= whole < 0 else whole

    def texts_continued(self, name: str) -> tuple[str, ...]:
        """Texts of ``NAME``, ``NAME2``, ``NAME3``...: lists of more than 255 entries are split."""
        found = list(self.texts.get(name, ()))
        part = 2
        while f"{name}{part}" in self.texts:
            found += self.texts[f"{name}{part}"]
            part += 1
        return tuple(found)


def read_parameters(head: bytes) -> C3DParameters:
    """Read the parameter section.

    Parameters
    ----------
    head
        The file from its first byte to at least the start of the data.

    Raises
    ------
    UnreadableTake
        If this is no C3D file, or the section does not say how its numbers are stored.
    """
    if len(head) < 2 * BLOCK or head[1] != 0x50:
        raise UnreadableTake("This is no C3D file: its first block is missing or has another mark.")
    start = (max(head[0], 1) - 1) * BLOCK
    if head[0] < 2 or start + 4 > len(head):
        raise UnreadableTake(
            f"The C3D header puts the parameters at block {head[0]}, where there are none; "
            "export the take again from its own program."
        )
    try:
        order = ByteOrder(head[start + 3])
    except ValueError:
        raise UnreadableTake(
            f"The C3D file names processor type {head[start + 3]}, not 84, 85 or 86, so its "
            "numbers cannot be read; export the take again from its own program."
        ) from None
    data = (int(np.frombuffer(head, order.int16, 1, 16)[0]) % 65536 - 1) * BLOCK
    return _Section(head[start : data if data > start else None], order).walk()


class _Section:
    """The walk over groups and parameters."""

    def __init__(self, section: bytes, order: ByteOrder) -> None:
        self.bytes, self.order = section, order
        self.groups: dict[int, str] = {}
        self.found: list[tuple[int, str, tuple[float, ...] | tuple[str, ...]]] = []

    def walk(self) -> C3DParameters:
        at, complete = 4, True
        while 0 <= at <= len(self.bytes) - 2:
            length, number = abs(_int8(self.bytes[at])), _int8(self.bytes[at + 1])
            if number == 0 or (length == 0 and number > 0 and number not in self.groups):
                break  # the end, or what an unfinished section holds after it
            link = at + 2 + length
            if link + 2 > len(self.bytes):
                complete = False
                break
            name = self.bytes[at + 2 : link].decode("latin-1").strip().upper()
            if number < 0:
                self.groups.setdefault(-number, name)
            else:
                values = self._values(link + 2)
                if values is None:
                    complete = False
                else:
                    self.found.append((number, name, values))
            step = int(np.frombuffer(self.bytes, self.order.int16, 1, link)[0])
            if step <= 0:
                complete &= step == 0
                break
            at = link + step
        numbers: dict[str, tuple[float, ...]] = {}
        texts: dict[str, tuple[str, ...]] = {}
        for number, name, values in self.found:
            key = f"{self.groups.get(number, '')}:{name}"
            if values and isinstance(values[0], str):
                texts.setdefault(key, values)
            elif values:
                numbers.setdefault(key, values)  # type: ignore[arg-type]
        return C3DParameters(self.order, numbers, texts, complete)

    def _values(self, at: int) -> tuple[float, ...] | tuple[str, ...] | None:
        """Read one parameter from its type byte on; None where it does not fit the section."""
        if at + 2 > len(self.bytes):
            return None
        kind, n_dims = _int8(self.bytes[at]), self.bytes[at + 1]
        dims = tuple(self.bytes[at + 2 : at + 2 + n_dims])
        if kind not in (-1, 1, 2, 4) or n_dims > 7 or len(dims) < n_dims:
            return None
        count, at = math.prod(dims), at + 2 + n_dims
        if at + count * abs(kind) > len(self.bytes):
            return None
        if kind == -1:
            width = dims[0] if dims else 1
            raw = self.bytes[at : at + count]
            return tuple(text(raw[i : i + width]) for i in range(0, count, max(width, 1)))
        stored: Any
        if kind == 1:
            stored = np.frombuffer(self.bytes, np.int8, count, at)
        elif kind == 2:
            stored = np.frombuffer(self.bytes, self.order.int16, count, at)
        else:
            stored = to_floats(np.frombuffer(self.bytes, self.order.float32, count, at), self.order)
        return tuple(float(value) for value in stored)


def text(raw: bytes) -> str:
    """Decode a stored text, UTF-8 or else Western European, without control characters."""
    try:
        decoded = raw.decode("utf-8")
    except UnicodeDecodeError:
        decoded = raw.decode("cp1252", "replace")
    return "".join(" " if ord(c) < 32 or ord(c) == 127 else c for c in decoded).strip()


def _int8(byte: int) -> int:
    return byte - 256 if byte > 127 else byte
