"""Many takes on the processes of one machine, or on a cluster that is there already.

joblib hands out the work in both cases: to threads here, each of which waits for a process of its
own (`markermend.batch.hand`), or to Dask's workers, whose threads do the same there. So a take that
ends its process ends no worker, and the same code computes everywhere.
"""

import logging
import threading
from collections.abc import Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import contextmanager
from typing import Any

from markermend.batch.hand import TIME_LIMIT_S, Hand, work_apart
from markermend.batch.work import Result, Task
from markermend.errors import BadInput, MarkerMendError

_CONNECT_S = 10.0


class Hands:
    """One hand for each thread that asks, all ended together."""

    def __init__(self, limit_s: float) -> None:
        self._limit_s = limit_s
        self._of_thread = threading.local()
        self._all: list[Hand] = []

    def work(self, task: Task) -> Result:
        """Work on one take with the hand of this thread."""
        hand: Hand | None = getattr(self._of_thread, "hand", None)
        if hand is None:
            hand = self._of_thread.hand = Hand(self._limit_s)
            self._all.append(hand)
        return hand.work(task)

    def close(self) -> None:
        """End all hands, whatever they do."""
        for hand in self._all:
            hand.close()


def results(
    tasks: Sequence[Task],
    *,
    jobs: int = 1,
    dask: str | None = None,
    limit_s: float = TIME_LIMIT_S,
) -> Iterator[Result]:
    """Yield the result of each task as it comes; their order means nothing.

    Parameters
    ----------
    tasks
        One per take.
    jobs
        Number of processes on this machine.
    dask
        Address of the scheduler of a Dask cluster that is used instead.  Its workers see the
        archive, and the folder of results, under the same paths.
    limit_s
        Seconds after which the work on one take is ended.

    Raises
    ------
    BadInput
        If there is no cluster at that address, or Dask is not installed.
    MarkerMendError
        If the cluster is lost on the way.
    """
    if not tasks:
        return
    if dask is not None:
        yield from _on_cluster(tasks, dask, limit_s)
        return
    from joblib import Parallel, delayed

    hands = Hands(limit_s)
    pool = Parallel(n_jobs=jobs, backend="threading", batch_size=1, return_as="generator_unordered")
    try:
        yield from pool(delayed(hands.work)(task) for task in tasks)
    finally:
        hands.close()


def _on_cluster(tasks: Sequence[Task], address: str, limit_s: float) -> Iterator[Result]:
    with _silent("distributed.client"), _client(address) as client:
        from distributed.scheduler import KilledWorker
        from joblib import Parallel, delayed, parallel_config

        try:
            with parallel_config("dask", client=client, wait_for_workers_timeout=_CONNECT_S):
                pool = Parallel(n_jobs=-1, batch_size=1, return_as="generator_unordered")
                yield from pool(delayed(work_apart)(task, limit_s) for task in tasks)
        except (OSError, TimeoutError, CancelledError, KilledWorker) as error:
            raise MarkerMendError(
                f"The cluster at {address} was lost ({type(error).__name__}); start the same "
                "command again when it is there, and it goes on where it was."
            ) from None


@contextmanager
def _client(address: str) -> Iterator[Any]:
    try:
        from distributed import Client
    except ModuleNotFoundError:
        raise BadInput(
            "A cluster needs Dask: install it with pip install 'markermend[dask]', or leave --dask "
            "out."
        ) from None
    try:
        client = Client(address, timeout=_CONNECT_S, set_as_default=False)
    except (OSError, ValueError) as error:
        said = " ".join(str(error).split())[:200]
        raise BadInput(
            f"There is no Dask scheduler at {address} ({said}); start one with dask scheduler."
        ) from None
    try:
        if not client.scheduler_info()["workers"]:
            raise BadInput(
                f"The scheduler at {address} has no workers; start some with dask worker {address}."
            )
        yield client
    finally:
        client.close()


@contextmanager
def _silent(name: str) -> Iterator[None]:
    """Keep a library from logging: what is to be said of a cluster is said in one sentence."""
    log = logging.getLogger(name)
    before, log.disabled = log.disabled, True  # its level is set anew when it is imported
    try:
        yield
    finally:
        log.disabled = before
