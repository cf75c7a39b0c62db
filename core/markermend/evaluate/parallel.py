"""Many independent computations, on one core or several, with the same result."""

from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

from joblib import Parallel, delayed
from threadpoolctl import threadpool_limits

T = TypeVar("T")
R = TypeVar("R")


def in_order(
    function: Callable[[T], R],
    tasks: Sequence[T],
    jobs: int = 1,
    progress: Callable[[int], None] = lambda done: None,
) -> Iterator[R]:
    """Yield `function` of each task, in the order of the tasks.

    Parameters
    ----------
    function
        A function of a module (it is sent to other processes), that depends on its task alone.
    tasks
        What it is called with.
    jobs
        Number of processes, which are spawned and not forked; -1 takes all cores.
    progress
        Called with the number of tasks done.
    """
    if jobs == 1:
        results: Iterator[R] = (_alone(function, task) for task in tasks)
    else:
        pool = Parallel(n_jobs=jobs, return_as="generator", backend="loky")
        results = pool(delayed(_alone)(function, task) for task in tasks)
    for done, result in enumerate(results, 1):
        progress(done)
        yield result


def _alone(function: Callable[[T], R], task: T) -> R:
    """Keep linear algebra to one thread: rounding must not depend on how many there are."""
    with threadpool_limits(1):
        return function(task)
