"""``markermend evaluate li`` and ``evaluate kamali`` as commands."""

import json
from pathlib import Path

import pytest

import markermend as mm
from markermend.simulate import simulate

from .conftest import Command


@pytest.fixture
def walk(tmp_path: Path) -> Path:
    """Four seconds on a treadmill."""
    path = tmp_path / "walk.c3d"
    mm.write(simulate("treadmill", 0, duration_s=4.0), path)
    return path


def test_li_prints_writes_draws_and_says_what_two_dimensions_are(
    walk: Path, tmp_path: Path, command: Command
):
    record, page = tmp_path / "li.json", tmp_path / "li.html"
    words = (
        *("--pieces", 1, "--figures", "rank", "--dims", "3,2"),
        *("--json", record, "--picture", page),
    )
    ended = command("evaluate", "li", walk, *words)
    assert ended.code == 0, ended.err
    written = json.loads(record.read_text())
    assert written["experiment"] == "li"
    assert {row["dims"] for row in written["rows"]} == {2, 3}
    assert all(f"{row['mean']:.2f} ±" in ended.out for row in written["rows"])
    assert "no recording" in ended.out
    drawn = page.read_text(encoding="utf-8")
    assert "Gaps and blackouts in walk.c3d" in drawn
    assert "Error by rank, 2D" in drawn


def test_kamali_prints_writes_and_draws(walk: Path, tmp_path: Path, command: Command):
    record, page = tmp_path / "kamali.json", tmp_path / "kamali.html"
    words = (
        *("--scenarios", "", "--markers", 11, "--methods", "gslr,svt", "--weights", 0.1),
        *("--masks", 2, "--sweep-masks", 1, "--cycles", 2, "--json", record, "--picture", page),
    )
    ended = command("evaluate", "kamali", walk, *words)
    assert ended.code == 0, ended.err
    written = json.loads(record.read_text())
    assert [cell["method"] for cell in written["cells"]] == ["gslr", "svt"]
    assert all(f"{cell['mean_mm']:.2f}" in ended.out for cell in written["cells"])
    assert "walk.c3d" in ended.out
    assert "walk.c3d, 11 markers" in page.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("words", "refusal"),
    [
        ("kamali --scenarios running", "no scenario 'running'"),
        ("kamali --scenarios ,", "Nothing to fill"),
        ("kamali --masks 0", "--masks: must be a whole number from 1"),
        ("li {walk} --pieces 9", "hold 2 pieces of 200 frames"),
        ("li {walk} --pieces 1 --figures Eq.99", "No table or figure"),
        ("li", "required: TAKE"),
    ],
)
def test_refusals(words: str, refusal: str, walk: Path, command: Command):
    ended = command("evaluate", *words.format(walk=walk).split())
    assert ended.code != 0
    assert refusal in ended.err
