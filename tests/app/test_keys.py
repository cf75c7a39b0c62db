"""The one table of keys: without conflicts, complete, and remappable in a file."""

import json
from pathlib import Path

import pytest

from markermend.errors import BadInput, UnknownName
from markermend_app import keys
from markermend_app.keys import COMMANDS, SHORTCUTS, Keys, read_keys, remapped
from markermend_app.state.intents import INTENTIONS


def test_no_key_is_given_twice_and_every_one_asks_for_something():
    assert remapped(SHORTCUTS, {}) == SHORTCUTS
    asked = {s.action for s in SHORTCUTS if not s.at_once} | set(COMMANDS)
    assert asked <= set(INTENTIONS)


def test_harmful_neighbours_are_apart():
    row = "asdfg"
    at = {s.action: row.index(s.keys[0]) for s in SHORTCUTS if s.keys[0] in row}
    assert abs(at["accept"] - at["reject"]) >= 3


def test_keys_of_a_file_replace_those_of_the_table(tmp_path: Path):
    path = tmp_path / "keys.json"
    path.write_text(json.dumps({"accept": "Enter", "reject": ["f", "Delete"]}))
    table = Keys(read_keys(path))
    assert table.actions["Enter"] == "accept"
    assert "a" not in table.actions
    assert table.actions["Delete"] == table.actions["f"] == "reject"
    assert table.hints["accept"] == "Enter"


def test_a_conflict_is_named(tmp_path: Path):
    path = tmp_path / "keys.json"
    path.write_text(json.dumps({"accept": "f"}))
    with pytest.raises(BadInput, match="F is given to accept and to reject"):
        read_keys(path)


def test_an_unknown_command_is_named():
    with pytest.raises(UnknownName, match="fly"):
        remapped(SHORTCUTS, {"fly": ["f"]})


@pytest.mark.parametrize("text", ["", "[]", '{"accept": 3}', '{"accept": [""]}', "nothing"])
def test_what_is_no_table_of_keys_is_a_sentence(tmp_path: Path, text: str):
    path = tmp_path / "keys.json"
    path.write_text(text)
    with pytest.raises(BadInput, match="keys"):
        read_keys(path)


def test_pages_show_the_keys_in_force():
    from markermend_app.views.markup import kbd

    before = keys.in_force().shortcuts
    try:
        keys.use(remapped(SHORTCUTS, {"accept": ["Enter"]}))
        assert kbd("accept") == "<kbd>Enter</kbd>"
    finally:
        keys.use(before)
    assert kbd("accept") == "<kbd>A</kbd>"
