"""An export is the source with nothing changed but the repaired samples."""

import io
import os
import tempfile
import zipfile
from collections.abc import Callable
from functools import cache
from pathlib import Path

import ezc3d
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from markermend import Span, Take, read, write
from markermend.errors import BadInput, CannotWrite
from markermend.io import Reading, export
from markermend.io.c3d_layout import read_layout
from markermend.io.disk import write_whole
from markermend.io.format import format_of

FILES = {
    "public/pair_gait_raw_dec_int.c3d": "mm",
    "public/sample02_dec_real.c3d": "mm",
    "public/sample02_pc_int.c3d": "mm",
    "odd/sgi_real.c3d": "mm",
    "odd/labels_mismatch_kyowa.c3d": "mm",
    "public/raw_qualisys_walk_zero_gaps_1_5.c3d": "mm",
    "public/raw_racing_wheelchair_gaps_metres.c3d": "m",
    "public/qualisys_c3d_events.c3d": "mm",
}


def opened(path: Path, units: str | None = None) -> Take:
    """Read without the second reader, which exports have no need of."""
    return format_of(path).open(path, Reading(second_opinion=False)).take(units=units)


@pytest.fixture(scope="module")
def takes(shared: Path) -> Callable[[str], Take]:
    return cache(lambda name: opened(shared / "data" / name))


def repairs(take: Take, seed: int, n_spans: int) -> tuple[list[tuple[str, Span]], Take]:
    """Move some spans somewhere else: anywhere, to the origin, along a line, or out of sight."""
    rng = np.random.default_rng(seed)
    spans = []
    positions = take.positions.copy()
    for _ in range(n_spans):
        marker, start = int(rng.integers(take.n_markers)), int(rng.integers(take.n_frames))
        span = Span(start, min(take.n_frames, start + int(rng.integers(1, 50))))
        place = rng.choice([rng.uniform(-1500, 1500), 0.0, -0.0, 1e-30, np.nan])
        drift = np.linspace(0, rng.choice([0.0, 40.0]), len(span))
        positions[span.frames, marker] = place + drift[:, None]
        spans.append((take.labels[marker], span))
    return spans, take.with_positions(positions)


@pytest.mark.parametrize("name", FILES)
@settings(max_examples=6, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), n_spans=st.integers(1, 6))
def test_every_other_byte_is_unchanged(
    name: str, takes: Callable[[str], Take], shared: Path, seed: int, n_spans: int
) -> None:
    take = takes(name)
    spans, repaired = repairs(take, seed, n_spans)
    source = shared / "data" / name
    with tempfile.TemporaryDirectory() as folder:
        written = export(take, repaired, Path(folder) / "out.c3d", spans)
        new = np.fromfile(written.path, np.uint8)
        back = opened(written.path, FILES[name])
    # Own arithmetic of offsets, apart from the code under test.
    old, layout = np.fromfile(source, np.uint8), read_layout(source)
    assert old.size == new.size
    places = np.flatnonzero(old != new)
    frame, within = np.divmod(places - layout.data_start, layout.frame_bytes)
    point = within // (4 * layout.value_bytes)
    assert (places >= layout.data_start).all()
    touched = {(int(f), take.labels[p]) for f, p in zip(frame, point, strict=True)}
    allowed = {(f, label) for label, span in spans for f in range(span.start, span.stop)}
    assert touched <= allowed
    assert touched == set(zip(map(int, written.frames), written.labels, strict=True))
    # What was asked for is what anyone reads, within the resolution of the file.
    assert np.array_equal(back.seen, repaired.seen)
    deviation = np.abs(back.positions - repaired.positions)
    assert np.nanmax(deviation, initial=0) <= written.resolution_mm * 1.01
    untouched = np.ones(take.seen.shape, bool)
    for label, span in spans:
        untouched[span.frames, take.index(label)] = False
    assert np.array_equal(back.positions[untouched], take.positions[untouched], equal_nan=True)


@pytest.mark.parametrize("name", FILES)
def test_nothing_repaired_gives_the_same_bytes(
    name: str, takes: Callable[[str], Take], shared: Path, tmp_path: Path
) -> None:
    take = takes(name)
    written = write(take, tmp_path / "same.c3d")
    assert written.mode == "copied"
    assert (tmp_path / "same.c3d").read_bytes() == (shared / "data" / name).read_bytes()


@pytest.fixture
def gait(shared: Path, tmp_path: Path) -> Take:
    source = tmp_path / "source.c3d"
    source.write_bytes((shared / "data/public/pair_gait_raw_dec_int.c3d").read_bytes())
    return opened(source)


def moved(take: Take, frame: int = 50, by: float = 20.0) -> tuple[Take, list[tuple[str, Span]]]:
    marker = int(np.flatnonzero(take.seen[frame])[0])
    positions = take.positions.copy()
    positions[frame, marker] += by
    return take.with_positions(positions), [(take.labels[marker], Span(frame, frame + 1))]


def test_the_record_lists_what_changed(gait: Take, tmp_path: Path) -> None:
    repaired, spans = moved(gait)
    written = export(gait, repaired, tmp_path / "out.c3d", spans)
    assert written.mode == "patched"
    assert written.spans == tuple(spans)
    np.testing.assert_allclose(written.new - written.old, 20.0, atol=0.17)
    assert written.resolution_mm == pytest.approx(0.16682935)
    assert 0 < written.deviation_mm <= written.resolution_mm / 2
    assert written.source_sha256 == gait.source.sha256
    assert written.to_json()["n_changed"] == 1


def test_a_repaired_sample_is_marked_as_computed(gait: Take, tmp_path: Path) -> None:
    repaired, spans = moved(gait)
    written = export(gait, repaired, tmp_path / "out.c3d", spans)

    def word(path: Path) -> int:
        layout = read_layout(path)
        _, words = layout.samples(np.fromfile(path, np.uint8))
        return int(words[50, gait.index(spans[0][0])])

    before, after = word(gait.source.path), word(written.path)
    assert before & 0xFF > 0
    assert after == before & 0x7F00  # residual 0: computed; the cameras stay noted


@pytest.mark.parametrize("name", [n for n in FILES if n.startswith("public")])
def test_ezc3d_sees_the_repaired_samples_and_no_others(
    name: str, takes: Callable[[str], Take], shared: Path, tmp_path: Path
) -> None:
    take = takes(name)
    spans, repaired = repairs(take, seed=5, n_spans=3)
    export(take, repaired, tmp_path / "out.c3d", spans)
    before, after = (
        ezc3d.c3d(str(path))["data"] for path in (shared / "data" / name, tmp_path / "out.c3d")
    )
    mine = ~np.isclose(take.positions, repaired.positions, atol=1e-3, equal_nan=True).all(axis=2)
    foreign = np.stack([before["points"], after["points"]])[:, :3].transpose(0, 3, 2, 1)
    changed = ~((foreign[0] == foreign[1]) | np.isnan(foreign).all(axis=0)).all(axis=2)
    assert mine.any()
    assert (changed[mine] | ~repaired.seen[mine]).all()
    assert not (changed & ~mine).any()
    assert np.array_equal(before["analogs"], after["analogs"])
    residuals = after["meta_points"]["residuals"][0].T
    assert (residuals[mine & repaired.seen] >= 0).all()


def test_samples_outside_the_spans_are_refused(gait: Take, tmp_path: Path) -> None:
    repaired, spans = moved(gait)
    with pytest.raises(BadInput, match="outside the accepted spans"):
        export(gait, repaired, tmp_path / "out.c3d", [(spans[0][0], Span(0, 50))])
    assert not (tmp_path / "out.c3d").exists()


def test_a_source_that_changed_is_refused(gait: Take, tmp_path: Path) -> None:
    repaired, spans = moved(gait)
    with gait.source.path.open("r+b") as file:
        file.seek(-1, os.SEEK_END)
        file.write(b"\x07")
    with pytest.raises(CannotWrite, match="has changed"):
        export(gait, repaired, tmp_path / "out.c3d", spans)
    with pytest.raises(CannotWrite, match="has changed"):
        write(repaired, tmp_path / "out.c3d")


def test_the_source_is_never_overwritten(gait: Take, tmp_path: Path) -> None:
    repaired, spans = moved(gait)
    (tmp_path / "link.c3d").symlink_to(gait.source.path)
    for target in (gait.source.path, tmp_path / "link.c3d"):
        with pytest.raises(CannotWrite, match="is the source"):
            export(gait, repaired, target, spans, overwrite=True)


def test_an_existing_target_is_kept(gait: Take, tmp_path: Path) -> None:
    target = tmp_path / "out.c3d"
    target.write_text("kept")
    repaired, spans = moved(gait)
    with pytest.raises(CannotWrite, match="exists"):
        export(gait, repaired, target, spans)
    assert target.read_text() == "kept"
    assert export(gait, repaired, target, spans, overwrite=True).mode == "patched"


def test_integers_cannot_hold_everything(gait: Take, tmp_path: Path) -> None:
    repaired, spans = moved(gait, by=9000.0)
    with pytest.raises(CannotWrite, match="16-bit"):
        export(gait, repaired, tmp_path / "out.c3d", spans)
    assert [p.name for p in tmp_path.iterdir()] == ["source.c3d"]


def test_another_format_is_written_anew_and_says_so(gait: Take, tmp_path: Path) -> None:
    repaired, spans = moved(gait)
    written = export(gait, repaired, tmp_path / "out.npz", spans)
    assert written.mode == "rewritten"
    assert "NumPy" in written.why
    back = read(tmp_path / "out.npz")
    assert np.array_equal(back.positions, repaired.positions, equal_nan=True)
    assert (back.labels, back.rate, back.roles) == (gait.labels, gait.rate, gait.roles)


def test_residuals_that_were_ignored_stay(shared: Path, tmp_path: Path) -> None:
    source = shared / "data/odd/all_residual_-1_giant_dup_labels.c3d"
    take = read(source, units="mm", ignore_residuals=True)
    repaired, _ = moved(take)
    written = write(repaired, tmp_path / "out.c3d")
    assert (written.mode, written.n_changed) == ("patched", 1)
    assert np.isnan(opened(tmp_path / "out.c3d", "mm").positions).all()


def test_arrays_are_written_anew_and_read_back(tmp_path: Path) -> None:
    take = Take(np.random.default_rng(0).normal(0, 1, (9, 2, 3)), 50.0, ["A", "B"], units="m")
    assert write(take, tmp_path / "a.npz").mode == "rewritten"
    assert np.array_equal(read(tmp_path / "a.npz").positions, take.positions)
    with pytest.raises(CannotWrite, match="extensions"):
        write(take, tmp_path / "a.xyz")


def test_pickled_objects_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "evil.npz"
    np.savez(path, positions=np.array([object()], dtype=object))
    with pytest.raises(BadInput, match="plain arrays"):
        read(path)


def test_a_header_that_claims_too_much_is_refused(tmp_path: Path) -> None:
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(
        header, {"descr": "<f8", "fortran_order": False, "shape": (10**9, 50, 3)}
    )
    path = tmp_path / "huge.npz"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("positions.npy", header.getvalue() + bytes(100))
    with pytest.raises(BadInput, match="claims 1200"):
        read(path)


def test_a_failing_check_leaves_the_old_file(tmp_path: Path) -> None:
    target = tmp_path / "file.bin"
    target.write_bytes(b"old")

    def refuse(written: Path) -> None:
        assert written.read_bytes() == b"new"
        raise CannotWrite("No.")

    with pytest.raises(CannotWrite, match="No"):
        write_whole(target, b"new", overwrite=True, check=refuse)
    assert [(p.name, p.read_bytes()) for p in tmp_path.iterdir()] == [("file.bin", b"old")]
    with pytest.raises(CannotWrite, match="cannot be written"):
        write_whole(tmp_path / "nowhere" / "x", b"", overwrite=False)
