"""A small take with known artefacts, and a desk without a screen."""

import shutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

import markermend as mm
from markermend.review.store import Store
from markermend_app.cli import main
from markermend_app.state.desk import Desk
from markermend_app.state.worker import Worker
from markermend_app.state.workspace import Workspace


def made_take() -> mm.Take:
    """Two stiff groups of markers that swing; one gap, one spike, one unlabelled trajectory."""
    rng = np.random.default_rng(7)
    t = np.arange(600) / 100
    centres = np.stack(
        [
            np.column_stack([300 * np.sin(2 * t), 100 * np.cos(3 * t), 900 + 40 * np.sin(4 * t)]),
            np.column_stack([260 * np.sin(2 * t + 1), 80 * np.sin(t), 400 + 60 * np.cos(3 * t)]),
        ]
    )
    offsets = rng.normal(0, 90, (10, 3))
    positions = np.stack([centres[i // 5] + offsets[i] for i in range(10)], axis=1)
    positions += rng.normal(0, 0.1, positions.shape)
    positions[200:240, 2] = np.nan
    positions[400, 6] += (25, -10, 5)
    labels = [f"M{i}" for i in range(9)] + ["*10"]
    return mm.Take(positions, 100, labels)


METHODS = ("rigid", "pchip", "linear", "swap", "leave")
"""Repairs that are offered: few, so that comparing them costs little."""


class Ticks:
    """Collects what a page would do in its next tick, and does it when told."""

    def __init__(self) -> None:
        self.waiting: list[Callable[[], None]] = []

    def __call__(self, task: Callable[[], None]) -> None:
        self.waiting.append(task)

    def run(self) -> None:
        """Do what is waiting, in order."""
        while self.waiting:
            self.waiting.pop(0)()


@pytest.fixture
def take_path(tmp_path: Path) -> Path:
    """A file with the small take."""
    path = tmp_path / "small.c3d"
    mm.write(made_take(), path)
    return path


@pytest.fixture(scope="session")
def worker() -> Iterator[Worker]:
    """Give the process that computes for all desks, since starting one takes a second."""
    worker = Worker()
    yield worker
    worker.end()


@pytest.fixture(scope="session")
def found_before(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Give a folder with what is found in the small take: looking for it takes a second."""
    folder = tmp_path_factory.mktemp("found")
    path = folder / "small.c3d"
    mm.write(made_take(), path)
    with Store(folder / "store.sqlite") as store:
        workspace = Workspace(store, (path,))
        workspace.search(workspace.open(path))
    return folder / "findings"


@pytest.fixture
def make_desk(
    tmp_path: Path, take_path: Path, worker: Worker, found_before: Path
) -> Iterator[Callable[..., tuple[Desk, Ticks]]]:
    """Give a function that opens the small take on a new desk, as a new page would."""
    stores: list[Store] = []
    desks: list[Desk] = []

    shutil.copytree(found_before, tmp_path / "findings")

    def make(ahead: int = 0) -> tuple[Desk, Ticks]:
        stores.append(Store(tmp_path / "store.sqlite"))
        ticks = Ticks()
        workspace = Workspace(
            stores[-1], (take_path,), methods=METHODS, ahead=ahead, patience_s=0.0, worker=worker
        )
        desk = Desk(workspace, ticks)
        desks.append(desk)
        desk.open(take_path)
        settle(desk, ticks)
        return desk, ticks

    yield make
    for desk in desks:
        desk.close()
    for store in stores:
        store.close()


def settle(desk: Desk, ticks: Ticks) -> None:
    """Wait for all work that is under way, and show it."""
    for _ in range(6):  # what is shown may begin further work
        desk.jobs.wait()
        ticks.run()


@dataclass(frozen=True)
class Ended:
    """How a command ended, and what it printed."""

    code: int
    out: str
    err: str

    @property
    def refusal(self) -> str:
        """The one sentence of a command that was refused; nothing else was printed."""
        assert (self.code, self.out) == (2, ""), self
        assert self.err.endswith("\n")
        (line,) = self.err.splitlines()
        return line

    @property
    def warnings(self) -> list[str]:
        """The warnings of a command that was done; nothing else stands on stderr."""
        assert self.code == 0, self
        assert all(line.startswith("warning: ") for line in self.err.splitlines()), self.err
        return [line.removeprefix("warning: ") for line in self.err.splitlines()]


Command = Callable[..., Ended]


@pytest.fixture
def command(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Command:
    """Give a function that runs one command line in this process."""
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        monkeypatch.setenv(name, "1")  # a command sets them for its process; this one lives on

    def call(*words: object) -> Ended:
        capsys.readouterr()
        code = main([str(word) for word in words])
        return Ended(code, *capsys.readouterr())

    return call
