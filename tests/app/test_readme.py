"""The README is true: its Python runs, its commands exist, its pictures are there."""

import re
from pathlib import Path

import pytest

from markermend_app.cli.main import COMMANDS

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```python\n(.*?)```", README, re.DOTALL)


@pytest.mark.parametrize("code", BLOCKS)
def test_python_runs(
    code: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.chdir(tmp_path)
    exec(compile(code, "README.md", "exec"), {})
    said = capsys.readouterr().out.splitlines()
    assert said[0].startswith("T10 gap")
    seen, filled = (float(word) for word in re.findall(r"\d\.\d+", said[1]))
    assert seen < filled <= 1.0
    assert said[-1] == "patched"


def test_commands_exist():
    named = set(re.findall(r"^markermend (\w+)", README, re.MULTILINE))
    assert named
    assert named <= set(COMMANDS)


def test_pictures_and_links_are_there():
    for target in re.findall(r"\]\(([^)#]+)\)", README):
        assert (ROOT / target).exists(), target


def test_the_method_in_contributing_works(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    import numpy as np

    import markermend as mm
    from markermend.repairing import REPAIRS, methods

    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    code = re.search(r"```python\n(.*?)```", text, re.DOTALL)
    assert code
    (tmp_path / "hold.py").write_text(code[1], encoding="utf-8")
    monkeypatch.setattr(methods, "__path__", [*methods.__path__, str(tmp_path)])
    monkeypatch.delitem(REPAIRS.__dict__, "_own", raising=False)
    take = mm.Take(np.arange(30.0).reshape(10, 1, 3), 100, ["A"])
    assert mm.repair(take, "A", (4, 6), "hold").values.tolist() == [[9, 10, 11]] * 2
    monkeypatch.delitem(REPAIRS.__dict__, "_own", raising=False)
