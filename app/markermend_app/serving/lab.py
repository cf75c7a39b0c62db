"""A lab's server: one folder of takes, many people, and as many processes as there are cores.

Every process is a whole server with a port of its own, started anew and never forked: threads and
files of the parent are not in it, and it is the same on Linux, macOS and Windows. Whoever logs in
at any of them is led to the one that serves that name, so that all pages of a person share what
is kept in memory. Behind a proxy of the lab, which then spreads people itself, nobody is led.
"""

import logging
import multiprocessing
import multiprocessing.connection
import os
import signal
import threading
import time
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from markermend.errors import BadInput, MarkerMendError
from markermend_app.serving.accounts import People
from markermend_app.serving.doors import Doors, doors
from markermend_app.serving.login import Gate
from markermend_app.serving.metrics import MeasuredStore, Metrics
from markermend_app.serving.server import Serving, free_port, make
from markermend_app.serving.session import visit
from markermend_app.state.places import work_list
from markermend_app.state.reach import Reach
from markermend_app.state.turns import answer_first
from markermend_app.state.workspace import Workspace

LOG = logging.getLogger(__name__)
LOG_LINE = "%(asctime)s %(levelname)s %(name)s: %(message)s"
STARTS_WITHIN_S = 120.0
AGAIN_AFTER_S = 1.0
AHEAD = 1
"""Findings that are compared while an operator looks at another: others wait for theirs."""


@dataclass(frozen=True)
class Lab:
    """Everything a process of the server has to know; only what can be sent to it.

    Attributes
    ----------
    folder
        The archive; nothing outside of it is reached.
    store
        Where reviews are kept.
    address, port
        Where the first process listens; the others follow on the next ports.
    origins
        How people reach it; empty where the address says so.
    processes
        How many.
    people
        File of accounts or roles; None where nobody logs in.
    provider
        Name of an OAuth provider; empty where passwords are in the file.
    most_upload
        How large a dropped file may be, bytes.
    secret
        Signs cookies and sessions, the same in all processes.
    units, rate, ignore_residuals
        What the files lack; see `Workspace`.
    """

    folder: Path
    store: str | None
    address: str
    port: int
    origins: tuple[str, ...]
    processes: int
    people: Path | None
    provider: str
    most_upload: int
    secret: str
    units: str | None = None
    rate: float | None = None
    ignore_residuals: bool = False

    def doors(self, index: int = 0) -> Doors:
        """Give the doors of one process."""
        here = doors(self.address, self.port, self.origins)
        return here.on_port(self.port + index) if self.direct else here

    @property
    def direct(self) -> bool:
        """Whether people reach the processes themselves, and no proxy before them."""
        here = doors(self.address, self.port, self.origins)
        return all(urlsplit(origin).port == self.port for origin in here.origins)

    def process_of(self, name: str) -> int:
        """Say which process serves somebody."""
        return zlib.crc32(name.encode()) % self.processes


def run(lab: Lab, ready: Callable[[str], None]) -> None:
    """Serve until interrupted.

    Parameters
    ----------
    lab
        What and where.
    ready
        Called with the address when all processes answer.

    Raises
    ------
    MarkerMendError
        If the folder, the people, the store or a port cannot be used.
    """
    check(lab)
    for signum in (signal.SIGTERM, signal.SIGINT):
        signal.signal(signum, _interrupt)
    address = lab.doors().origins[0] + "/"
    if lab.processes == 1:
        serve_one(lab, 0, lambda: ready(address))
    else:
        _keep_all(lab, lambda: ready(address))


def check(lab: Lab) -> None:
    """Refuse what cannot be served, before anything is started."""
    Reach(lab.folder)
    _people(lab)
    lab.doors()
    for index in range(lab.processes):
        free_port(lab.address, lab.port + index)
    MeasuredStore(lab.store, Metrics()).close()


def serve_one(lab: Lab, index: int, ready: Callable[[], None]) -> None:
    """Serve in this process until its loop is stopped."""
    _log()
    answer_first()
    reach, people, metrics = Reach(lab.folder), _people(lab), Metrics()
    with MeasuredStore(lab.store, metrics) as store:
        gate = Gate(people, lab.secret)
        serving = Serving(
            lab.address, lab.port + index, lab.doors(index), gate, store, lab.secret,
            provider=lab.provider, elsewhere=_leading(lab, index), metrics=metrics,
        )  # fmt: skip
        workspace = Workspace(
            store,
            _takes(reach),
            units=lab.units,
            rate=lab.rate,
            ignore_residuals=lab.ignore_residuals,
            reach=reach,
            most_upload=lab.most_upload,
            ahead=AHEAD,
        )
        who = None if people is None else people.person

        def page() -> Any:
            workspace.paths = _takes(reach)  # takes may have come since
            return visit(workspace, who, metrics)

        server = make(serving, page)
        server.start()
        loop = server.io_loop

        def stop(*_: object) -> None:
            loop.add_callback_from_signal(loop.stop)

        for signum in (signal.SIGTERM, signal.SIGINT):
            signal.signal(signum, stop)
        _end_with_parent(lambda: loop.add_callback(loop.stop))
        ready()
        loop.start()
        server.stop(wait=False)


def _takes(reach: Reach) -> tuple[Path, ...]:
    return tuple(
        path for path in work_list((reach.root,)) if path != reach.root and reach.holds(path)
    )


def _people(lab: Lab) -> People | None:
    return None if lab.people is None else People(lab.people, passwords=not lab.provider)


def _leading(lab: Lab, index: int) -> Callable[[str, str], str | None]:
    def elsewhere(name: str, host: str) -> str | None:
        there = lab.process_of(name)
        if there == index or not lab.direct:
            return None
        return f"http://{host}:{lab.port + there}/"

    return elsewhere


def _log() -> None:
    logging.basicConfig(level=logging.WARNING, format=LOG_LINE, force=True)
    logging.captureWarnings(capture=True)


def _interrupt(*_: object) -> None:
    raise KeyboardInterrupt


def _end_with_parent(stop: Callable[[], None]) -> None:
    """End a process whose parent is gone, however it went."""
    parent = multiprocessing.parent_process()
    if parent is None:
        return

    def watch() -> None:
        parent.join()
        stop()
        time.sleep(STARTS_WITHIN_S / 12)
        os._exit(1)  # it would not stop by itself

    threading.Thread(target=watch, daemon=True).start()


# several processes


def _child(lab: Lab, index: int, told: Any) -> None:
    try:
        serve_one(lab, index, lambda: told.send(""))
    except MarkerMendError as refusal:
        told.send(str(refusal))


def _start(lab: Lab, index: int) -> tuple[Any, Any]:
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe(duplex=False)
    process = context.Process(
        target=_child, args=(lab, index, theirs), name=f"markermend-{index}", daemon=True
    )
    process.start()
    theirs.close()
    return process, ours


def _wait_ready(process: Any, told: Any) -> None:
    try:
        refusal = told.recv() if told.poll(STARTS_WITHIN_S) else "it does not answer"
    except EOFError:
        refusal = "it ended"
    if refusal:
        process.terminate()
        raise BadInput(f"A process of the server could not start: {refusal}")


def _keep_all(lab: Lab, ready: Callable[[], None]) -> None:
    """Start all processes, and start again whichever ends by itself."""
    _log()
    running = [_start(lab, index) for index in range(lab.processes)]
    try:
        for process, told in running:
            _wait_ready(process, told)
        ready()
        while True:
            multiprocessing.connection.wait([process.sentinel for process, _ in running])
            for index, (process, told) in enumerate(running):
                if not process.is_alive():
                    LOG.error("process %d ended (%s) and is started again", index, process.exitcode)
                    told.close()
                    time.sleep(AGAIN_AFTER_S)
                    running[index] = _start(lab, index)
    finally:
        for process, _ in running:
            process.terminate()
        for process, _ in running:
            process.join(STARTS_WITHIN_S / 12)
