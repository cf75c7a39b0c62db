"""C3D, the binary format of most motion capture systems."""

import hashlib
import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from markermend.errors import CannotWrite
from markermend.io import second_reader
from markermend.io.c3d_layout import MOST_BY_EZC3D, C3DLayout, layout_in, read_layout
from markermend.io.c3d_numbers import from_floats, to_floats
from markermend.io.c3d_writer import write_c3d
from markermend.io.contents import (
    Contents,
    quoted,
    seen_only,
    unique_labels,
    unit_name,
    warned,
)
from markermend.io.format import Format, Patch, Patching, Reading
from markermend.io.limits import check_size
from markermend.io.roles import listed_outputs, roles_of
from markermend.model import BoolArray, Event, FloatArray

_NOT_SEEN = -1
_CAMERAS = 0x7F00
_FLOAT_STEP = 1e-20


def recognises(_path: Path, head: bytes) -> bool:
    """Whether the first block has the mark of C3D."""
    return len(head) >= 512 and head[1] == 0x50 and head[0] >= 2 and b"\n" not in head[:2]


def open_c3d(path: Path, reading: Reading) -> Contents:
    """Read a C3D file and let ezc3d, in a process of its own, read it as well.

    Raises
    ------
    UnreadableTake
        If the file holds no points that can be read.
    """
    layout = read_layout(path)
    check_size(layout.n_frames, layout.n_points)
    data = np.memmap(path, np.uint8, "r")
    stored, words = layout.samples(data)
    seen, residual_warnings = _seen(stored, words, reading)
    positions, odd = seen_only(stored, seen)
    names, label_warnings = _names(layout)
    labels = unique_labels(names)
    texts = layout.parameters.texts
    said_unit = next(iter(texts.get("POINT:UNITS", ())), "")
    units = unit_name(said_unit)
    unknown = said_unit and units is None
    unit_warnings = [f"The file's unit {quoted(said_unit)!r} is not known."] if unknown else []
    return Contents(
        path=path,
        format="c3d",
        sha256=hashlib.sha256(data.data).hexdigest(),
        positions=positions,
        rate=layout.rate,
        units=units,
        labels=labels,
        roles=roles_of(labels, names, listed_outputs(texts)),
        first_frame=layout.first_frame,
        events=_events(layout),
        warnings=warned(
            (
                *layout.warnings,
                *label_warnings,
                *unit_warnings,
                *residual_warnings,
                *odd,
                *(_second_opinion(path, layout, stored, words) if reading.second_opinion else ()),
            )
        ),
    )


def _seen(
    positions: FloatArray, words: NDArray[np.int32], reading: Reading
) -> tuple[BoolArray, list[str]]:
    """Tell what was seen: residual not negative, unless residuals are to be ignored."""
    if reading.ignore_residuals:
        return np.ones(words.shape, bool), []
    seen = words >= 0
    warnings = []
    if words.size and not seen.any() and np.nan_to_num(positions).any():
        warnings.append(
            "Every sample is marked as not seen (residual -1), as some programs write; if these "
            "are real positions, read them with --ignore-residuals."
        )
    return seen, warnings


def _names(layout: C3DLayout) -> tuple[list[str], list[str]]:
    """Give one name per point as the file has them, empty where it has none."""
    said = layout.parameters.texts_continued("POINT:LABELS")
    names = list(said[: layout.n_points])
    warnings = []
    if len(said) < layout.n_points:
        warnings.append(
            f"The file names {len(said)} of its {layout.n_points} points; the others are called *n."
        )
        names += [""] * (layout.n_points - len(said))
    if not any(names):
        names = [f"point{i}" for i in range(1, layout.n_points + 1)]
    doubles = len([name for name in names if name]) - len({name for name in names if name})
    if doubles:
        warnings.append(f"{doubles} labels occur more than once and are numbered, as in NAME#2.")
    return names, warnings


def _events(layout: C3DLayout) -> tuple[Event, ...]:
    """Read the group EVENT, or the events of the header where there is none."""
    texts, numbers = layout.parameters.texts, layout.parameters.numbers
    labels, contexts = texts.get("EVENT:LABELS", ()), texts.get("EVENT:CONTEXTS", ())
    times = numbers.get("EVENT:TIMES", ())
    if not labels:
        return tuple(Event(label, time) for label, time in layout.header_events)
    events = []
    for i, (minutes, seconds) in enumerate(zip(times[::2], times[1::2], strict=False)):
        time = 60 * minutes + seconds
        if i < len(labels) and math.isfinite(time):
            events.append(Event(labels[i], time, contexts[i] if i < len(contexts) else ""))
    return tuple(events)


def _second_opinion(
    path: Path, layout: C3DLayout, positions: FloatArray, words: NDArray[np.int32]
) -> list[str]:
    """Say where ezc3d reads the file otherwise."""
    if layout.n_frames >= MOST_BY_EZC3D:
        return []
    opinion = second_reader.ask(path)
    if opinion.positions is None:
        return [f"ezc3d {opinion.trouble}; the file was read without it."]
    ours = np.where((words >= 0)[..., None], positions, np.nan)
    theirs = opinion.positions
    if theirs.shape == ours.shape:
        tolerance = 1e-5 * max(1.0, float(np.abs(np.nan_to_num(ours, posinf=0, neginf=0)).max()))
        same = np.isclose(ours, theirs, rtol=1e-5, atol=tolerance, equal_nan=True)
        if same.all():
            return []
        differing = f"{(~same.all(axis=2)).sum()} samples"
    else:
        frames, points = theirs.shape[:2]
        differing = f"{frames} frames of {points} points"
    sentence = (
        f"ezc3d reads this file otherwise ({differing}); what fits the file's size was taken: "
        f"{layout.n_frames} frames of {layout.n_points} points with {layout.n_analog} analog "
        "values each."
    )
    return [sentence]


def positions_in(data: bytes, reading: Reading) -> FloatArray:
    """Decode the points of a file's bytes."""
    layout = layout_in(data)
    stored, words = layout.samples(np.frombuffer(data, np.uint8))
    seen, _ = _seen(stored, words, reading)
    return seen_only(stored, seen)[0]


def compare(old: bytes, new: bytes, _reading: Reading) -> BoolArray | None:
    """Find the samples whose bytes differ; None where any other byte does."""
    layout = layout_in(old)
    if len(old) != len(new):
        return None
    before, after = np.frombuffer(old, np.uint8), np.frombuffer(new, np.uint8)
    start, stop = layout.data_start, layout.data_start + layout.n_frames * layout.frame_bytes
    if (before[:start] != after[:start]).any() or (before[stop:] != after[stop:]).any():
        return None
    rows = (layout.n_frames, layout.frame_bytes)
    differs = before[start:stop].reshape(rows) != after[start:stop].reshape(rows)
    found = np.zeros((layout.n_frames, layout.n_points), bool)
    touched = differs.any(axis=1)
    points, analog = np.split(differs[touched], [4 * layout.value_bytes * layout.n_points], axis=1)
    if analog.any():
        return None
    found[touched] = points.reshape(len(points), layout.n_points, -1).any(axis=2)
    return found


def patch(data: bytes, reading: Reading, positions: FloatArray, changed: BoolArray) -> Patch:
    """Write changed samples into a copy of the bytes: X, Y, Z and the residual word.

    A repaired sample becomes valid with residual 0, which in C3D means computed and not measured;
    the cameras that saw the marker stay noted. A sample set to NaN becomes not valid.
    """
    layout = layout_in(data)
    new = bytearray(data)
    target = layout.stored(np.frombuffer(new, np.uint8))
    frames, points = np.nonzero(changed)
    values = positions[frames, points]
    gone = np.asarray(~np.isfinite(values).all(axis=1))
    old = layout.words(target[frames, points, 3])
    word = np.where(gone, _NOT_SEEN, np.where(old < 0, 0, old & _CAMERAS))
    if reading.ignore_residuals:
        word = old
    values[gone] = 0.0
    encoded, resolution = _encoded(layout, _off_zero(values, ~gone, layout))
    stored_words = word.astype(layout.order.int16)
    if layout.is_float:
        stored_words = from_floats(word.astype(np.float32), layout.order)
    target[frames, points, :3] = encoded
    target[frames, points, 3] = stored_words
    return Patch(new, resolution)


def _off_zero(values: FloatArray, seen: BoolArray, layout: C3DLayout) -> FloatArray:
    """Move what would be stored as 0, 0, 0 by the least step: that means a gap in many files."""
    step = _FLOAT_STEP if layout.is_float else layout.scale
    zero = seen & (np.abs(values) <= step / 2).all(axis=1)
    moved = values.copy()
    moved[zero, 0] = np.where(values[zero, 0] < 0, -step, step)
    return moved


def _encoded(layout: C3DLayout, values: FloatArray) -> tuple[NDArray[np.generic], float]:
    """Encode values in the file's number format, and give the resolution there."""
    if layout.is_float:
        encoded = from_floats(values, layout.order)
        back = to_floats(encoded, layout.order)
        if not np.allclose(back, values, rtol=1e-6, atol=1e-30):
            raise CannotWrite("A repaired coordinate is larger than the C3D file's floats can be.")
        return encoded, float(np.spacing(np.abs(back)).max(initial=_FLOAT_STEP))
    steps = np.rint(values / layout.scale)
    if (np.abs(steps) > 32767).any():
        raise CannotWrite(
            f"A repaired coordinate is beyond +-{32767 * layout.scale:.0f}, the most that this "
            "file of 16-bit integers can hold; export it in another format."
        )
    return steps.astype(layout.order.int16), layout.scale


FORMAT = Format(
    name="c3d",
    title="C3D",
    extensions=(".c3d",),
    recognises=recognises,
    open=open_c3d,
    patching=Patching(positions_in, patch, compare),
    write=write_c3d,
)
