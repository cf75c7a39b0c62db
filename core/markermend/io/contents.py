"""What a file holds before its unit and its rate are known."""

import hashlib
import math
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import reduce
from pathlib import Path

import numpy as np

from markermend.errors import BadInput, Lacking, legible
from markermend.model import MM_PER_UNIT, BoolArray, Event, FloatArray, Role, Source, Take

FARTHEST = 1e7
"""Coordinates beyond this, in whatever unit, are no positions: ten kilometres in mm."""

LONGEST_LABEL = 256
"""Characters; the rest of a longer label is cut off."""

_LONGEST_QUOTE = 60

_UNIT_NAMES = {
    "mm": "mm",
    "millimeter": "mm",
    "millimeters": "mm",
    "millimetre": "mm",
    "millimetres": "mm",
    "cm": "cm",
    "centimeter": "cm",
    "centimeters": "cm",
    "centimetre": "cm",
    "centimetres": "cm",
    "m": "m",
    "meter": "m",
    "meters": "m",
    "metre": "m",
    "metres": "m",
    "px": "px",
    "pixel": "px",
    "pixels": "px",
}


@dataclass(frozen=True, eq=False)
class Contents:
    """A file as it is read, in its own unit.

    Attributes
    ----------
    path, format, sha256
        The file, its format, and the hash of its bytes.
    positions
        (n_frames, n_points, n_dims) in the file's own unit, NaN = not seen.
    rate
        Hz, or None where the file does not say it.
    units
        ``"mm"``, ``"cm"``, ``"m"`` or ``"px"``, or None where the file does not say it.
    labels, roles
        One unique name, and one role, per point.
    first_frame
        Number that the file gives its first frame.
    events, warnings
        What else the file says, and what is odd in it.
    """

    path: Path
    format: str
    sha256: str
    positions: FloatArray
    rate: float | None
    units: str | None
    labels: tuple[str, ...]
    roles: tuple[Role, ...]
    first_frame: int = 1
    events: tuple[Event, ...] = ()
    warnings: tuple[str, ...] = ()

    @property
    def n_frames(self) -> int:
        """Number of frames."""
        return int(self.positions.shape[0])

    @property
    def n_points(self) -> int:
        """Number of trajectories of whatever role."""
        return int(self.positions.shape[1])

    def take(self, *, units: str | None = None, rate: float | None = None) -> Take:
        """Make a take of it.

        Parameters
        ----------
        units, rate
            What the file lacks; where the file says it itself and says otherwise, the value given
            here is used, with a warning.

        Raises
        ------
        Lacking
            If neither the file nor the caller says the unit or the rate.
        BadInput
            If `units` or `rate` is impossible.
        """
        warnings = list(self.warnings)
        if units is not None and units not in (*MM_PER_UNIT, "px"):
            raise BadInput(f"units must be mm, cm, m or px; got {units!r}.")
        if rate is not None and not (math.isfinite(rate) and rate > 0):
            raise BadInput(f"rate must be a positive number of Hz; got {rate}.")
        if units is not None and self.units is not None and units != self.units:
            warnings.append(f"The file says {self.units}; {units} was used, as told.")
        if rate is not None and self.rate is not None and not math.isclose(rate, self.rate):
            warnings.append(f"The file says {self.rate:g} Hz; {rate:g} Hz was used, as told.")
        chosen_units, chosen_rate = units or self.units, rate or self.rate
        if chosen_units is None:
            raise Lacking(
                f"{self.path.name} does not say its unit; give it with --units mm|cm|m.", "units"
            )
        if chosen_rate is None:
            raise Lacking(
                f"{self.path.name} does not say its rate; give it with --rate HZ.", "rate"
            )
        return Take(
            self.positions,
            chosen_rate,
            self.labels,
            chosen_units,
            self.first_frame,
            self.roles,
            Source(self.path, self.format, self.sha256, chosen_units, chosen_rate),
            self.events,
            warnings,
        )


def unit_name(said: str | None) -> str | None:
    """Normalise how a file calls its unit; None where it says none that is known."""
    return _UNIT_NAMES.get((said or "").strip().strip("[]()").lower())


def unique_labels(names: Sequence[str]) -> tuple[str, ...]:
    """Make labels unique in file order: ``NAME``, ``NAME#2``, ``NAME#3``.

    A point without a name becomes ``*n``, n its 1-based place, as programs name a trajectory that
    nobody labelled. What cannot be seen in a label is left out, and a very long one is cut.
    """
    cut = (quoted(name, LONGEST_LABEL) for name in names)
    named = [name or f"*{i}" for i, name in enumerate(cut, 1)]
    taken, counts, labels = set(named), Counter[str](), []
    for name in named:
        counts[name] += 1
        label = name
        if counts[name] > 1:
            label = f"{name}#{counts[name]}"
            while label in taken:
                counts[name] += 1
                label = f"{name}#{counts[name]}"
            taken.add(label)
        labels.append(label)
    return tuple(labels)


def quoted(text: str, longest: int = _LONGEST_QUOTE) -> str:
    """Give what a file says as a label or a message may show it: legible, and not too long."""
    if len(text) > longest:
        text = f"{text[: longest - 1]}…"
    return legible(text).strip()


def seen_only(
    positions: FloatArray, seen: BoolArray, *, zero_is_gap: bool = True
) -> tuple[FloatArray, tuple[str, ...]]:
    """Set to NaN what was not seen, or cannot be a position, and say what was odd.

    Parameters
    ----------
    positions
        (n_frames, n_points, n_dims) as stored.
    seen
        (n_frames, n_points): what the file marks as valid.
    zero_is_gap
        Whether 0, 0, 0 (in 2-D 0, 0) means not seen, as many programs write it.
    """
    # By coordinate: reducing over an axis of three is many times slower in NumPy.
    axes = [positions[..., k] for k in range(positions.shape[2])]
    with np.errstate(invalid="ignore"):
        possible = reduce(np.logical_and, [np.abs(axis) <= FARTHEST for axis in axes])
    bad = seen & ~possible
    absurd = bad.copy()
    absurd[bad] = ~np.isnan(positions[bad]).all(axis=1)
    lost = ~seen | bad
    if zero_is_gap:
        lost |= reduce(np.logical_and, [axis == 0 for axis in axes])
    clean = positions.astype(np.float64)
    clean[lost] = np.nan
    warnings = []
    if absurd.any():
        warnings.append(
            "Samples with coordinates that are infinite, half missing or farther than "
            f"{FARTHEST:.0e} count as not seen: {absurd.sum()}."
        )
    if positions.size and lost.all():
        warnings.append("No marker is seen in any frame.")
    return clean, tuple(warnings)


def sha256_of(path: Path) -> str:
    """Hash the bytes of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def warned(contents: Iterable[str]) -> tuple[str, ...]:
    """Keep each warning once, in order, without what cannot be seen."""
    return tuple(dict.fromkeys(map(legible, contents)))
