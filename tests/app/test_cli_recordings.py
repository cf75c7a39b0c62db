"""Every recording at hand through the commands: it opens, or is refused in one sentence."""

import time
from pathlib import Path

import pytest

import markermend as mm

from .conftest import Command, Ended
from .test_cli_json import strict

FOLDER = Path(__file__).resolve().parents[3] / "shared" / "data"
LIMIT_S = 30.0
"""Of computing; on a machine that does much else at once the clock on the wall says little."""
HANGS_S = 150.0

# Minutes of dense data: they are read and repaired here, and detected on by ``make trust``.
LONG = {
    "cmu_85_12_dynamic.c3d",
    "derived_long_hdm05_palindrome.c3d",
    "hdm05_mm_01-02_clean.c3d",
    "labelled_prone_to_run_240hz.c3d",
    "raw_sprintbasket_gaps_metres.c3d",
    "tennis_2players_metres.c3d",
    "walk_vicon_clean_rtosim.c3d",
}


def _files(name: str) -> list[Path]:
    folder = FOLDER / name
    found = sorted(folder.iterdir()) if folder.is_dir() else []
    return [path for path in found if path.name != "README.md"]


def _timed(command: Command, *words: object) -> Ended:
    began, computed = time.monotonic(), time.process_time()
    ended = command(*words)
    assert time.process_time() - computed < LIMIT_S
    assert time.monotonic() - began < HANGS_S
    assert ended.code in (0, 2), ended.err
    assert "Traceback" not in ended.err
    if ended.code == 2:
        assert ended.refusal.endswith((".", "--help"))
        assert len(ended.refusal) < 400
    return ended


def _lacking(info: dict[str, object]) -> list[str]:
    """Give what the file does not say."""
    given = [] if info["units"] else ["--units", "mm"]
    return given if info["rate"] else [*given, "--rate", "100"]


@pytest.mark.parametrize("path", _files("public"), ids=lambda path: path.name)
def test_a_real_recording_goes_through_all_commands(path: Path, tmp_path: Path, command: Command):
    ended = _timed(command, "info", path, "--json")
    assert ended.code == 0, ended.err
    info = strict(ended.out)
    assert info["warnings"] == ended.warnings
    assert info["n_frames"] > 1
    assert len(info["labels"]) == len(set(info["labels"])) == info["n_markers"] <= info["n_points"]
    given = _lacking(info)
    if given:
        assert f"give it with {given[0]}" in command("detect", path).refusal

    out, report = tmp_path / path.name, tmp_path / "report.json"
    words = ("repair", path, "-o", out, "--method", "pchip", "--report", report)
    ended = command(*words, *given)
    assert ended.code == 0, ended.err
    record = strict(report.read_text())
    inner = {(g["marker"], g["start"], g["stop"]) for g in info["gaps"] if g["inner"]}
    others = {(g["marker"], g["start"], g["stop"]) for g in info["gaps"]} - inner
    done = {(r["marker"], r["start"], r["stop"]) for r in record["repaired"]}
    stays = {(s["marker"], s["start"], s["stop"]) for s in record["stays"]}
    assert done | (stays & inner) == inner
    assert others <= stays
    assert record["written"]["n_changed"] == sum(stop - start for _, start, stop in done)
    assert (out.read_bytes() == path.read_bytes()) == (not done)
    if path.name in LONG:
        return
    ended = command("detect", path, "--json", *given)
    assert ended.code == 0, ended.err
    found = strict(ended.out)
    assert (found["n_frames"], found["warnings"]) == (info["n_frames"], ended.warnings)
    gaps = {(f["marker"], f["start"], f["stop"]) for f in found["findings"] if f["kind"] == "gap"}
    whole = {(label, 0, info["n_frames"]) for label in info["labels"]}
    assert gaps == (inner | others) - whole
    assert {f["marker"] for f in found["findings"]} <= set(info["labels"])


@pytest.mark.parametrize("path", _files("odd"), ids=lambda path: path.name)
def test_an_odd_file_ends_in_time_and_without_a_traceback(path: Path, command: Command):
    ended = _timed(command, "info", path, "--json")
    cut = "trunc" in path.name or "511" in path.name
    if ended.code == 2:
        refusal = ended.refusal
        assert command("detect", path).refusal == refusal
        return
    info = strict(ended.out)
    assert info["warnings"] == ended.warnings
    assert not cut or any(word in " ".join(info["warnings"]) for word in ("frames", "cut", "row"))
    found = _timed(command, "detect", path, "--json", *_lacking(info))
    assert found.code == 0
    assert strict(found.out)["n_frames"] == info["n_frames"]


def test_a_long_c3d_is_read_whole(shared: Path, command: Command):
    path = shared / "data" / "odd" / "gen_70000_frames.c3d"
    info = strict(command("info", path, "--json").out)
    assert info["n_frames"] == 70_000 == mm.read(path).n_frames
