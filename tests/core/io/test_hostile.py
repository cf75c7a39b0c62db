"""Files of somebody who means harm: labels, sizes, and what a refusal repeats of them."""

import io
import zipfile
from pathlib import Path

import numpy as np
import pytest

from markermend import Take, read, write
from markermend.errors import BadInput, UnreadableTake
from markermend.io import limits, open_contents, textfile
from markermend.io.contents import LONGEST_LABEL, unique_labels
from markermend.io.formats import npz
from markermend.io.formats.trc import write_trc

HOSTILE = (
    "<img src=x onerror=alert(1)>", "=cmd|' /C calc'!A0", "../../etc/passwd", "..\\x", "x" * 200,
    "\u202egnp.exe", "a\u200bb", "قدم", "a'b\"c&d", "-1", "@SUM(A1)", "%s{}",
)  # fmt: skip


def takes_with(labels: list[str] | tuple[str, ...]) -> Take:
    positions = np.random.default_rng(0).normal(0, 100, (4, len(labels), 3)).round(3)
    return Take(positions, 100.0, labels)


@pytest.mark.parametrize(
    ("shape", "first", "said"),
    [
        ((3, 0, 3), 1, "3 frames of 0 markers"),
        ((0, 2, 3), 1, "0 frames of 2 markers"),
        ((3, 2, 3), np.nan, "whole number"),
        ((3, 2, 3), np.inf, "whole number"),
        ((3, 2, 3), 1e300, "whole number"),
        ((3, 2, 3), "<b>", "whole number"),
    ],
)
def test_odd_arrays_are_refused(
    tmp_path: Path, shape: tuple[int, ...], first: object, said: str
) -> None:
    np.savez(tmp_path / "a.npz", positions=np.ones(shape), first_frame=np.array(first))
    with pytest.raises(UnreadableTake, match=said):
        read(tmp_path / "a.npz", units="mm", rate=100.0)


@pytest.mark.parametrize("times", [("inf", "inf"), ("1e308", "-1e308"), ("nan", "1")])
def test_times_that_are_none_give_no_rate(tmp_path: Path, times: tuple[str, str]) -> None:
    path = tmp_path / "a.trc"
    write(takes_with(["A", "B"]), path)
    lines = path.read_text().splitlines()
    lines[2] = lines[2].replace("100", "0", 1)
    for row, time in zip((-2, -1), times, strict=True):
        cells = lines[row].split("\t")
        lines[row] = "\t".join([cells[0], time, *cells[2:]])
    path.write_text("\n".join(lines))
    assert open_contents(path).rate is None


@pytest.mark.parametrize("extension", ["c3d", "trc", "npz", "tsv"])
def test_hostile_labels_are_read_as_text_without_what_cannot_be_seen(
    extension: str, tmp_path: Path
) -> None:
    write(takes_with(HOSTILE), tmp_path / f"take.{extension}")
    labels = read(tmp_path / f"take.{extension}").labels
    assert labels == tuple(x.replace("\u202e", "").replace("\u200b", "") for x in HOSTILE)
    # Written again, what was read is what is read.
    write(takes_with(labels), tmp_path / f"again.{extension}")
    assert read(tmp_path / f"again.{extension}").labels == labels


FORMULAS = ("=1+1", "+A1", "-A1", "@SUM(A1:A9)", "'quoted", "'=kept", "plain")


def test_no_cell_of_a_table_is_a_formula(tmp_path: Path) -> None:
    write(takes_with(FORMULAS), tmp_path / "t.csv")
    head = (tmp_path / "t.csv").read_text().splitlines()[0]
    assert not [cell for cell in head.split(",") if cell[0] in "=+-@"]
    assert read(tmp_path / "t.csv", units="mm").labels == (*FORMULAS[:5], "=kept", "plain")


def test_labels_that_look_alike_are_told_apart() -> None:
    assert unique_labels(["ab", "a\u202eb", "a\u200bb", "\u200b"]) == ("ab", "ab#2", "ab#3", "*4")
    (cut,) = unique_labels(["x" * 10_000])
    assert len(cut) == LONGEST_LABEL


def test_what_a_refusal_repeats_is_short_and_legible(tmp_path: Path) -> None:
    path = tmp_path / "a.tsv"
    path.write_text("NO_OF_FRAMES\t1\nDATA_INCLUDED\t6D\x1b[31m" + "x" * 100_000 + "\n")
    with pytest.raises(UnreadableTake) as refusal:
        read(path)
    assert len(str(refusal.value)) < 300
    assert "\x1b" not in str(refusal.value)
    path = tmp_path / "a.npz"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("p" * 5000 + ".npy", b"no array")
    with pytest.raises(UnreadableTake) as refusal:
        read(path)
    assert len(str(refusal.value)) < 400


def test_a_unit_of_a_thousand_letters_is_said_in_short(tmp_path: Path) -> None:
    path = tmp_path / "a.trc"
    path.write_bytes(write_trc(takes_with("AB")).replace(b"\tmm\t", b"\t" + b"q" * 1000 + b"\t"))
    assert max(map(len, open_contents(path).warnings)) < 120


def test_too_many_points_are_refused_in_a_sentence(tmp_path: Path) -> None:
    names = [f"m{i}" for i in range(limits.MOST_POINTS + 1)]
    path = tmp_path / "many.trc"
    row = "\t".join(["1", "0"] + ["1"] * 3 * len(names))
    head = "PathFileType\t4\nDataRate\tUnits\n100\tmm\nFrame#\tTime\t" + "\t\t\t".join(names)
    path.write_text(f"{head}\n\n{row}\n")
    with pytest.raises(UnreadableTake, match="cut the recording into parts"):
        read(path)


def test_too_many_samples_are_refused_before_they_are_read(tmp_path: Path) -> None:
    header = io.BytesIO()
    shape = (limits.MOST_SAMPLES // 10 + 1, 10, 3)
    np.lib.format.write_array_header_1_0(
        header, {"descr": "<f8", "fortran_order": False, "shape": shape}
    )
    path = tmp_path / "long.npz"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("positions.npy", header.getvalue())
    with pytest.raises(UnreadableTake, match="claims"):
        read(path)


def test_too_large_a_text_file_is_refused_unread(tmp_path: Path) -> None:
    path = tmp_path / "large.trc"
    with path.open("wb") as file:
        file.write(b"PathFileType\t4\n")
        file.truncate(textfile.MOST_BYTES + 1)  # a hole: it takes no room on the disk
    with pytest.raises(UnreadableTake, match="400 MB"):
        read(path)


def test_an_archive_that_swells_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each array is within what one may claim; together they would fill any memory."""
    monkeypatch.setattr(npz, "_MOST_BYTES", 60_000)
    zeros = np.zeros((2000, 1, 3))
    np.savez_compressed(tmp_path / "bomb.npz", positions=zeros, event_times_s=zeros)
    with pytest.raises(UnreadableTake, match="together"):
        read(tmp_path / "bomb.npz", units="mm", rate=100.0)
    # What is not asked for is not loaded, whatever it claims.
    np.savez_compressed(tmp_path / "more.npz", positions=zeros, other=np.zeros(10**6))
    assert read(tmp_path / "more.npz", units="mm", rate=100.0).n_frames == 2000


@pytest.mark.parametrize("n_frames", [1, 65_535, 65_536])
def test_one_frame_and_more_than_16_bits_count(n_frames: int, tmp_path: Path) -> None:
    take = Take(np.ones((n_frames, 1, 3)), 100.0, ["A"])
    for extension in ("c3d", "npz"):
        write(take, tmp_path / f"t.{extension}")
        assert read(tmp_path / f"t.{extension}").n_frames == n_frames


@pytest.mark.parametrize("extension", ["c3d", "trc", "npz", "csv", "tsv"])
def test_a_take_of_which_nothing_is_seen_says_so(extension: str, tmp_path: Path) -> None:
    write(Take(np.full((5, 2, 3), np.nan), 100.0, "AB"), tmp_path / f"t.{extension}")
    take = read(tmp_path / f"t.{extension}", units="mm")
    assert take.n_frames == 5
    assert not take.seen.any()
    assert any("No marker is seen" in warning for warning in take.warnings)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e300])
def test_impossible_coordinates_are_not_seen(bad: float, tmp_path: Path) -> None:
    positions = np.ones((5, 1, 3))
    positions[2, 0, 1] = bad
    np.savez(tmp_path / "t.npz", positions=positions)
    take = read(tmp_path / "t.npz", units="mm", rate=100.0)
    assert take.seen[:, 0].tolist() == [True, True, False, True, True]


def test_a_name_of_a_file_is_said_legibly(tmp_path: Path) -> None:
    with pytest.raises(BadInput) as refusal:
        read(tmp_path / "a\nb\u202ec.trc")
    assert "a bc.trc" in str(refusal.value)
