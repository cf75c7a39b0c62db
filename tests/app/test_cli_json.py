"""``info --json`` and ``detect --json``: what other programs rely on."""

import json
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import pytest

import markermend as mm
from markermend.model import KINDS, runs

from .conftest import Command, made_take


def strict(text: str) -> Any:
    """Read JSON as a strict reader does: no NaN, no infinity, one document and nothing else."""

    def refuse(constant: str) -> NoReturn:
        raise AssertionError(f"{constant} is no JSON")

    return json.loads(text, parse_constant=refuse)


def test_info_says_what_the_take_holds(take_path: Path, command: Command):
    ended = command("info", take_path, "--json")
    take = made_take()
    assert ended.warnings == []
    assert (
        strict(ended.out)
        == {
            "n_frames": 600,
            "n_markers": 9,  # the unlabelled trajectory is a point, and no marker
            "n_points": 10,
            "rate": 100.0,
            "units": "mm",
            "labels": list(take.labels[:9]),
            "gaps": [{"marker": "M2", "start": 200, "stop": 240, "inner": True}],
            "warnings": [],
        }
    )


def test_detect_lists_findings_with_these_fields_and_no_others(take_path: Path, command: Command):
    ended = command("detect", take_path, "--json")
    assert ended.warnings == []
    record = strict(ended.out)
    assert set(record) == {"version", "take", "rate", "n_frames", "findings", "warnings"}
    assert (record["version"], record["take"], record["rate"], record["n_frames"]) == (
        1,
        "small.c3d",
        100.0,
        600,
    )
    fields = {"id", "marker", "start", "stop", "kind", "score", "axes", "amplitude"}
    for finding in record["findings"]:
        assert set(finding) == fields
        assert finding["kind"] in KINDS
        assert 0 <= finding["start"] < finding["stop"] <= 600
        assert 0 <= finding["score"] <= 1
        assert set(finding["axes"]) <= {"x", "y", "z"}
        assert len(finding["axes"]) >= 1
    (gap,) = [f for f in record["findings"] if f["kind"] == "gap"]
    assert (gap["marker"], gap["start"], gap["stop"]) == ("M2", 200, 240)
    assert (gap["score"], gap["amplitude"]) == (1, None)
    at_spike = [
        f for f in record["findings"] if f["marker"] == "M6" and f["start"] <= 400 < f["stop"]
    ]
    (spike,) = at_spike  # it shows on three axes and is one finding
    assert spike["kind"] == "peak"
    assert {"x", "y"} <= set(spike["axes"])
    assert spike["amplitude"] == pytest.approx(np.hypot(np.hypot(25, 10), 5), rel=0.3)


def test_detect_prints_what_the_library_finds_and_the_same_each_time(
    take_path: Path, command: Command
):
    ended = command("detect", take_path, "--json")
    found = mm.detect(mm.read(take_path))
    listed = strict(ended.out)["findings"]
    assert [f["id"] for f in listed] == [f.id for f in found]
    assert [(f["marker"], f["start"], f["stop"], f["kind"]) for f in listed] == [
        (f.marker, f.span.start, f.span.stop, f.kind) for f in found
    ]
    assert command("detect", take_path, "--json").out == ended.out


@pytest.mark.parametrize("wanted", ["gap", "peak", "gap,peak", " peak , gap ", ",".join(KINDS)])
def test_detect_lists_only_the_kinds_wanted(wanted: str, take_path: Path, command: Command):
    whole = strict(command("detect", take_path, "--json").out)["findings"]
    listed = strict(command("detect", take_path, "--json", "--kinds", wanted).out)["findings"]
    names = {word.strip() for word in wanted.split(",")}
    assert listed == [f for f in whole if f["kind"] in names]
    assert {f["kind"] for f in listed} >= names & {"gap", "peak"}


def test_the_table_and_the_json_say_the_same(take_path: Path, command: Command):
    listed = strict(command("detect", take_path, "--json").out)["findings"]
    head, *lines, total = command("detect", take_path).out.splitlines()
    assert head.split()[0] == "marker"
    assert total == f"{len(listed)} findings"
    assert [line.split()[:2] for line in lines] == [[f["marker"], f["kind"]] for f in listed]
    said = command("info", take_path).out
    assert "600 (6.00 s)" in said
    assert "9 of 10 points" in said
    assert "1 inner, the longest 40 frames; 0 markers never seen" in said


def test_the_reach_of_slow_changes_comes_when_it_is_asked_for(take_path: Path, command: Command):
    assert "reach" not in strict(command("detect", take_path, "--json").out)
    record = strict(command("detect", take_path, "--json", "--reach").out)
    table = mm.detection.smallest_slow_changes(mm.read(take_path))
    assert record["reach"] == [
        {"marker": r.marker, "usual_mm": r.usual_mm, "fast_mm": r.fast_mm} for r in table
    ]
    assert len(table) >= 8
    said = command("detect", take_path, "--reach").out.splitlines()
    assert sum("a slow change is seen from" in line for line in said) == len(table)


# A file that says neither its unit nor its rate, as plain tables do.


@pytest.fixture
def bare_path(tmp_path: Path) -> Path:
    take = made_take()
    names = ",".join(f"{label}-T{axis}" for label in take.labels[:9] for axis in "XYZ")
    rows = ["" if np.isnan(x) else f"{x:.4f}" for x in take.positions[:, :9].ravel()]
    lines = [",".join(rows[i : i + 27]) for i in range(0, len(rows), 27)]
    path = tmp_path / "bare.csv"
    path.write_text("\n".join([names, *lines]) + "\n")
    return path


def test_what_a_file_does_not_say_is_null_in_info(bare_path: Path, command: Command):
    ended = command("info", bare_path, "--json")
    record = strict(ended.out)
    assert (record["units"], record["rate"]) == (None, None)
    assert record["warnings"] == ended.warnings
    assert any("--units" in sentence for sentence in ended.warnings)
    assert any("--rate" in sentence for sentence in ended.warnings)
    assert record["gaps"] == [{"marker": "M2", "start": 200, "stop": 240, "inner": True}]
    assert "not said" in command("info", bare_path).out


def test_what_a_file_does_not_say_is_asked_for_elsewhere(
    bare_path: Path, tmp_path: Path, command: Command
):
    for words in (("detect", bare_path), ("repair", bare_path, "-o", tmp_path / "out.csv")):
        assert "give it with --units" in command(*words).refusal
        assert "give it with --rate" in command(*words, "--units", "mm").refusal
        assert "give it with --units" in command(*words, "--rate", "100").refusal
        assert not (tmp_path / "out.csv").exists()
        assert command(*words, "--units", "mm", "--rate", "100").code == 0
    assert "give it with --units" in command("review", bare_path, "--no-browser").refusal


def test_what_is_given_counts_as_if_the_file_said_it(bare_path: Path, command: Command):
    given = ("--units", "m", "--rate", "50", "--json")
    record = strict(command("info", bare_path, *given).out)
    assert (record["units"], record["rate"], record["warnings"]) == ("m", 50.0, [])
    take = mm.read(bare_path, units="m", rate=50)
    assert take.positions[0, 0, 0] == pytest.approx(1000 * made_take().positions[0, 0, 0], abs=0.1)
    found = strict(command("detect", bare_path, *given).out)
    assert found["rate"] == 50.0
    assert [f["id"] for f in found["findings"]] == [f.id for f in mm.detect(take)]


def test_what_contradicts_the_file_is_used_with_a_warning(take_path: Path, command: Command):
    for name in ("info", "detect"):
        ended = command(name, take_path, "--rate", "50", "--units", "cm", "--json")
        record = strict(ended.out)
        assert record["rate"] == 50.0
        assert record["warnings"] == ended.warnings
        told = " ".join(ended.warnings)
        assert "The file says mm; cm was used, as told." in told
        assert "The file says 100 Hz; 50 Hz was used, as told." in told


def test_gaps_at_the_ends_and_markers_never_seen_are_no_inner_gaps(
    tmp_path: Path, command: Command
):
    positions = made_take().positions.copy()
    positions[:7, 0] = positions[590:, 1] = positions[:, 3] = np.nan
    path = tmp_path / "ends.npz"
    mm.write(mm.Take(positions, 100, made_take().labels), path)
    record = strict(command("info", path, "--json").out)
    assert record["gaps"] == [
        {"marker": "M0", "start": 0, "stop": 7, "inner": False},
        {"marker": "M1", "start": 590, "stop": 600, "inner": False},
        {"marker": "M2", "start": 200, "stop": 240, "inner": True},
        {"marker": "M3", "start": 0, "stop": 600, "inner": False},
    ]
    take = mm.read(path)
    assert record["gaps"] == [
        {
            "marker": label,
            "start": gap.start,
            "stop": gap.stop,
            "inner": gap.start > 0 and gap.stop < 600,
        }
        for label in record["labels"]
        for gap in runs(np.isnan(take.positions[:, take.index(label), 0]))
    ]


@pytest.mark.parametrize("n_frames", [1, 2, 3])
@pytest.mark.parametrize("seen", [True, False])
def test_takes_with_next_to_nothing_in_them(
    n_frames: int, seen: bool, tmp_path: Path, command: Command
):
    positions = made_take().positions[:n_frames].copy()
    if not seen:
        positions[:] = np.nan
    path = tmp_path / "little.npz"
    mm.write(mm.Take(positions, 100, made_take().labels), path)
    record = strict(command("info", path, "--json").out)
    assert (record["n_frames"], len(record["gaps"])) == (n_frames, 0 if seen else 9)
    assert strict(command("detect", path, "--json").out)["findings"] == []
    assert command("info", path).code == command("detect", path).code == 0
    assert command("repair", path, "-o", tmp_path / "out.npz").code == 0
    assert (tmp_path / "out.npz").read_bytes() == path.read_bytes()


def test_a_name_that_is_no_text_still_gives_strict_json(take_path: Path, command: Command):
    odd = take_path.with_name("w\udcffalk.c3d")
    try:
        odd.write_bytes(take_path.read_bytes())
    except (OSError, UnicodeEncodeError):
        pytest.skip("this file system has no such names")
    record = strict(command("detect", odd, "--json").out)
    assert record["take"].encode("utf-8") == b"w?alk.c3d"
    assert "w\\udcffalk.c3d" in command("info", odd).out
