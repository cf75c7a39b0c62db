"""Recipes and backups from the command line."""

import json
from pathlib import Path

import pytest

from .conftest import Command


@pytest.fixture(autouse=True)
def own_store(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    where = tmp_path / "lab" / "reviews.sqlite"
    monkeypatch.setenv("MARKERMEND_STORE", str(where))
    monkeypatch.setenv("MARKERMEND_OPERATOR", "anna")
    return where


def test_a_recipe_is_saved_shown_used_and_deleted(
    command: Command, take_path: Path, tmp_path: Path
) -> None:
    save = ("recipe", "save", "gait", "--detector", "published", "--kinds", "gap,peak")
    assert command(*save, "--sensitivity", "peak=2").out == "gait: version 1\n"
    assert command(*save, "--repair", "gap").out == "gait: version 2\n"
    (listed,) = json.loads(command("recipe", "list", "--json").out)["recipes"]
    assert (listed["name"], listed["version"], listed["author"]) == ("gait", 2, "anna")
    file = tmp_path / "gait.json"
    assert command("recipe", "show", "gait@1", "-o", str(file)).code == 0
    assert json.loads(file.read_text())["sensitivity"] == {"peak": 2.0}
    by_name = command("detect", str(take_path), "--recipe", "gait@1", "--json")
    by_file = command("detect", str(take_path), "--recipe", str(file), "--json")
    found = json.loads(by_name.out)["findings"]
    assert {one["kind"] for one in found} == {"gap", "peak"}
    assert by_file.out == by_name.out
    assert command("recipe", "delete", "gait").out == "gait: 2 versions deleted\n"


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (("recipe", "show", "none"), "There is no recipe 'none'"),
        (("recipe", "save", "a", "--sensitivity", "blip=2"), "blip"),
        (("recipe", "save", "a", "--sensitivity", "peak=much"), "--sensitivity takes KIND=X"),
        (("recipe", "save", "a", "--set", "window"), "--set takes NAME=VALUE"),
        (("recipe", "save", "a", "--most-mm", "5"), "say with --repair"),
        (("recipe", "save", "a", "--file", "a.json", "--note", "b"), "leave out --note"),
        (("store", "restore", "absent.sqlite"), "There is no backup"),
    ],
)
def test_what_makes_no_sense_is_refused(
    command: Command, given: tuple[str, ...], said: str
) -> None:
    assert said in command(*given).refusal


def test_a_store_is_checked_copied_and_put_back(
    command: Command, own_store: Path, tmp_path: Path
) -> None:
    command("recipe", "save", "gait")
    backup = tmp_path / "monday.sqlite"
    assert command("store", "backup", str(backup)).code == 0
    command("recipe", "delete", "gait")
    done = command("store", "restore", str(backup))
    assert f"is in {own_store.with_name('reviews.replaced.sqlite')}" in done.out
    assert "1 recipes" in command("recipe", "list").out
    assert command("store", "check").out.endswith("All of it can be read.\n")
