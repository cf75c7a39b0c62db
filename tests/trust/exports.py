"""Exports of every public take: nothing but the accepted samples changes, to the byte."""

import hashlib
import re
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st
from tests.trust._frame import Budget, Outcome, Tally, public
from tests.trust._law import fault_of_sentence, opened

from markermend.errors import CannotWrite
from markermend.io import export
from markermend.io.c3d_layout import layout_in
from markermend.model import Span, Take

MINUTES = 12.0


class Lost(AssertionError):
    """What somebody recorded is gone."""


def run(budget: Budget) -> Iterator[Outcome]:
    """Yield one row for the binary takes and one for the text files."""
    files = public()
    if budget.short:
        files = [p for p in files if p.stat().st_size < 100_000][:4]
    for name, some in (
        ("C3D", [p for p in files if p.suffix.lower() == ".c3d"]),
        ("text", [p for p in files if p.suffix.lower() != ".c3d"]),
    ):
        tally = Tally(f"exports of public {name} takes: bytes, values, re-import")
        part = budget.share(0.6 if name == "C3D" else 1.0)
        refused = 0
        for i, path in enumerate(some):
            examples = budget.of(60 if path.stat().st_size < 10**6 else 15, 4)
            own = part.share(1 / (len(some) - i))
            refused += _property(path, examples, own, tally)
        if some:
            yield tally.outcome(f"{len(some)} takes, {refused} exports refused in a sentence")


@st.composite
def repairs(draw: st.DrawFn, n_frames: int, labels: tuple[str, ...], n_dims: int):
    """Draw accepted spans and what is put into them."""
    span = st.tuples(st.integers(0, n_frames - 1), st.integers(1, 60))
    place = st.one_of(st.floats(-1500, 1500), st.sampled_from([0.0, -0.0, 1e-30, np.nan]))
    one = st.tuples(st.integers(0, len(labels) - 1), span, place, st.floats(-40, 40), st.booleans())
    return draw(st.lists(one, min_size=1, max_size=6))


def _property(path: Path, examples: int, budget: Budget, tally: Tally) -> int:
    contents = opened(path)
    take = contents.take(units=contents.units or "mm", rate=contents.rate or 100.0)
    before = path.read_bytes()
    refused = 0

    @seed(budget.seed)
    @settings(
        max_examples=examples, deadline=None, database=None, phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )  # fmt: skip
    @given(repairs(take.n_frames, take.labels, take.n_dims))
    def check(drawn: list) -> None:
        nonlocal refused
        if budget.spent:
            return
        spans, repaired = _applied(take, drawn)
        with tempfile.TemporaryDirectory() as folder:
            target = Path(folder) / f"out{path.suffix}"
            try:
                written = export(take, repaired, target, spans)
            except CannotWrite as refusal:
                refused += 1
                fault = fault_of_sentence(str(refusal))
                assert not fault, fault
                assert not list(Path(folder).iterdir()), "something is left of a refused export"
            else:
                _compare(path, before, target, take, repaired, spans, written)
        if path.read_bytes() != before:
            raise Lost("the source changed")
        tally.case()

    try:
        check()
    except Exception as error:  # noqa: BLE001 - whatever is raised is a fault to report
        said = f"{path.name}: {type(error).__name__} {str(error)[:150]}"
        tally.case(said, lost=isinstance(error, Lost))
    return refused


def _applied(take: Take, drawn: list) -> tuple[list[tuple[str, Span]], Take]:
    positions, spans = take.positions.copy(), []
    for marker, (start, length), place, drift, on_top in drawn:
        span = Span(start, min(take.n_frames, start + length))
        ramp = np.linspace(0, drift, len(span))[:, None]
        base = positions[span.frames, marker] if on_top else np.full((len(span), 1), place)
        positions[span.frames, marker] = base + ramp
        spans.append((take.labels[marker], span))
    return spans, take.with_positions(positions)


def _compare(
    path: Path, before: bytes, target: Path, take: Take, repaired: Take,
    spans: list[tuple[str, Span]], written,
) -> None:  # fmt: skip
    after = target.read_bytes()
    assert hashlib.sha256(after).hexdigest() == written.sha256, "the hash is another"
    allowed = np.zeros(take.seen.shape, bool)
    for label, span in spans:
        allowed[span.frames, take.index(label)] = True
    touched = _touched(path, before, after, take)
    text = path.suffix.lower() != ".c3d"
    may = np.repeat(allowed.any(axis=1)[:, None], take.n_markers, axis=1) if text else allowed
    if touched is None or (touched & ~may).any():
        raise Lost("bytes outside the accepted samples changed")
    if text and _too_many(path, before, after, take, allowed):
        raise Lost("cells outside the accepted samples changed")
    listed = {*zip(map(int, written.frames), map(take.index, written.labels), strict=True)}
    if not text:
        assert listed == {*map(tuple, np.argwhere(touched).tolist())}, "the list is another"
    back = opened(target)
    again = back.take(units=back.units or "mm", rate=back.rate or 100.0)
    for what in ("labels", "roles", "rate", "units", "first_frame", "events"):
        assert getattr(again, what) == getattr(take, what), f"{what} read back otherwise"
    if not np.array_equal(again.positions[~allowed], take.positions[~allowed], equal_nan=True):
        raise Lost("samples outside the accepted spans read otherwise")
    assert np.array_equal(again.seen, repaired.seen), "seen otherwise than repaired"
    deviation = np.nanmax(np.abs(again.positions - repaired.positions), initial=0.0)
    assert deviation <= written.resolution_mm * 1.01, f"off by {deviation}"


def _touched(path: Path, before: bytes, after: bytes, take: Take) -> np.ndarray | None:
    """Find by arithmetic of our own which samples' bytes differ; None where others do."""
    touched = np.zeros(take.seen.shape, bool)
    if before == after:
        return touched
    if path.suffix.lower() == ".c3d":
        if len(before) != len(after):
            return None
        layout = layout_in(before)
        old, new = np.frombuffer(before, np.uint8), np.frombuffer(after, np.uint8)
        places = np.flatnonzero(old != new) - layout.data_start
        frame, within = np.divmod(places, layout.frame_bytes)
        point = within // (4 * layout.value_bytes)
        if (places < 0).any() or (frame >= take.n_frames).any() or (point >= take.n_markers).any():
            return None
        touched[frame, point] = True
        return touched
    return _touched_cells(path, before, after, take)


def _touched_cells(path: Path, before: bytes, after: bytes, take: Take) -> np.ndarray | None:
    """Of a text file, find the frames that differ, as if of all markers; see `_too_many`."""
    touched = np.zeros(take.seen.shape, bool)
    old, new = _rows(before, take), _rows(after, take)
    if old.head != new.head or old.tail != new.tail or len(old.rows) != len(new.rows):
        return None
    for frame, (one, two) in enumerate(zip(old.rows, new.rows, strict=True)):
        touched[frame] = one != two
    return touched


@dataclass(frozen=True)
class _Rows:
    head: bytes
    rows: list[bytes]
    tail: bytes


def _rows(data: bytes, take: Take) -> _Rows:
    """Cut a text file into its header, one line per frame, and the rest."""
    lines = data.split(b"\n")
    numeric = [_number(line) for line in lines]
    last = len(lines) - 1 - numeric[::-1].index(True)
    first = last - take.n_frames + 1
    return _Rows(b"\n".join(lines[:first]), lines[first : last + 1], b"\n".join(lines[last + 1 :]))


def _number(line: bytes) -> bool:
    head = re.split(rb"[\t,; ]", line.lstrip())[0].strip().strip(b'"')
    try:
        float(head)
    except ValueError:
        return False
    return True


def _too_many(path: Path, before: bytes, after: bytes, take: Take, allowed: np.ndarray) -> bool:
    """Whether a row of a text file has more cells that differ than its accepted samples have."""
    separator = b"," if path.suffix.lower() == ".csv" else b"\t"
    rows = zip(_rows(before, take).rows, _rows(after, take).rows, strict=True)
    for frame, (one, two) in enumerate(rows):
        if one == two:
            continue
        a, b = (row.rstrip(b"\r").split(separator) for row in (one, two))
        a += [b""] * (len(b) - len(a))
        differing = sum(x.strip() != y.strip() for x, y in zip(a, b, strict=True))
        if differing > take.n_dims * allowed[frame].sum():
            return True
    return False
