"""NumPy's .npz: positions, labels and rate as plain arrays, without pickled objects."""

import io
import math
import zipfile
import zlib
from pathlib import Path
from typing import Any

import numpy as np

from markermend.errors import UnreadableTake
from markermend.io.contents import (
    Contents,
    quoted,
    seen_only,
    sha256_of,
    unique_labels,
    unit_name,
    warned,
)
from markermend.io.format import Format, Reading
from markermend.io.limits import MOST_SAMPLES, check_size
from markermend.io.roles import roles_of
from markermend.model import Event, Role, Take

_NAMES = (
    *("positions", "labels", "rate", "units", "first_frame", "roles"),
    *("event_labels", "event_times_s", "event_contexts"),
)
"""What is read of an archive; whatever else is in it costs nothing."""
_MOST_BYTES = 32 * MOST_SAMPLES
_LAST_FRAME = 2**31
_ROLES: tuple[Role, ...] = ("measured", "unlabelled", "model")


def recognises(path: Path, head: bytes) -> bool:
    """Whether this is a zip archive with the extension .npz."""
    return path.suffix.lower() == ".npz" and head[:2] == b"PK"


def open_npz(path: Path, _reading: Reading) -> Contents:
    """Read arrays ``positions`` and, where present, ``labels rate units first_frame roles``.

    Raises
    ------
    UnreadableTake
        If the archive is broken, too large, or holds no positions.
    """
    arrays = _arrays(path)
    if "positions" not in arrays:
        raise UnreadableTake(f"{path.name} has no array 'positions'; give it that name.")
    positions = arrays["positions"]
    if positions.ndim != 3 or positions.shape[2] not in (2, 3) or positions.dtype.kind not in "fiu":
        raise UnreadableTake(
            f"positions must be numbers of shape (frames, markers, 2 or 3); {path.name} has "
            f"{positions.dtype} of shape {positions.shape}."
        )
    positions = positions.astype(np.float64)
    n_frames, n_points, n_dims = positions.shape
    if not n_frames or not n_points:
        raise UnreadableTake(
            f"{path.name} holds {n_frames} frames of {n_points} markers; a take has some of both."
        )
    first = _number(arrays, "first_frame") if "first_frame" in arrays else 1.0
    if first is None or not float(first).is_integer() or abs(first) > _LAST_FRAME:
        raise UnreadableTake(f"first_frame in {path.name} must be a whole number, such as 1.")
    check_size(n_frames, n_points)
    names = [str(name) for name in arrays.get("labels", np.array([])).ravel()]
    if not names:
        names = [f"point{i}" for i in range(1, n_points + 1)]
    if len(names) != n_points:
        raise UnreadableTake(f"{path.name} has {len(names)} labels for {n_points} markers.")
    labels = unique_labels(names)
    roles = tuple(str(role) for role in arrays.get("roles", np.array([])).ravel())
    fitting = len(roles) == n_points and set(roles) <= set(_ROLES)
    rate = _number(arrays, "rate")
    clean, odd = seen_only(positions, np.ones((n_frames, n_points), bool), zero_is_gap=False)
    return Contents(
        path=path,
        format="npz",
        sha256=sha256_of(path),
        positions=clean,
        rate=rate if rate is not None and np.isfinite(rate) and rate > 0 else None,
        units="px" if n_dims == 2 else unit_name(str(arrays.get("units", ""))),
        labels=labels,
        roles=roles if fitting else roles_of(labels, names),  # type: ignore[arg-type]
        first_frame=int(first),
        events=_events(arrays),
        warnings=warned(odd),
    )


def _arrays(path: Path) -> dict[str, np.ndarray[Any, Any]]:
    """Load all arrays, once their headers promise no more than the archive holds."""
    try:
        with zipfile.ZipFile(path) as archive:
            sizes = [
                _check_header(path, archive, member)
                for member in archive.infolist()
                if member.filename.removesuffix(".npy") in _NAMES
            ]
        if sum(sizes) > _MOST_BYTES:
            raise UnreadableTake(
                f"The arrays in {path.name} claim {sum(sizes) / 1e9:.1f} GB together, more than "
                "one take may have; cut the recording into parts."
            )
        with np.load(path, allow_pickle=False) as stored:
            return {name: stored[name] for name in stored.files if name in _NAMES}
    except UnreadableTake:
        raise
    # A broken archive raises almost anything; what zipfile and numpy document is here.
    except (OSError, ValueError, zipfile.BadZipFile, NotImplementedError, EOFError) as error:
        raise UnreadableTake(
            f"{path.name} is no archive of plain arrays: {quoted(str(error), 200)}."
        ) from None
    except (zlib.error, MemoryError, RuntimeError, KeyError) as error:
        raise UnreadableTake(
            f"{path.name} is a broken archive ({quoted(str(error), 200)})."
        ) from None


def _check_header(path: Path, archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> int:
    """Give the bytes that one array claims, once they are no more than are there."""
    with archive.open(member) as file:
        version = np.lib.format.read_magic(file)
        if version == (1, 0):
            shape, _, dtype = np.lib.format.read_array_header_1_0(file)
        elif version == (2, 0):
            shape, _, dtype = np.lib.format.read_array_header_2_0(file)
        else:
            raise ValueError(f"format version {version} of {member.filename}")
    if dtype.hasobject:
        raise ValueError(f"{member.filename} holds objects")
    size = math.prod(shape) * dtype.itemsize
    if size > min(member.file_size, _MOST_BYTES):
        raise UnreadableTake(
            f"{member.filename} in {path.name} claims {size / 1e9:.1f} GB, more than is there or "
            "than one take may have."
        )
    return size


def _number(arrays: dict[str, np.ndarray[Any, Any]], name: str) -> float | None:
    value = arrays.get(name)
    if value is None or value.size != 1 or value.dtype.kind not in "fiu":
        return None
    return float(value.ravel()[0])


def _events(arrays: dict[str, np.ndarray[Any, Any]]) -> tuple[Event, ...]:
    labels, times = arrays.get("event_labels"), arrays.get("event_times_s")
    contexts = arrays.get("event_contexts")
    if labels is None or times is None or contexts is None or times.dtype.kind != "f":
        return ()
    rows = zip(labels.ravel(), times.ravel(), contexts.ravel(), strict=False)
    return tuple(Event(str(label), float(time), str(context)) for label, time, context in rows)


def write_npz(take: Take) -> bytes:
    """Give the bytes of an archive from which `open_npz` reads the same take."""
    file = io.BytesIO()
    np.savez_compressed(
        file,
        positions=take.positions,
        rate=np.float64(take.rate),
        labels=np.array(take.labels, dtype=np.str_),
        units=np.array(take.units),
        first_frame=np.int64(take.first_frame),
        roles=np.array(take.roles, dtype=np.str_),
        event_labels=np.array([event.label for event in take.events], dtype=np.str_),
        event_times_s=np.array([event.time_s for event in take.events], dtype=np.float64),
        event_contexts=np.array([event.context for event in take.events], dtype=np.str_),
    )
    return file.getvalue()


FORMAT = Format(
    name="npz",
    title="NumPy .npz",
    extensions=(".npz",),
    recognises=recognises,
    open=open_npz,
    write=write_npz,
)
