"""The command as a process of its own: what it imports, its streams, pipes and terminals."""

import ast
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import markermend as mm
import markermend_app
from markermend_app.cli import picture
from markermend_app.cli.review import NEEDED

from .conftest import made_take

# Prints, after the command has run, which of the packages named first were imported by then.
WATCHED = """
import sys
from markermend_app.cli import main
names, words = sys.argv[1].split(","), sys.argv[2:]
code = main(words)
print("imported:", *sorted(set(names) & set(sys.modules)), file=sys.stderr)
sys.exit(code)
"""

# Runs the command where the packages named first are not installed.
WITHOUT = """
import sys

class Missing:
    names = sys.argv[1].split(",")
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in self.names:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, Missing())
from markermend_app.cli import main
sys.exit(main(sys.argv[2:]))
"""

APP = "panel,holoviews,bokeh,pyvista,param,vtk,tornado"
HEAVY = f"numpy,scipy,ezc3d,sklearn,sqlalchemy,alembic,joblib,tqdm,{APP}"


def run(*words: object, **settings: object) -> "subprocess.CompletedProcess[str]":
    command = [sys.executable, *(str(word) for word in words)]
    return subprocess.run(
        command,
        capture_output=True,
        encoding="utf-8",
        timeout=60,
        check=False,
        **settings,  # type: ignore[call-overload]
    )


@pytest.mark.parametrize("words", ["--help", "--version", "", "nonsense"])
def test_help_imports_nothing_that_is_slow(words: str):
    done = run("-c", WATCHED, HEAVY, *words.split())
    assert done.stderr.splitlines()[-1] == "imported:"
    assert done.returncode == (0 if words.startswith("--") else 2)


@pytest.mark.parametrize("words", ["info {}", "detect {} --json", "repair {} -o {}.out.c3d"])
def test_what_needs_no_screen_imports_none(words: str, take_path: Path):
    done = run("-c", WATCHED, APP, *(word.format(take_path) for word in words.split()))
    assert done.returncode == 0, done.stderr
    assert done.stderr.splitlines()[-1] == "imported:"


def test_what_needs_no_screen_works_without_the_application(take_path: Path, tmp_path: Path):
    out = tmp_path / "out.c3d"
    for words in (
        ("info", take_path, "--json"),
        ("detect", take_path, "--json"),
        ("repair", take_path, "-o", out, "--kinds", "gap,peak"),
    ):
        done = run("-c", WITHOUT, APP, *words)
        assert done.returncode == 0, done.stderr
    assert mm.read(out).seen[200:240, 2].all()


def test_the_application_imports_nothing_else_of_the_extra():
    root = Path(markermend_app.__file__).parent
    extra = {"panel", "holoviews", "bokeh", "prometheus_client", "pyvista", "param", "vtk"}
    imported = {
        name.partition(".")[0]
        for path in root.rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        for name in (
            [alias.name for alias in node.names]
            if isinstance(node, ast.Import)
            else [node.module or ""]
            if isinstance(node, ast.ImportFrom)
            else []
        )
    }
    assert imported & extra == {*NEEDED, *picture.NEEDED}


@pytest.mark.parametrize("missing", [APP, "panel", "pyvista", "bokeh"])
def test_what_needs_a_screen_says_what_to_install(missing: str, take_path: Path, tmp_path: Path):
    for words in (("review", take_path), ("demo",)):
        done = run("-c", WITHOUT, missing, *words, "--no-browser", "--store", tmp_path / "store")
        assert (done.returncode, done.stdout) == (2, "")
        (line,) = done.stderr.splitlines()
        assert "pip install 'markermend[app]'" in line


def test_the_module_is_the_command():
    assert run("-m", "markermend_app", "--version").stdout == f"markermend {mm.__version__}\n"


def test_a_reader_that_has_enough_is_no_fault(tmp_path: Path):
    # More output than any pipe holds, so that the command is still writing when the reader goes.
    path = tmp_path / "long.npz"
    positions = made_take().positions[:, :1].repeat(400, axis=1)
    positions[::2] = float("nan")
    mm.write(mm.Take(positions, 100, [f"marker {i}" for i in range(400)]), path)
    command = [sys.executable, "-m", "markermend_app", "info", str(path), "--json"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        assert process.stdout.readline() == b"{\n"
        process.stdout.close()
        assert process.stderr.read() == b""
        assert process.wait(60) == 0


@pytest.mark.skipif(os.name != "posix", reason="shells with these pipes")
@pytest.mark.parametrize(
    ("words", "code"), [("--help", 0), ("info {} --rate 50", 0), ("frobnicate", 2)]
)
def test_streams_that_nobody_reads_are_no_fault(words: str, code: int, take_path: Path):
    read_end, write_end = os.pipe()
    os.close(read_end)
    command = [sys.executable, "-m", "markermend_app", *words.format(take_path).split()]
    closed = subprocess.run(command, stdout=write_end, stderr=write_end, timeout=60, check=False)
    os.close(write_end)
    assert closed.returncode == code


def test_a_terminal_without_the_characters_of_a_label_gets_them_escaped(tmp_path: Path):
    path = tmp_path / "labels.npz"
    mm.write(mm.Take(made_take().positions[:, 2:3], 100, ["Knöchel→קרסול"]), path)
    done = run(
        *("-m", "markermend_app", "detect", path, "--kinds", "gap"),
        env={**os.environ, "PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0"},
    )
    assert done.returncode == 0, done.stderr
    assert "Kn\\xf6chel\\u2192" in done.stdout


@pytest.mark.skipif(os.name != "posix", reason="pseudo-terminals")
def test_progress_is_shown_on_a_terminal_and_nowhere_else(take_path: Path, tmp_path: Path):
    import pty
    import termios

    words = ["-m", "markermend_app", "repair", str(take_path), "-o"]
    assert run(*words, tmp_path / "piped.c3d").stderr == ""
    ours, theirs = pty.openpty()
    termios.tcsetwinsize(theirs, (24, 80))
    shown = bytearray()
    with subprocess.Popen(
        [sys.executable, *words, str(tmp_path / "shown.c3d")],
        stdout=subprocess.DEVNULL,
        stderr=theirs,
    ) as process:
        os.close(theirs)
        try:
            while part := os.read(ours, 4096):
                shown += part
        except OSError:  # the other end was closed
            pass
        assert process.wait(60) == 0
    os.close(ours)
    assert b"Repairing" in shown
    assert (tmp_path / "shown.c3d").read_bytes() == (tmp_path / "piped.c3d").read_bytes()


FOREIGN = '''
"""A repair method and a detector of another distribution."""
import numpy as np
from markermend import Finding, Span
from markermend.registry import method

@method(title="Stand still", kinds=("gap",), source="nobody's paper")
def standstill(problem):
    """Stay at the edge before the gap."""
    return np.repeat(problem.own[problem.span.start - 1][None], len(problem.span), axis=0)

@method(title="See ghosts", kinds=("step",), source="nobody's paper")
def ghosts(take):
    """See something where nothing is."""
    return [Finding(take.labels[0], Span(10, 20), "step", 0.5, ("x",), 7.0, "ghosts")]
'''


def test_methods_of_another_distribution_are_there_at_once(take_path: Path, tmp_path: Path):
    site, out = tmp_path / "site", tmp_path / "out.c3d"
    info = site / "someones_cli-1.0.dist-info"
    info.mkdir(parents=True)
    (site / "someones_cli.py").write_text(FOREIGN)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: someones-cli\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(
        "[markermend.repairs]\nstandstill = someones_cli:standstill\n"
        "[markermend.detectors]\nghosts = someones_cli:ghosts\n"
    )
    env = {**os.environ, "PYTHONPATH": str(site)}
    cli = ("-m", "markermend_app")

    assert "standstill" in run(*cli, "repair", "--help", env=env).stdout
    assert "ghosts" in run(*cli, "detect", "--help", env=env).stdout
    done = run(*cli, "repair", take_path, "-o", out, "--method", "standstill", env=env)
    assert done.returncode == 0, done.stderr
    positions = mm.read(out).positions
    assert (positions[200:240, 2] == positions[199, 2]).all()
    done = run(*cli, "detect", take_path, "--detector", "ghosts", "--json", env=env)
    found = json.loads(done.stdout)["findings"]
    assert [(f["marker"], f["kind"], f["amplitude"]) for f in found] == [
        ("M0", "step", 7.0),
        ("M2", "gap", None),
    ]
    assert run(*cli, "repair", take_path, "-o", out, "--method", "standstill").returncode == 2
