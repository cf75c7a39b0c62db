"""Pictures as files: whole, self-contained, and refused where they cannot be."""

import json
import re
import subprocess
import sys
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import pytest

import markermend as mm
from markermend.body import infer
from markermend_app.plots import mesh, prediction
from markermend_app.plots.picture import html, log_ticks

from .conftest import Command, made_take
from .test_cli_process import APP, WITHOUT
from .test_plots import predicted


class References(HTMLParser):
    """Collects whatever makes a browser fetch something."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []
        self.policy = ""
        self.style = False

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        self.style = tag == "style"
        if given.get("http-equiv") == "Content-Security-Policy":
            self.policy = given["content"] or ""
        self.found += [v or "" for k, v in attrs if k in ("src", "href", "srcset", "data")]

    def handle_data(self, data: str) -> None:
        if self.style:
            self.found += re.findall(r"""(?:url\(|@import)\s*["']?([^"')]*)""", data)


def test_a_file_holds_all_it_needs_and_forbids_the_rest():
    few = replace(predicted(), sweep=(), replicas=(), regressors=())
    picture = prediction.predictors(few, "walk.c3d")
    text = html(picture)
    page = References()
    page.feed(text)
    assert len(page.found) == 2  # the typeface, in two weights
    assert all(reference.startswith("data:font/woff2;base64,") for reference in page.found)
    # The drawing program could fetch one for formulas: it may not.
    assert page.policy.startswith("default-src 'none'; ")
    assert "http" not in page.policy
    without_programs = re.sub(r"<script.*?</script>", "", text, flags=re.DOTALL)
    assert not re.search(r"https?:|//[a-z]", re.sub(r"base64,[\w+/=]*", "", without_programs))
    assert text.count("data-root-id") == len(picture.panels)


def test_labels_cannot_break_out_of_the_file():
    take = made_take()
    named = mm.Take(take.positions, take.rate, ["</script><b>", *take.labels[1:]])
    text = html(mesh.body_mesh(named, infer(named), "<i>.c3d"))
    assert "</script><b>" not in text
    assert "<i>" not in text
    assert "&lt;i&gt;.c3d" in text


def test_evaluate_mesh_prints_writes_and_draws(take_path: Path, tmp_path: Path, command: Command):
    record, page = tmp_path / "mesh.json", tmp_path / "mesh.html"
    ended = command("evaluate", "mesh", take_path, "--json", record, "--picture", page)
    assert ended.warnings == []
    lines = ended.out.splitlines()
    assert lines[0].split() == ["cluster", "parent", "parent", "marker", "siblings"]
    assert [line.split()[:2] for line in lines[1:]] == [["1", "-"], ["2", "1"]]
    written = json.loads(record.read_text())
    body = infer(mm.read(take_path))
    assert [set(one["markers"]) for one in written["clusters"]] == [
        {body.labels[m] for m in cluster} for cluster in body.clusters
    ]
    assert written["clusters"][0]["parent"] is None
    assert written["clusters"][1]["parent"] == 1
    assert written["clusters"][1]["parent_marker"] in written["clusters"][0]["markers"]
    for marker, siblings in written["siblings"].items():
        assert siblings == [body.labels[m] for m in body.siblings(marker)]
    assert page.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")


def test_evaluate_draws_what_it_prints(take_path: Path, tmp_path: Path, command: Command):
    page = tmp_path / "e1.html"
    words = ("--simulations", 1, "--amplitude", 10, "--share", 0.05, "--seed", 3)
    ended = command("evaluate", "e1", take_path, *words, "--picture", page)
    assert ended.code == 0, ended.err
    text = page.read_text(encoding="utf-8")
    assert "small.c3d" in text
    assert "n = 1 simulations" in text
    assert "seed 3" in text


@pytest.mark.parametrize(
    ("name", "refusal"),
    [("e1.png", "FILE.html"), ("nowhere/e1.html", "no folder"), ("folder.html", "existing folder")],
)
def test_a_picture_that_cannot_be_is_refused_before_the_work(
    name: str, refusal: str, take_path: Path, tmp_path: Path, command: Command
):
    (tmp_path / "folder.html").mkdir()
    ended = command("evaluate", "e1", take_path, "--picture", tmp_path / name)
    assert refusal in ended.refusal


@pytest.mark.parametrize("missing", [APP, "holoviews"])
def test_without_the_extra_a_picture_says_what_to_install(
    missing: str, take_path: Path, tmp_path: Path
):
    def call(*words: object) -> "subprocess.CompletedProcess[str]":
        line = [sys.executable, "-c", WITHOUT, missing, "evaluate", "mesh", *map(str, words)]
        return subprocess.run(line, capture_output=True, encoding="utf-8", timeout=60, check=False)

    page = tmp_path / "mesh.html"
    refused = call(take_path, "--picture", page)
    assert (refused.returncode, refused.stdout) == (2, "")
    (line,) = refused.stderr.splitlines()
    assert "pip install 'markermend[app]'" in line
    assert not page.exists()
    done = call(take_path, "--json", tmp_path / "mesh.json")  # tables and JSON need no extra
    assert done.returncode == 0, done.stderr
    assert json.loads((tmp_path / "mesh.json").read_text())["experiment"] == "mesh"


@pytest.mark.parametrize(
    ("low", "high", "names"),
    [
        (0.3, 40.0, ["0.5", "1", "2", "5", "10", "20"]),
        (0.002, 90.0, ["0.01", "0.1", "1", "10"]),
        (9.0, 40.0, ["10", "15", "20", "30", "40"]),
    ],
)
def test_ticks_of_a_logarithmic_axis_are_round(low: float, high: float, names: list[str]):
    assert [name for _, name in log_ticks(low, high)] == names
