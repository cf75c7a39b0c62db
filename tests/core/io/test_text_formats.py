"""Text formats: what real files say, and that only repaired cells change."""

import json
import os
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from markermend import Span, Take, read, write
from markermend.errors import CannotWrite, UnreadableTake
from markermend.io import export, open_contents
from markermend.io.format import format_of
from markermend.io.textfile import TextFile

PUBLIC = {
    "ballet_motek.trc": {},
    "dropjump_unfiltered_nan_metres.trc": {},
    "header_lies_about_frames.trc": {},
    "sprint_cortex.trc": {},
    "vicon_box_gaps.csv": {},
    "motive_rigidbody_1.21.csv": {},
    "qtm_unlabelled_walk_1.tsv": {},
    "long_diabolo_zero_gaps_metres.csv": {"units": "m", "rate": 120.0},
}

TRC = (
    "PathFileType\t4\t(X/Y/Z)\tx.trc\n"
    "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\n"
    "{rate}\t{rate}\t3\t{n}\t{units}\n"
    "Frame#\tTime\tA\t\t\tB\t\t\n"
    "\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n\n"
    "1\t0.00\t1.5\t2.5\t3.5\t{gap}\t5\t6\n"
    "2\t0.01\t1.6\t2.6\t3.6\t4.1\t5\t6\n"
    "3\t0.02\t1.7\t2.7\t3.7\t4.2\t5\t6\n"
)


def trc(rate: object = 100, n: int = 2, units: str = "mm", gap: str = "4.0") -> str:
    return TRC.format(rate=rate, n=n, units=units, gap=gap)


@pytest.fixture
def saved(tmp_path: Path) -> Callable[[str, str | bytes], Path]:
    def save(name: str, content: str | bytes) -> Path:
        path = tmp_path / name
        path.write_bytes(content.encode() if isinstance(content, str) else content)
        return path

    return save


Saved = Callable[[str, str | bytes], Path]


@pytest.fixture(scope="module")
def takes(shared: Path) -> Callable[[str], Take]:
    return cache(lambda name: read(shared / "data/public" / name, **PUBLIC[name]))


@pytest.mark.parametrize("name", PUBLIC)
@settings(max_examples=3, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_only_repaired_cells_change(
    name: str, takes: Callable[[str], Take], shared: Path, seed: int
) -> None:
    take = takes(name)
    rng = np.random.default_rng(seed)
    positions, spans = take.positions.copy(), []
    for _ in range(3):
        marker, start = int(rng.integers(take.n_markers)), int(rng.integers(take.n_frames))
        span = Span(start, min(take.n_frames, start + int(rng.integers(1, 30))))
        positions[span.frames, marker] = rng.choice([rng.uniform(-1500, 1500), 0.0, np.nan])
        spans.append((take.labels[marker], span))
    repaired = take.with_positions(positions)
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / name
        written = export(take, repaired, out, spans)
        back = read(out, **PUBLIC[name])
        new = out.read_bytes()
    assert np.array_equal(back.seen, repaired.seen)
    untouched = (take.positions == repaired.positions).all(axis=2)
    assert np.array_equal(back.positions[untouched], take.positions[untouched])
    assert np.nanmax(np.abs(back.positions - repaired.positions)) <= written.resolution_mm * 1.01
    allowed = {(label, f) for label, span in spans for f in range(span.start, span.stop)}
    assert set(zip(written.labels, map(int, written.frames), strict=True)) <= allowed
    # Apart from the code under test: lines and cells by Python's own means.
    old_lines = (shared / "data/public" / name).read_bytes().split(b"\n")
    new_lines = new.split(b"\n")
    assert len(old_lines) == len(new_lines)
    frames = {frame for _, frame in allowed}
    changed = [
        i for i, pair in enumerate(zip(old_lines, new_lines, strict=True)) if pair[0] != pair[1]
    ]
    assert len(changed) <= len(frames)
    mark = b"\t" if b"\t" in old_lines[-2] else b","
    for i in changed:
        one, two = old_lines[i].split(mark), new_lines[i].split(mark)
        one += [b""] * (len(two) - len(one))
        n_cells = sum(a.strip() != b.strip() for a, b in zip(one, two, strict=True))
        assert 0 < n_cells <= 3 * len(spans)
        assert old_lines[i].endswith(b"\r") == new_lines[i].endswith(b"\r")


@pytest.mark.parametrize("name", PUBLIC)
def test_nothing_repaired_gives_the_same_bytes(
    name: str, takes: Callable[[str], Take], shared: Path, tmp_path: Path
) -> None:
    assert write(takes(name), tmp_path / name).mode == "copied"
    assert (tmp_path / name).read_bytes() == (shared / "data/public" / name).read_bytes()


def test_the_same_take_as_csv_and_c3d(shared: Path) -> None:
    csv = read(shared / "data/public/vicon_box_gaps.csv")
    c3d = read(shared / "data/public/vicon_box_gaps.c3d")
    assert np.array_equal(csv.seen, c3d.seen)
    np.testing.assert_allclose(csv.positions, c3d.positions, rtol=1e-5, atol=1e-4)


def test_frames_that_only_extra_trajectories_fill_are_frames(shared: Path) -> None:
    contents = open_contents(shared / "data/public/header_lies_about_frames.trc")
    assert contents.n_frames == 454
    assert any("12 rows" in warning for warning in contents.warnings)


def test_no_sample_changes_its_time_where_rows_are_left_out(shared: Path, tmp_path: Path) -> None:
    path = shared / "data/public/header_lies_about_frames.trc"
    take = read(path)
    seen = int(np.flatnonzero(take.seen.any(axis=1))[0])
    row = next(line for line in path.read_text().splitlines() if line.startswith("17\t"))
    assert take.first_frame + seen == 17
    assert f"{take.positions[seen, 0, 0]:.5f}" == row.split("\t")[2]
    early = take.positions.copy()
    early[seen - 1, 0] = early[seen, 0]
    with pytest.raises(CannotWrite, match="their time is not certain"):
        export(take, take.with_positions(early), tmp_path / "a.trc", [("HeadTop", Span(3, 4))])


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("header_27107_frames_501_rows.trc", "announces 27107 frames, 501"),
        ("header_66_markers.trc", "announces 66 markers and names 33"),
        ("gen_trunc.trc", "announces 151 frames, 75"),
        ("rate_zero.trc", "no rate; the times say 90.6"),
        ("gen_utf16.tsv", "announces 2000 frames, 51"),
        ("gen_semicolon.csv", "half missing"),
        ("blanks_81pct.trc", ""),
        ("crlf.trc", ""),
        ("nan_cases.trc", ""),
        ("padded_header.trc", ""),
        ("space_in_label.trc", ""),
        ("weird_format.trc", ""),
    ],
)
def test_an_odd_file_opens_and_says_what_is_odd(name: str, said: str, shared: Path) -> None:
    contents = open_contents(shared / "data/odd" / name)
    assert said in " ".join(contents.warnings)
    assert np.isfinite(contents.positions).any()
    assert contents.rate is not None


@pytest.mark.parametrize("name", ["truncated.trc", "no_header.csv"])
def test_a_file_without_names_is_refused(name: str, shared: Path) -> None:
    with pytest.raises(UnreadableTake, match="export it"):
        open_contents(shared / "data/odd" / name)


@pytest.mark.parametrize("spelling", ["", " ", "NaN", "nan", "NAN", "-nan(ind)", "1.#QNAN", "N/A"])
def test_every_spelling_of_a_gap(spelling: str, saved: Saved) -> None:
    text = trc(gap=spelling).replace("\t5\t6\n2\t", f"\t{spelling}\t{spelling}\n2\t")
    contents = open_contents(saved("a.trc", text))
    assert np.isnan(contents.positions[:, 1, 0]).tolist() == [True, False, False]
    assert contents.warnings == ()


def test_words_in_cells_are_said(saved: Saved) -> None:
    contents = open_contents(saved("a.trc", trc(gap="lost")))
    assert np.isnan(contents.positions[0, 1]).all()
    assert any("1 cells hold no number" in warning for warning in contents.warnings)


@pytest.mark.parametrize(
    ("units", "factor"), [("mm", 1), ("cm", 10), ("m", 1000), ("Meters", 1000)]
)
def test_units_become_millimetres(units: str, factor: float, saved: Saved) -> None:
    assert read(saved("a.trc", trc(units=units))).positions[0, 0, 0] == pytest.approx(1.5 * factor)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1"])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_encoding_and_line_ends_stay(encoding: str, end: str, saved: Saved, tmp_path: Path) -> None:
    text = trc().replace("\tA\t", "\tÄrm\t").replace("\n", end)
    path = saved("a.trc", text.encode(encoding))
    take = read(path)
    assert take.labels == ("Ärm", "B")
    positions = take.positions.copy()
    positions[1, 0] = [7, 8, 9]
    write(take.with_positions(positions), tmp_path / "b.trc")
    wanted = text.replace("1.6\t2.6\t3.6", "7.0\t8.0\t9.0").encode(encoding)
    assert (tmp_path / "b.trc").read_bytes() == wanted


def test_decimal_commas_stay(saved: Saved, tmp_path: Path) -> None:
    head = "Frame;Time;A_X;A_Y;A_Z\r\n1;0,00;1,50;2,50;3,50\r\n"
    text = head + "2;0,01;1,60;;3,60\r\n3;0,02;1,7;2,7;3,7\r\n"
    take = read(saved("a.csv", text), units="m")
    assert take.rate == 100
    assert take.positions[0, 0].tolist() == [1500, 2500, 3500]
    positions = take.positions.copy()
    positions[1, 0] = [1610, 2610, 3610]
    write(take.with_positions(positions), tmp_path / "b.csv")
    wanted = text.replace("1,60;;3,60", "1,61;2,61;3,61")
    assert (tmp_path / "b.csv").read_bytes().decode() == wanted


def test_exponents_and_quotes_stay(saved: Saved, tmp_path: Path) -> None:
    head = 'Time,"A-TX","A-TY","A-TZ"\n0.0,"1.000e+02",2.5e+01,3.0e+01\n'
    text = head + '0.5,"1.100e+02",2.5e+01,3e+01\n'
    take = read(saved("a.csv", text), units="mm")
    positions = take.positions.copy()
    positions[1, 0] = [123.4, 25, 30]
    written = write(take.with_positions(positions), tmp_path / "b.csv")
    assert '0.5,"1.234e+02",2.500e+01,3.000e+01' in (tmp_path / "b.csv").read_text()
    assert written.n_changed == 1


NEXUS = (
    "Model Outputs\r\n100\r\n,,Ann:LKneeAngles,,\r\nFrame,Sub Frame,X,Y,Z\r\n,,deg,deg,deg\r\n"
    "1,0,1,2,3\r\n2,0,1,2,3\r\n\r\n"
    "Trajectories\r\n200\r\n,,Ann:LASI,,,Ann:RASI,,\r\nFrame,Sub Frame,X,Y,Z,X,Y,Z\r\n"
    ",,mm,mm,mm,mm,mm,mm\r\n5,0,10.5,20,30,,,\r\n6,0,10.5,20,30,1,2,3\r\n\r\n"
)


def test_nexus_trajectories_after_model_outputs(saved: Saved) -> None:
    take = read(saved("a.csv", NEXUS))
    assert (take.rate, take.labels, take.first_frame) == (200, ("Ann:LASI", "Ann:RASI"), 5)
    assert take.seen.tolist() == [[True, False], [True, True]]
    other = NEXUS.replace("10.5", "10§5").replace(",", ";").replace("§", ",")
    assert np.array_equal(read(saved("b.csv", other)).positions, take.positions, equal_nan=True)


def test_motive_of_a_later_version(saved: Saved) -> None:
    text = (
        "Format Version,1.23,Take Name,T,Capture Frame Rate,240.0,Export Frame Rate,120.0,"
        "Total Exported Frames,2,Length Units,Centimeters\r\n\r\n"
        ",Type,Bone,Bone,Bone,Bone,Bone,Bone,Bone,Marker,Marker,Marker\r\n"
        ",Name,P:Hip,P:Hip,P:Hip,P:Hip,P:Hip,P:Hip,P:Hip,P:LASI,P:LASI,P:LASI\r\n"
        ",ID,a,a,a,a,a,a,a,b,b,b\r\n,Parent,,,,,,,,,,\r\n"
        ",,Rotation,Rotation,Rotation,Rotation,Position,Position,Position,"
        "Position,Position,Position\r\n"
        "Frame,Time (Seconds),X,Y,Z,W,X,Y,Z,X,Y,Z\r\n"
        "0,0.0,0,0,0,1,1,2,3,4,5,6\r\n1,0.0083,0,0,0,1,1,2,3,,,\r\n"
    )
    take = read(saved("a.csv", text))
    assert (take.labels, take.roles) == (("P:Hip", "P:LASI"), ("model", "measured"))
    assert take.rate == 120
    assert take.positions[0, 1].tolist() == [40, 50, 60]
    assert not take.seen[1, 1]


@pytest.fixture
def keypoints(tmp_path: Path) -> Path:
    folder = tmp_path / "walk"
    folder.mkdir()
    for frame in (0, 1, 3):
        values = [[100 + i + frame, 200.5 + i, 0.9] for i in range(25)]
        if frame == 1:
            values[4] = [0, 0, 0]
        person = {
            "person_id": [-1],
            "pose_keypoints_2d": np.ravel(values).tolist(),
            "face_keypoints_2d": [],
        }
        text = json.dumps({"version": 1.3, "people": [person]})
        (folder / f"walk_{frame:012d}_keypoints.json").write_text(text)
    (folder / "notes.json").write_text("{}")
    return folder


def test_openpose_frames_are_one_take(keypoints: Path) -> None:
    take = read(keypoints, rate=25)
    assert (take.n_frames, take.n_markers, take.n_dims, take.units) == (4, 25, 2, "px")
    assert take.labels[4] == "RWrist"
    assert take.seen[:, 4].tolist() == [True, False, False, True]
    assert any("1 frames have no file" in warning for warning in take.warnings)


def test_openpose_export_changes_three_numbers(keypoints: Path, tmp_path: Path) -> None:
    take = read(keypoints, rate=25)
    positions = take.positions.copy()
    positions[1, 4] = [105.25, 204.75]
    written = export(
        take, take.with_positions(positions), tmp_path / "out", [("RWrist", Span(1, 2))]
    )
    assert (written.mode, written.spans) == ("patched", (("RWrist", Span(1, 2)),))
    names = sorted(path.name for path in keypoints.iterdir())
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == names
    differing = [
        name
        for name in names
        if (keypoints / name).read_bytes() != (tmp_path / "out" / name).read_bytes()
    ]
    assert differing == ["walk_000000000001_keypoints.json"]
    frame = json.loads((tmp_path / "out" / differing[0]).read_text())
    x, y, confidence = frame["people"][0]["pose_keypoints_2d"][12:15]
    assert (x, y) == pytest.approx((105.25, 204.75), abs=0.1)
    assert confidence == 0.9
    positions[2, 4] = [1, 1]
    with pytest.raises(CannotWrite, match="has no file"):
        write(take.with_positions(positions), tmp_path / "other")


@pytest.mark.parametrize("extension", ["trc", "tsv", "csv", "c3d", "npz"])
def test_a_take_written_anew_comes_back(extension: str, tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    positions = rng.normal(0, 500, (20, 4, 3))
    positions[4:9, 1] = np.nan
    take = Take(positions, 120.0, ["A", "Ann:B", "*3", "D 2"], first_frame=11)
    written = write(take, tmp_path / f"a.{extension}")
    assert (written.mode, written.why[:8]) == ("rewritten", "The take")
    back = read(tmp_path / f"a.{extension}", units="mm" if extension == "csv" else None)
    np.testing.assert_allclose(back.positions, take.positions, rtol=1e-6, atol=1e-5)
    assert (back.labels, back.rate, back.first_frame) == (take.labels, 120.0, 11)


@settings(max_examples=60, deadline=None)
@given(
    data=st.binary(max_size=300),
    start=st.sampled_from(
        [
            b"",
            b"PathFileType\t4\n",
            b"NO_OF_FRAMES\t2\n",
            b"Format Version,1.2\n",
            b"Trajectories\n100\n",
            b'{"people": [',
            b"A-TX,A-TY,A-TZ\n",
            b"\xff\xfe",
        ]
    ),
)
def test_garbage_is_refused_in_a_sentence(data: bytes, start: bytes) -> None:
    with tempfile.TemporaryDirectory() as folder:
        for extension in ("trc", "csv", "tsv", "json", "txt"):
            path = Path(folder) / f"a.{extension}"
            path.write_bytes(start + data)
            try:
                contents = open_contents(path)
            except UnreadableTake:
                continue
            assert contents.positions.ndim == 3


def test_large_text_is_refused_unread(tmp_path: Path) -> None:
    path = tmp_path / "a.trc"
    with path.open("wb") as file:
        file.write(b"PathFileType\t4\n")
        file.truncate(600_000_000)  # sparse
    with pytest.raises(UnreadableTake, match="600 MB"):
        open_contents(path)


@given(st.text(st.characters(codec="utf-8", exclude_characters="\0")))
def test_decoded_text_gives_the_same_bytes(text: str) -> None:
    for data in (text.encode(), text.encode("utf-8-sig"), text.encode("utf-16")):
        decoded = TextFile.decode(data)
        assert decoded.encode(decoded.lines) == data


def test_formats_are_told_by_content_not_by_name(saved: Saved) -> None:
    assert format_of(saved("a.csv", trc())).name == "trc"
    assert format_of(saved("a.txt", NEXUS)).name == "nexus_csv"
    with pytest.raises(UnreadableTake, match="no format that is known"):
        format_of(saved("a.xyz", "hello"))


def test_a_pipe_is_refused_and_not_waited_for(tmp_path: Path) -> None:
    if not hasattr(os, "mkfifo"):
        pytest.skip("this system has no named pipes")
    os.mkfifo(tmp_path / "a.c3d")
    with pytest.raises(UnreadableTake, match="no ordinary file"):
        open_contents(tmp_path / "a.c3d")


def test_a_missing_file_is_said(tmp_path: Path) -> None:
    with pytest.raises(UnreadableTake, match="cannot be read"):
        open_contents(tmp_path / "nowhere.c3d")


def test_short_header_lines_of_motive_are_refused(saved: Saved) -> None:
    text = (
        "Format Version,1.2\n,,Marker\n,,A\n,,Position,Position,Position\n"
        "Frame,Time,X,Y,Z\n0,0.0,1,2,3\n"
    )
    with pytest.raises(UnreadableTake, match="fewer cells"):
        open_contents(saved("a.csv", text))


@pytest.mark.parametrize(
    ("name", "text"), [("bad.csv", "a,b\n1,2\n"), ("bad.trc", "PathFileType\t4\n")]
)
def test_a_refusal_says_which_file_it_is_about(tmp_path: Path, name: str, text: str):
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(UnreadableTake, match=rf"^{name}: "):
        read(path)
