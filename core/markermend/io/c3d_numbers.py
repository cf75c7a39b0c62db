"""Numbers as C3D files store them: three byte orders, 16-bit integers and 32-bit floats.

The C3D User Guide names the processors by the byte 84 (Intel), 85 (DEC) and 86 (SGI/MIPS). Intel
and DEC store integers low byte first, MIPS high byte first; DEC floats are VAX F_floating: the two
16-bit words swapped, and the exponent two higher than in IEEE 754.
"""

import enum
from typing import Any

import numpy as np
from numpy.typing import NDArray


class ByteOrder(enum.IntEnum):
    """The processor that a C3D file was written for."""

    INTEL = 84
    DEC = 85
    MIPS = 86

    @property
    def int16(self) -> np.dtype[Any]:
        """The type of a stored integer."""
        return np.dtype(">i2" if self is ByteOrder.MIPS else "<i2")

    @property
    def float32(self) -> np.dtype[Any]:
        """The type of a stored float; in DEC files its bits are not yet IEEE's."""
        return np.dtype(">f4" if self is ByteOrder.MIPS else "<f4")


def to_floats(stored: NDArray[Any], order: ByteOrder) -> NDArray[np.float32]:
    """Decode stored 32-bit floats, given as an array of `ByteOrder.float32`."""
    if order is not ByteOrder.DEC:
        return stored.astype(np.float32)
    words = np.ascontiguousarray(stored).view("<u4")
    ieee = ((words >> 16) | (words << 16)).astype(np.uint32).view(np.float32)
    with np.errstate(invalid="ignore"):
        return np.asarray(ieee * np.float32(0.25), np.float32)


def from_floats(values: NDArray[Any], order: ByteOrder) -> NDArray[Any]:
    """Encode floats; infinite where DEC's smaller range overflows, for the caller to find."""
    with np.errstate(over="ignore"):
        single = np.ascontiguousarray(values, np.float32)
        if order is not ByteOrder.DEC:
            return single.astype(order.float32)
        words = (single * np.float32(4.0)).view(np.uint32)
    return ((words >> 16) | (words << 16)).astype("<u4").view("<f4")
