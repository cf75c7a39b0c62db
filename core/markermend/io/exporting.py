"""Give a take back to the lab: its own file with nothing changed but the repaired samples."""

import hashlib
import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from markermend.errors import BadInput, CannotWrite
from markermend.io.disk import load, refuse_existing, write_whole
from markermend.io.format import Patching, Reading, all_formats, format_for
from markermend.model import MM_PER_UNIT, BoolArray, FloatArray, Source, Span, Take, runs

Mode = Literal["patched", "copied", "rewritten"]

_ALWAYS_ANEW = "{} is always written anew."


@dataclass(frozen=True, eq=False)
class Written:
    """What was written, and what a second reading of both files found changed.

    Attributes
    ----------
    path, sha256
        The new file and the hash of its bytes.
    mode
        ``"patched"``: the source's bytes with only the listed samples changed; ``"copied"``: the
        source's bytes; ``"rewritten"``: a file of its own, with what the take knows.
    why
        Why it was written anew, one sentence; empty where it was not.
    source_sha256
        Hash of the source, or None where there was none.
    frames, labels, old, new
        One entry per changed sample: frame (n,), marker (n,), and position before and after,
        (n, n_dims) in mm (px in two dimensions), NaN = not seen. Where a file was written anew
        from nothing, none.
    resolution_mm
        Largest step between two numbers that the file can hold at the changed samples.
    deviation_mm
        Largest distance between a repaired position and what the file holds of it.
    """

    path: Path
    mode: Mode
    sha256: str
    why: str = ""
    source_sha256: str | None = None
    frames: NDArray[np.intp] = field(default_factory=lambda: np.zeros(0, np.intp))
    labels: tuple[str, ...] = ()
    old: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    new: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    resolution_mm: float = 0.0
    deviation_mm: float = 0.0

    @property
    def n_changed(self) -> int:
        """Number of changed samples."""
        return len(self.frames)

    @cached_property
    def spans(self) -> tuple[tuple[str, Span], ...]:
        """The changed samples as spans, by marker and time."""
        frames: dict[str, list[int]] = {}
        for label, frame in zip(self.labels, self.frames, strict=True):
            frames.setdefault(label, []).append(int(frame))
        found = []
        for label, changed in frames.items():
            mask = np.zeros(max(changed) + 1, bool)
            mask[changed] = True
            found += [(label, span) for span in runs(mask)]
        return tuple(found)

    def to_json(self) -> dict[str, Any]:
        """Give it as strict JSON, every changed sample listed."""
        return {
            "path": str(self.path),
            "mode": self.mode,
            "why": self.why,
            "sha256": self.sha256,
            "source_sha256": self.source_sha256,
            "n_changed": self.n_changed,
            "resolution_mm": self.resolution_mm,
            "deviation_mm": self.deviation_mm,
            "changed": [
                {
                    "marker": label,
                    "frame": int(frame),
                    "old": [round(x, 6) if math.isfinite(x) else None for x in old.tolist()],
                    "new": [round(x, 6) if math.isfinite(x) else None for x in new.tolist()],
                }
                for label, frame, old, new in zip(
                    self.labels, self.frames, self.old, self.new, strict=True
                )
            ],
        }


def export(
    original: Take,
    repaired: Take,
    path: str | Path,
    spans: Iterable[tuple[str, Span]],
    *,
    overwrite: bool = False,
) -> Written:
    """Write a repaired take, by patching its source file wherever that is possible.

    The new file is read again from the disk before it gets its name, and compared with the source:
    every sample that differs lies in `spans`, and nothing else differs.

    Parameters
    ----------
    original
        The take as `markermend.read` gave it.
    repaired
        The same take with other positions in `spans`.
    path
        The target; its extension chooses the format.
    spans
        ``(label, span)`` of everything that may have changed.
    overwrite
        Whether an existing target is replaced; the source never is.

    Raises
    ------
    BadInput
        If the takes do not fit together, or differ outside the spans.
    CannotWrite
        If the source has changed since it was read, the format cannot hold the new positions, the
        disk refuses, or the verification finds anything but what was asked for.
    """
    path = Path(path)
    changed = _changes(original, repaired)
    _refuse_outside(original, changed, spans)
    return _export(original, repaired, path, changed, overwrite)


def write(take: Take, path: str | Path, *, overwrite: bool = False) -> Written:
    """Write a take, by patching the file it came from where that is possible.

    Parameters
    ----------
    take
        The take; where it came from a file, that file must be as it was.
    path
        The target; its extension chooses the format.
    overwrite
        Whether an existing target is replaced; the source never is.

    Returns
    -------
    written
        Says whether the file was patched or written anew, and why; and lists what changed.

    Raises
    ------
    CannotWrite
        As in `export`.
    """
    path = Path(path)
    if take.source is None:
        return _rewrite(take, path, "The take did not come from a file.", overwrite)
    original = _as_read(take, take.source)
    if isinstance(original, str):
        return _rewrite(take, path, original, overwrite)
    return _export(original, take, path, _changes(original, take), overwrite)


def _changes(original: Take, repaired: Take) -> BoolArray:
    """(n_frames, n_markers): where the positions differ."""
    if original.labels != repaired.labels or original.positions.shape != repaired.positions.shape:
        raise BadInput("The repaired take has other markers or frames than the original.")
    return ~_same(original.positions, repaired.positions)


def _refuse_outside(take: Take, changed: BoolArray, spans: Iterable[tuple[str, Span]]) -> None:
    allowed = np.zeros_like(changed)
    for label, span in spans:
        allowed[span.frames, take.index(label)] = True
    outside = changed & ~allowed
    if outside.any():
        frame, marker = (int(i) for i in np.argwhere(outside)[0])
        raise BadInput(
            f"{outside.sum()} samples differ outside the accepted spans, the first of them "
            f"{take.labels[marker]} in frame {frame}; only repaired spans may change."
        )


def _export(
    original: Take, repaired: Take, path: Path, changed: BoolArray, overwrite: bool
) -> Written:
    source = original.source
    if source is None:
        return _rewrite(repaired, path, "The take did not come from a file.", overwrite)
    _refuse_source(path, source)
    refuse_existing(path, overwrite=overwrite)
    format_ = next(f for f in all_formats() if f.name == source.format)
    target = format_for(path)
    if target is not None and target.name != format_.name and path.suffix not in format_.extensions:
        why = f"The source is {format_.title}, the target {target.title}."
        return _rewrite(repaired, path, why, overwrite)
    if not changed.any():
        data = _unchanged_bytes(source)
        write_whole(path, data, overwrite=overwrite)
        return Written(path, "copied", source.sha256, source_sha256=source.sha256)
    if format_.patching is None:
        return _rewrite(repaired, path, _ALWAYS_ANEW.format(format_.title), overwrite)
    return _patch(format_.patching, source, original, repaired, path, changed, overwrite)


def _patch(
    patching: Patching,
    source: Source,
    original: Take,
    repaired: Take,
    path: Path,
    changed: BoolArray,
    overwrite: bool,
) -> Written:
    data = _unchanged_bytes(source)
    factor = MM_PER_UNIT.get(source.units, 1.0)
    reading = _reading_of(original, patching, data, factor)
    patch = patching.patch(data, reading, repaired.positions / factor, changed)
    found: list[Written] = []

    def verify(written: Path) -> None:
        new_data = load(written)
        differs = patching.compare(data, new_data, reading)
        if differs is None or (differs & ~changed).any():
            raise CannotWrite(
                "The verification found more changed than what was repaired; nothing was written."
            )
        everything = patching.positions(new_data, reading)
        if everything.shape != repaired.positions.shape:
            raise CannotWrite(
                "The repaired file would be read with other frames or markers, because of what "
                "its rows look like; export the take in another format."
            )
        after = everything[changed] * factor
        wanted = repaired.positions[changed]
        deviation = float(np.nanmax(np.abs(after - wanted), initial=0.0))
        if (np.isnan(after) != np.isnan(wanted)).any() or (
            deviation > patch.resolution * factor * 1.01
        ):
            raise CannotWrite(
                "The verification found repaired samples that do not read back as they should; "
                "nothing was written."
            )
        frames, markers = np.nonzero(differs)
        found.append(
            Written(
                path=path,
                mode="patched",
                sha256=hashlib.sha256(new_data).hexdigest(),
                source_sha256=source.sha256,
                frames=frames,
                labels=tuple(original.labels[m] for m in markers),
                old=original.positions[frames, markers],
                new=after[differs[changed]],
                resolution_mm=patch.resolution * factor,
                deviation_mm=deviation,
            )
        )

    write_whole(path, patch.data, overwrite=overwrite, check=verify)
    return found[0]


def _reading_of(original: Take, patching: Patching, data: bytes, factor: float) -> Reading:
    """Find the way of reading by which the file gives the original take."""
    for reading in (Reading(), Reading(ignore_residuals=True)):
        stored = patching.positions(data, reading)
        stored *= factor
        if stored.shape == original.positions.shape and _same(stored, original.positions).all():
            return reading
    raise CannotWrite(
        "The original take is not what its file holds; read the file again and repeat the repairs."
    )


def _same(one: FloatArray, other: FloatArray) -> BoolArray:
    """(n_frames, n_markers): where two arrays are equal, NaN being equal to NaN."""
    same = np.ones(one.shape[:2], bool)
    for x, y in zip(np.moveaxis(one, 2, 0), np.moveaxis(other, 2, 0), strict=True):
        same &= (x == y) | (np.isnan(x) & np.isnan(y))
    return same


def _as_read(take: Take, source: Source) -> Take | str:
    """Read the source again as it was read, or say why it cannot be patched."""
    format_ = next(f for f in all_formats() if f.name == source.format)
    if not source.path.exists():
        return f"The source {source.path.name} is no longer there."
    if format_.patching is None:
        return _ALWAYS_ANEW.format(format_.title)
    _unchanged_bytes(source)
    for ignore in (False, True):
        contents = format_.open(source.path, Reading(ignore, second_opinion=False))
        original = contents.take(units=source.units, rate=source.rate)
        if original.labels != take.labels or original.positions.shape != take.positions.shape:
            return "The take has other markers or frames than its source."
        if original.seen.any() or not take.seen.any():
            break
    if original.rate != take.rate or original.units != take.units:
        return "The take has another rate or unit than its source."
    return original


def _unchanged_bytes(source: Source) -> bytes:
    try:
        data = load(source.path)
    except OSError as error:
        raise CannotWrite(
            f"The source {source.path} cannot be read again: {error.strerror or error}."
        ) from None
    if hashlib.sha256(data).hexdigest() != source.sha256:
        raise CannotWrite(
            f"The source {source.path.name} has changed since it was read; read it again and "
            "repeat the repairs."
        )
    return data


def _refuse_source(path: Path, source: Source) -> None:
    if path.exists() and source.path.exists() and path.samefile(source.path):
        raise CannotWrite(f"{path} is the source, which is never overwritten; choose another name.")


def _rewrite(take: Take, path: Path, why: str, overwrite: bool) -> Written:
    if take.source is not None:
        _refuse_source(path, take.source)
    refuse_existing(path, overwrite=overwrite)
    format_ = format_for(path)
    if format_ is None or format_.write is None:
        known = [ext for f in all_formats() if f.write for ext in f.extensions]
        raise CannotWrite(
            f"A take cannot be written anew as {path.name!r}; give it one of the extensions "
            f"{', '.join(known)}."
        )
    data = format_.write(take)
    write_whole(path, data, overwrite=overwrite)
    return Written(
        path,
        "rewritten",
        hashlib.sha256(data).hexdigest(),
        f"{why} The new file holds what the take knows and nothing else.",
        take.source.sha256 if take.source else None,
    )
