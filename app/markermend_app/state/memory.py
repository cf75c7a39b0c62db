"""Memory that is not used is given back to the system, where the C library does not by itself.

With glibc, what was freed stays with the process in as many heaps as there are threads, and after
the first large array even large ones come from there.
"""

import ctypes
import gc
from contextlib import suppress

MMAP_THRESHOLD, ARENA_MAX = -3, -8  # from glibc's malloc.h
LARGE_BYTES = 1_000_000
HEAPS = 2


def keep_little() -> None:
    """Let large arrays come from the system each by itself, and go back when they are freed."""
    with suppress(OSError, AttributeError):
        library = ctypes.CDLL(None)
        library.mallopt(MMAP_THRESHOLD, LARGE_BYTES)
        library.mallopt(ARENA_MAX, HEAPS)


def give_back() -> None:
    """Give memory that is not used back to the system, also what only refers to itself."""
    gc.collect()
    with suppress(OSError, AttributeError):
        ctypes.CDLL(None).malloc_trim(0)
