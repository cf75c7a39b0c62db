"""C3D files as they are: real ones, contradicting ones, broken ones."""

import struct
from pathlib import Path

import ezc3d
import numpy as np
import pytest

from markermend import Take, read
from markermend.errors import BadInput, Lacking, UnreadableTake
from markermend.io import Contents, Reading, all_formats, open_contents, second_reader
from markermend.io.c3d_layout import read_layout
from markermend.io.c3d_numbers import ByteOrder, from_floats, to_floats
from markermend.io.c3d_writer import write_c3d
from markermend.io.contents import seen_only
from markermend.io.format import format_of
from markermend.model import Event


@pytest.fixture
def take() -> Take:
    rng = np.random.default_rng(4)
    positions = rng.normal(0, 500, (30, 5, 3))
    positions[3:9, 2] = np.nan
    labels = ["A", "Ann:B", "C", "*4", "LKneeAngles"]
    return Take(positions, 120.0, labels, first_frame=7, events=[Event("Foot Strike", 1.5, "Left")])


@pytest.mark.parametrize("order", ByteOrder)
def test_floats_come_back_in_every_byte_order(order: ByteOrder) -> None:
    values = np.random.default_rng(1).normal(0, 1e4, 1000).astype(np.float32)
    assert np.array_equal(to_floats(from_floats(values, order), order), values)


def test_dec_floats_are_those_of_the_vax_manual() -> None:
    # VAX F_floating: 1.0 is 00004080 hex as a longword, -12.5 is 0000C248.
    stored = np.frombuffer(struct.pack("<II", 0x00004080, 0x0000C248), "<f4")
    assert to_floats(stored, ByteOrder.DEC).tolist() == [1.0, -12.5]


def test_the_same_recording_in_five_encodings(shared: Path) -> None:
    folder = shared / "data"
    reference = alone(folder / "public" / "sample02_pc_real.c3d")
    for name in (
        "public/sample02_pc_int.c3d",
        "public/sample02_dec_int.c3d",
        "public/sample02_dec_real.c3d",
        "odd/sgi_real.c3d",
    ):
        other = alone(folder / name)
        assert other.labels == reference.labels
        np.testing.assert_allclose(other.positions, reference.positions, atol=0.2813)


def test_ezc3d_reads_what_is_written_anew(take: Take, tmp_path: Path) -> None:
    path = tmp_path / "new.c3d"
    path.write_bytes(write_c3d(take))
    opinion = second_reader.ask(path)
    assert opinion.trouble == ""
    np.testing.assert_allclose(opinion.positions, take.positions, rtol=1e-6)
    back = read(path)
    assert back.warnings == ()
    assert (back.labels, back.rate, back.first_frame) == (take.labels, 120.0, 7)
    assert back.roles == ("measured", "measured", "measured", "unlabelled", "model")
    assert back.events == take.events


def test_more_frames_than_16_bits_count(tmp_path: Path, shared: Path) -> None:
    n = 70_001
    long = Take(np.random.default_rng(0).normal(0, 9, (n, 2, 3)), 100.0, ["A", "B"])
    path = tmp_path / "long.c3d"
    path.write_bytes(write_c3d(long))
    back = read(path)
    assert back.n_frames == n
    np.testing.assert_allclose(back.positions, long.positions, rtol=1e-6)
    # As other programs write it: no count says how many frames there are.
    assert read(shared / "data/odd/gen_70000_frames.c3d").n_frames == 70_000


def test_more_labels_than_one_parameter_holds(tmp_path: Path) -> None:
    labels = [f"marker {i}" for i in range(600)]
    path = tmp_path / "many.c3d"
    path.write_bytes(write_c3d(Take(np.ones((3, 600, 3)), 50.0, labels)))
    assert read(path).labels == tuple(labels)


@pytest.mark.parametrize("bytes_left", range(0, 4096, 331))
def test_a_file_cut_anywhere_is_refused_or_named(
    bytes_left: int, take: Take, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(second_reader, "ask", lambda path: second_reader.Opinion(None, "was off"))
    whole = write_c3d(take)
    path = tmp_path / "cut.c3d"
    path.write_bytes(whole[:bytes_left])
    try:
        contents = open_contents(path)
    except UnreadableTake:
        return
    there = (bytes_left - read_layout(path).data_start) // (5 * 16)
    assert contents.n_frames == min(there, 30)
    assert any("cut off" in warning for warning in contents.warnings) == (there < 30)


def test_what_a_file_lacks_is_named_with_the_option(shared: Path) -> None:
    path = shared / "data/public/labelled_prone_to_run_240hz.c3d"
    with pytest.raises(Lacking, match="--units") as caught:
        read(path)
    assert caught.value.what == "units"
    contents = alone(path)
    assert contents.units is None
    in_mm, in_m = contents.take(units="mm"), contents.take(units="m")
    np.testing.assert_allclose(in_m.positions, 1000 * in_mm.positions)
    with pytest.raises(BadInput, match="mm, cm, m"):
        contents.take(units="inch")
    assert "was used, as told" in contents.take(units="mm", rate=100).warnings[-1]


def test_residuals_can_be_ignored(shared: Path) -> None:
    path = shared / "data/odd/all_residual_-1_giant_dup_labels.c3d"
    marked = open_contents(path)
    assert np.isnan(marked.positions).all()
    assert any("--ignore-residuals" in warning for warning in marked.warnings)
    assert np.isfinite(open_contents(path, ignore_residuals=True).positions).mean() > 0.5


def test_both_encodings_of_a_gap(shared: Path) -> None:
    zeros = alone(shared / "data/public/raw_qualisys_walk_zero_gaps_1_1.c3d").positions
    assert np.isnan(zeros[..., 0]).mean() == pytest.approx(0.2323, abs=5e-5)
    negative = alone(shared / "data/public/raw_optitrack_walking_dec_int_gaps.c3d").positions
    assert np.isnan(negative[..., 0]).mean() == pytest.approx(0.0743, abs=5e-5)


def test_model_outputs_are_no_markers(shared: Path) -> None:
    take = alone(shared / "data/public/walk_pig_over255pts_HC030A05.c3d")
    roles = dict(zip(take.labels, take.roles, strict=True))
    assert {roles[name] for name in ("LASI", "RHEE", "T10", "LD5M")} == {"measured"}
    assert {roles[name] for name in ("LKneeAngles", "PELO", "TRXP", "LHipForce", "JUG")} == {
        "model"
    }
    assert len(take.labels) == 291


def test_where_ezc3d_reads_beside_the_data_it_is_said(shared: Path) -> None:
    contents = open_contents(shared / "data/odd/evart_write_fails.c3d")
    assert any("ezc3d reads this file otherwise" in warning for warning in contents.warnings)
    # The measured markers stay within a room; read beside the data they do not move smoothly.
    steps = np.linalg.norm(np.diff(contents.positions, axis=0), axis=2)
    assert np.nanmax(steps) < 150


def alone(path: Path) -> Contents:
    """Read without the second reader: what it says is tested apart, and it takes its time."""
    return format_of(path).open(path, Reading(second_opinion=False))


def test_ezc3d_agrees_on_the_public_files(shared: Path) -> None:
    for path in sorted((shared / "data/public").glob("*.c3d")):
        contents = alone(path)
        foreign = ezc3d.c3d(str(path))["data"]["points"][:3]
        foreign = seen_only(foreign.transpose(2, 1, 0), np.ones(foreign.shape[:0:-1], bool))[0]
        np.testing.assert_allclose(
            contents.positions, foreign, rtol=1e-5, atol=1e-4, err_msg=path.name
        )


ODD = [
    "HANG_BKINtechnologies.c3d", "SEGV_trcreader_01.c3d", "all_zero_points_16bitanalog.c3d",
    "analog_only_rate0_Kistler.c3d", "duplicate_labels.c3d", "empty.c3d", "gen_511_w.c3d",
    "gen_flip_v10.c3d", "gen_flip_w01.c3d", "gen_header_65535_points.c3d",
    "gen_header_first_after_last.c3d", "gen_header_rate0.c3d", "gen_nan_inf_coords.c3d",
    "gen_params_zeroed.c3d", "gen_trunc02_w.c3d", "gen_trunc10_x.c3d", "gen_trunc50_w.c3d",
    "gen_trunc_1byte_w.c3d", "labels_mismatch_kyowa.c3d", "no_processor_simple.c3d",
    "nonstandard_Facial-Sing.c3d", "not_a_c3d_gait-raw.c3d", "offset_not_int_Dance.c3d",
    "one_frame_MyCube.c3d", "sgi_MACsample.c3d", "xsens_int_no_analog.c3d",
]  # fmt: skip


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("gen_header_rate0.c3d", "200 Hz was taken, 0 overruled"),
        ("gen_header_65535_points.c3d", "55 was taken, 65535 overruled"),
        ("gen_header_first_after_last.c3d", "comes after its last"),
        ("gen_70000_frames.c3d", "all that the file holds"),
        ("gen_nan_inf_coords.c3d", "count as not seen: 2"),
        ("duplicate_labels.c3d", "26 labels occur more than once"),
        ("all_zero_points_16bitanalog.c3d", "No marker is seen"),
    ],
)
def test_what_a_file_says_wrongly_is_a_warning(name: str, said: str, shared: Path) -> None:
    assert said in " ".join(alone(shared / "data/odd" / name).warnings)


@pytest.mark.parametrize("name", ODD)
@pytest.mark.timeout(30)
def test_an_odd_file_opens_or_is_refused_in_a_sentence(name: str, shared: Path) -> None:
    try:
        contents = alone(shared / "data/odd" / name)
    except UnreadableTake as error:
        refusal = str(error)
    else:
        assert contents.positions.shape[:2] == (contents.n_frames, len(contents.labels))
        assert "trunc" not in name or any("cut off" in warning for warning in contents.warnings)
        return
    assert refusal.endswith(".")
    assert "\n" not in refusal
    assert "trunc02" in name or "trunc" not in name


@pytest.mark.parametrize(
    ("name", "trouble"),
    [("SEGV_trcreader_01.c3d", "crashed"), ("sgi_MACsample.c3d", "refused")],
)
def test_trouble_of_the_second_reader_is_a_warning(name: str, trouble: str, shared: Path) -> None:
    contents = open_contents(shared / "data/odd" / name)
    assert any(f"ezc3d {trouble}" in warning for warning in contents.warnings)
    assert np.isfinite(contents.positions).any()


def test_a_child_that_loops_is_ended(shared: Path) -> None:
    opinion = second_reader.ask(shared / "data/odd/HANG_BKINtechnologies.c3d", time_limit_s=0.5)
    assert opinion.positions is None
    assert "0 s" in opinion.trouble or "memory" in opinion.trouble or "bad_alloc" in opinion.trouble


def test_every_format_has_a_file_of_its_name() -> None:
    assert [f.name for f in all_formats()][:1] == ["c3d"]
    assert all(f.extensions for f in all_formats())
