"""Exit codes, and one sentence on stderr for whatever cannot be done."""

import os
import re
from collections.abc import Callable
from pathlib import Path

import pytest

import markermend as mm
from markermend_app.cli import main
from markermend_app.cli.main import COMMANDS
from markermend_app.state.workspace import Workspace

from .conftest import Command

Names = dict[str, Path]

# Words of a command line, and what the refusal says; {take}, {folder}, … are filled in.
REFUSED = [
    ("", "required: COMMAND"),
    ("mend {take}", "invalid choice: 'mend'"),
    ("--verbose info {take}", "unrecognized arguments: --verbose"),
    ("info", "required: TAKE"),
    ("info {take} {take}", "unrecognized arguments"),
    ("info {missing}", "No such file"),
    ("info {folder}", "in no format that is known"),
    ("info {text}", "names its columns"),
    ("info {empty}", "empty.c3d|first block"),
    ("info {take} --rate 0", "--rate: must be a positive number of Hz; got '0'"),
    ("info {take} --rate -5", "--rate"),
    ("info {take} --rate nan", "--rate: must be a positive number of Hz; got 'nan'"),
    ("info {take} --rate inf", "--rate"),
    ("info {take} --rate fast", "--rate: must be a positive number of Hz; got 'fast'"),
    ("info {take} --units ft", "--units: invalid choice: 'ft'"),
    ("info {take} --js", "unrecognized arguments: --js"),
    ("detect {missing}", "No such file"),
    ("detect {folder}", "in no format that is known"),
    ("detect {take} --detector eye", "no detector 'eye'; known are .*published"),
    ("detect {take} --kinds gap,hole", "--kinds takes some of gap, peak, noise, step, slow"),
    ("detect {take} --kinds ,", "--kinds takes some of"),
    ("detect {take} --kinds", "--kinds: expected one argument"),
    ("repair {take}", "required: -o/--out"),
    ("repair {missing} -o {new}", "No such file"),
    ("repair {take} -o {new} --method magic", "no repair method 'magic'; known are .*pchip"),
    ("repair {take} -o {new} --kinds hole", "--kinds takes some of"),
    ("repair {take} -o {take}", "is the source, which is never overwritten"),
    ("repair {take} -o {take} --force", "is the source, which is never overwritten"),
    ("repair {take} -o {spelled} --force", "is the source"),
    ("repair {take} -o {soft} --force", "is the source"),
    ("repair {take} -o {hard} --force", "is the source"),
    ("repair {soft} -o {take} --force", "is the source"),
    ("repair {take} -o {other}", "exists; choose another name or add --force"),
    ("repair {take} -o {folder}", "is an existing folder"),
    ("repair {take} -o {folder} --force", "is an existing folder"),
    ("repair {take} -o {nowhere}/new.c3d", "No such file or directory"),
    ("repair {take} -o {text}/new.c3d", "Not a directory"),
    ("repair {take} -o {long}", "name too long"),
    ("repair {take} -o {long_beside}", "name too long"),
    ("repair {take} -o {device} --force", "no ordinary file"),
    ("repair {take} -o {new} --report {take}", "is the source"),
    ("repair {take} -o {new} --report {soft} --force", "is the source"),
    ("repair {take} -o {new} --report {new}", "its own name"),
    ("repair {take} -o {new} --report {new}.decisions.json", "its own name"),
    ("repair {take} -o {new} --report {other}", "exists; choose another name or add --force"),
    ("repair {take} -o {new} --report {folder}", "is an existing folder"),
    ("repair {take} -o {new} --report {nowhere}/report.json", "no such folder"),
    ("repair {take} -o {new} --decisions {missing}", "cannot be read"),
    ("repair {take} -o {new} --decisions {folder}", "cannot be read"),
    ("repair {take} -o {new} --decisions {text}", "no JSON"),
    ("repair {take} -o {new} --decisions {text} --kinds gap", "leave out --kinds and --method"),
    ("repair {take} -o {new} --decisions {text} --method pchip", "leave out --kinds and --method"),
    ("repair {take} -o {text} --decisions {text} --force", "is the file of decisions"),
    ("review", "required: PATH"),
    ("review {missing}", "no file .*missing.c3d"),
    ("review {take} {missing}", "no file .*missing.c3d"),
    ("review {text}", "names its columns"),
    ("review {take} --port many", "--port: must be a whole number from 1 to 65535; got 'many'"),
    ("review {take} --port 99999", "--port: must be a whole number"),
    ("demo {take}", "unrecognized arguments"),
    ("simulate", "required: SCENARIO"),
    ("simulate flying -o {new}", "invalid choice: 'flying'"),
    ("simulate walk -o {new} --duration -1", "duration_s must be in 1 to"),
    ("simulate walk -o {new} --duration nan", "duration_s must be in 1 to"),
    ("simulate walk -o {new} --seed -1", "--seed: must be a whole number from 0"),
    ("simulate walk -o {other} --duration 1", "exists"),
    ("simulate demo -o {new} --duration 4", "leave out --duration"),
    ("simulate demo -o {folder_with_demo}", "demo.c3d exists; choose another folder or add"),
]


@pytest.fixture
def names(tmp_path: Path, take_path: Path) -> Names:
    """Files and folders to be named on command lines."""
    folder = tmp_path / "folder"
    folder.mkdir()
    with_demo = tmp_path / "with_demo"
    with_demo.mkdir()
    (with_demo / "demo.c3d").write_bytes(b"mine")
    (tmp_path / "notes.txt").write_text("no recording\n")
    (tmp_path / "empty.c3d").write_bytes(b"")
    (tmp_path / "other.c3d").write_bytes(b"something else")
    (tmp_path / "soft.c3d").symlink_to(take_path)
    os.link(take_path, tmp_path / "hard.c3d")
    return {
        "take": take_path,
        "folder": folder,
        "folder_with_demo": with_demo,
        "missing": tmp_path / "missing.c3d",
        "nowhere": tmp_path / "nowhere",
        "text": tmp_path / "notes.txt",
        "empty": tmp_path / "empty.c3d",
        "new": tmp_path / "new.c3d",
        "other": tmp_path / "other.c3d",
        "soft": tmp_path / "soft.c3d",
        "hard": tmp_path / "hard.c3d",
        "spelled": folder / ".." / take_path.name,
        "long": tmp_path / ("n" * 300 + ".c3d"),
        "long_beside": tmp_path / ("n" * 245 + ".c3d"),
        "device": Path(os.devnull),
    }


def _contents(folder: Path) -> dict[str, bytes]:
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


@pytest.mark.skipif(os.name != "posix", reason="links and devices as Unix has them")
@pytest.mark.parametrize(("line", "says"), REFUSED, ids=[line or "none" for line, _ in REFUSED])
def test_is_refused_in_one_sentence_and_nothing_is_written(
    line: str, says: str, names: Names, tmp_path: Path, command: Command
):
    before = _contents(tmp_path)
    ended = command(*(word.format(**names) for word in line.split()))
    assert re.search(says, ended.refusal), ended.refusal
    assert _contents(tmp_path) == before


def test_a_store_that_cannot_be_used_is_refused_in_one_sentence(names: Names, command: Command):
    ended = command("review", names["take"], "--no-browser", "--store", names["text"] / "store")
    assert "store" in ended.refusal
    ended = command("review", names["take"], "--no-browser", "--store", names["text"])
    assert "notes.txt" in ended.refusal


@pytest.mark.parametrize("words", [(), *((name,) for name in COMMANDS)])
def test_help_says_what_there_is(words: tuple[str, ...], command: Command):
    ended = command(*words, "--help")
    assert (ended.code, ended.err) == (0, "")
    assert ended.out.startswith(f"usage: {' '.join(('markermend', *words))} ")
    if not words:
        assert all(f"\n    {name} " in ended.out for name in COMMANDS)


def test_the_version_is_that_of_the_library(command: Command):
    assert command("--version").out == f"markermend {mm.__version__}\n"


def test_a_fault_of_ours_is_shown_whole_with_exit_code_1(
    take_path: Path, command: Command, monkeypatch: pytest.MonkeyPatch
):
    def broken(*_: object, **__: object) -> None:
        raise ZeroDivisionError("of ours")

    monkeypatch.setattr("markermend.io.open_contents", broken)
    ended = command("info", take_path)
    assert ended.code == 1
    assert "ZeroDivisionError: of ours" in ended.err
    assert "fault of markermend" in ended.err


def test_an_interrupt_is_no_fault(
    take_path: Path, command: Command, monkeypatch: pytest.MonkeyPatch
):
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("markermend.io.open_contents", interrupted)
    assert command("info", take_path).code == 130


def test_a_broken_pipe_inside_the_program_is_no_reader_that_had_enough(
    take_path: Path, command: Command, monkeypatch: pytest.MonkeyPatch
):
    def broken(*_: object, **__: object) -> None:
        raise BrokenPipeError("a child process is gone")

    monkeypatch.setattr("markermend.io.open_contents", broken)
    assert command("info", take_path).code == 1


def test_review_hands_on_what_was_given_for_what_the_file_lacks(
    take_path: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
):
    served: list[Workspace] = []
    serve: Callable[..., None] = lambda workspace, **_: served.append(workspace)  # noqa: E731
    monkeypatch.setattr("markermend_app.shell.serve", serve)
    line = f"review {take_path} --rate 50 --units m --ignore-residuals --store {tmp_path}/store"
    assert main(line.split()) == 0
    (workspace,) = served
    assert (workspace.units, workspace.rate, workspace.ignore_residuals) == ("m", 50.0, True)
    assert workspace.paths == (take_path,)
    workspace.store.close()
