"""What is installed from a wheel or a source archive does its work, away from the checkout."""

import json
import os
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import time
import urllib.error
import urllib.request
import venv
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest

import markermend as mm

ROOT = Path(__file__).resolve().parents[2]
BUILD_TIMEOUT_S = 180


def _run(*words: object, cwd: Path, env: dict[str, str] | None = None) -> str:
    done = subprocess.run(
        [str(word) for word in words],
        cwd=cwd,
        env=env,
        capture_output=True,
        encoding="utf-8",
        timeout=BUILD_TIMEOUT_S,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def _build(what: str, source: Path, target: Path) -> Path:
    """Build a wheel or a source archive with what is installed here; nothing is downloaded."""
    build = (sys.executable, "-m", "build", what, "--no-isolation", "--outdir", target)
    _run(*build, source, cwd=target)
    (built,) = target.iterdir()
    return built


@pytest.fixture(scope="module")
def archive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return _build("--sdist", ROOT, tmp_path_factory.mktemp("sdist"))


@pytest.fixture(scope="module")
def wheel(archive: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel, built from the unpacked source archive, where there is no git."""
    unpacked = tmp_path_factory.mktemp("unpacked")
    with tarfile.open(archive) as packed:
        packed.extractall(unpacked, filter="data")
    (source,) = unpacked.iterdir()
    assert not list(source.rglob(".git"))
    return _build("--wheel", source, tmp_path_factory.mktemp("wheel"))


@pytest.fixture(scope="module")
def installed(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An environment with the wheel and, without the extra, what it depends on."""
    folder = tmp_path_factory.mktemp("installed")
    environment = _environment(folder)
    pinned = ("-c", ROOT / "constraints.txt", "--prefer-binary")
    _run(*_pip(environment), "install", "--quiet", "--no-compile", *pinned, wheel, cwd=folder)
    return environment


def _environment(folder: Path) -> Path:
    venv.create(folder / "environment", with_pip=False)
    return folder / "environment" / ("Scripts" if os.name == "nt" else "bin")


def _pip(environment: Path) -> tuple[object, ...]:
    """Give the command of this environment's pip, for another environment that needs none."""
    return (sys.executable, "-m", "pip", "--python", environment / "python")


def _clean() -> dict[str, str]:
    """The variables of this process without those that lead Python to other places."""
    return {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}


def test_the_archive_holds_what_is_needed_and_nothing_else(archive: Path):
    with tarfile.open(archive) as packed:
        names = {name.partition("/")[2] for name in packed.getnames()}
    needed = {
        "pyproject.toml",
        "README.md",
        "LICENSE",
        "assets/takes/demo.c3d",
        "assets/takes/demo.truth.json",
        "core/markermend/__init__.py",
        "core/markermend/py.typed",
        "app/markermend_app/cli/main.py",
        "app/markermend_app/style/desk.css",
        "tests/conftest.py",
    }
    assert needed <= names
    assert not [name for name in names if "__pycache__" in name or ".venv" in name]


def test_the_wheel_holds_every_file_of_the_packages(wheel: Path):
    with zipfile.ZipFile(wheel) as packed:
        inside = {name for name in packed.namelist() if ".dist-info/" not in name}
        (metadata,) = [n for n in packed.namelist() if n.endswith(".dist-info/METADATA")]
        said = packed.read(metadata).decode("utf-8")
    source = {
        path.relative_to(root).as_posix()
        for root in (ROOT / "core", ROOT / "app")
        for path in root.rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    takes = {f"markermend/assets/takes/{p.name}" for p in (ROOT / "assets" / "takes").iterdir()}
    assert inside == source | takes
    assert f"\nVersion: {mm.__version__}\n" in said
    assert "\nLicense-Expression: BSD-3-Clause\n" in said


def test_an_installation_without_the_extra_detects_and_repairs(installed: Path, tmp_path: Path):
    command = (installed / "markermend",)
    env = _clean()
    where = "import markermend.assets as a; print(a.demonstration())"
    demo = Path(_run(installed / "python", "-c", where, cwd=tmp_path, env=env).strip())
    assert demo.is_relative_to(installed.parent)

    info = json.loads(_run(*command, "info", demo, "--json", cwd=tmp_path, env=env))
    assert (info["n_markers"], info["units"], info["rate"]) == (53, "mm", 100.0)
    found = json.loads(_run(*command, "detect", demo, "--json", cwd=tmp_path, env=env))
    assert {f["kind"] for f in found["findings"]} >= {"gap", "peak"}
    _run(*command, "repair", demo, "-o", tmp_path / "demo.c3d", cwd=tmp_path, env=env)
    inner = [gap for gap in info["gaps"] if gap["inner"]]
    after = mm.read(tmp_path / "demo.c3d")
    assert inner
    assert all(after.seen[g["start"] : g["stop"], after.index(g["marker"])].all() for g in inner)

    packages = _run(*_pip(installed), "list", "--format=freeze", cwd=tmp_path)
    assert not {"panel", "bokeh", "pyvista", "holoviews"} & {
        line.partition("==")[0].lower() for line in packages.splitlines()
    }
    refused = subprocess.run(
        [*command, "demo", "--no-browser"], cwd=tmp_path, env=env, capture_output=True, check=False
    )
    assert refused.returncode == 2
    assert b"pip install 'markermend[app]'" in refused.stderr


@pytest.fixture
def demo_server(wheel: Path, tmp_path: Path) -> Iterator[str]:
    """The address at which an installed ``markermend demo`` serves.

    The packages of the extra are those of this environment: only markermend itself is installed.
    """
    environment = _environment(tmp_path)
    python = environment / "python"
    _run(*_pip(environment), "install", "--quiet", "--no-deps", wheel, cwd=tmp_path)
    where = "import sysconfig; print(sysconfig.get_path('purelib'))"
    site = Path(_run(python, "-c", where, cwd=tmp_path, env=_clean()).strip())
    # As a plain entry of the path: .pth files there, such as that of an editable markermend, and
    # markermend itself, which comes first here, do not count.
    (site / "borrowed.pth").write_text(sysconfig.get_path("purelib") + "\n")
    with subprocess.Popen(
        [environment / "markermend", "demo", "--no-browser", "--store", tmp_path / "store.sqlite"],
        cwd=tmp_path,
        env=_clean(),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        encoding="utf-8",
    ) as process:
        assert process.stdout is not None
        try:
            said = process.stdout.readline()
            assert said.startswith("MarkerMend at http://localhost:"), said + process.stdout.read()
            yield said.split()[2]
        finally:
            process.terminate()


def test_the_demonstration_is_served_from_an_installation(demo_server: str):
    deadline = time.monotonic() + 60
    while True:
        try:
            with urllib.request.urlopen(demo_server, timeout=60) as answer:
                page = answer.read().decode("utf-8")
            break
        except urllib.error.URLError as error:
            # The address is said just before the server listens.
            if time.monotonic() > deadline or not isinstance(error.reason, ConnectionRefusedError):
                raise
            time.sleep(0.1)
    assert answer.status == 200
    assert "MarkerMend" in page


def test_the_archive_installs_without_git(archive: Path, tmp_path: Path):
    environment = _environment(tmp_path)
    away = _clean() | {"PATH": str(environment)}
    assert shutil.which("git", path=away["PATH"]) is None
    python = environment / "python"
    where = "import sysconfig; print(sysconfig.get_path('purelib'))"
    site = Path(_run(python, "-c", where, cwd=tmp_path, env=away).strip())
    (site / "borrowed.pth").write_text(sysconfig.get_path("purelib") + "\n")  # has hatchling
    pip = (*_pip(environment), "install", "--quiet", "--no-deps", "--no-build-isolation")
    _run(*pip, archive, cwd=tmp_path, env=away)
    said = _run(environment / "markermend", "--version", cwd=tmp_path, env=away)
    assert said == f"markermend {mm.__version__}\n"
    own = "import markermend; print(markermend.__file__)"
    assert str(site) in _run(python, "-c", own, cwd=tmp_path, env=away)
