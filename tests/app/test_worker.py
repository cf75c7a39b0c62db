"""The process beside the server: streams, faults, crashes, and its end."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from operator import floordiv

import numpy as np
import psutil
import pytest

from markermend.errors import MarkerMendError
from markermend_app.state import computing
from markermend_app.state.worker import Worker, WorkerEnded

from .conftest import made_take


def test_what_it_gives_is_what_the_function_gives(worker: Worker):
    assert worker.call(floordiv, 7, 2) == 3
    assert list(worker.stream(range, 5)) == [0, 1, 2, 3, 4]


def test_streams_of_several_threads_are_answered_in_turn(worker: Worker):
    one, two = worker.stream(range, 3), worker.stream(range, 10, 13)
    assert [next(one), next(two), next(one), next(two)] == [0, 10, 1, 11]
    one.close()
    assert list(two) == [12]


def test_a_fault_is_a_sentence_and_the_next_request_is_answered(worker: Worker):
    with pytest.raises(MarkerMendError, match="the log says why"):
        worker.call(floordiv, 1, 0)
    assert worker.call(floordiv, 4, 2) == 2


def test_a_take_is_lent_once_and_not_copied(worker: Worker):
    take = made_take()
    path = worker.lend(take)
    assert worker.lend(take) == path
    lent = computing.taken(path)
    assert isinstance(lent.positions, np.memmap)
    assert not lent.positions.flags.writeable
    np.testing.assert_array_equal(lent.positions, take.positions)
    assert (lent.rate, lent.labels, lent.content_hash) == (
        take.rate,
        take.labels,
        take.content_hash,
    )
    del take
    assert not path.exists(), "it is gone with the take"


@pytest.fixture
def own() -> Iterator[Worker]:
    worker = Worker()
    yield worker
    worker.end()


def test_a_crash_ends_what_was_asked_for_and_another_process_is_started(own: Worker):
    stream = own.stream(range, 3)
    assert next(stream) == 0
    crashed = own.pid
    with pytest.raises(WorkerEnded, match="another one is started"):
        own.call(os._exit, 3)
    with pytest.raises(WorkerEnded):
        next(stream)
    assert own.call(floordiv, 9, 3) == 3
    assert own.pid != crashed
    own.end()
    assert own.pid is None


@pytest.mark.skipif(os.name != "posix", reason="needs a signal that cannot be caught")
def test_it_ends_with_the_server_even_if_that_is_killed():
    code = (
        "from markermend_app.state.worker import Worker; import time, os\n"
        "w = Worker(); w.call(int)\n"
        "print(w.pid, flush=True); w.call(time.sleep, 60)"
    )
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE) as server:
        assert server.stdout is not None
        pid = int(server.stdout.readline())
        assert psutil.pid_exists(pid)
        server.send_signal(signal.SIGKILL)
    end = time.monotonic() + 60
    while psutil.pid_exists(pid) and psutil.Process(pid).status() != psutil.STATUS_ZOMBIE:
        assert time.monotonic() < end, "it works on for nobody"
        time.sleep(0.05)
