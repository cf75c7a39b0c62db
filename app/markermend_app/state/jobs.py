"""Long work off the page's thread, and its results back on it, unless they come too late."""

import logging
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor, wait
from typing import TypeVar

from markermend.errors import MarkerMendError

T = TypeVar("T")
Schedule = Callable[[Callable[[], None]], None]

LOG = logging.getLogger(__name__)


class Jobs:
    """Runs work in threads, one per topic; every result is tagged, and a stale one is dropped.

    Parameters
    ----------
    schedule
        Calls a function on the page's own thread; in tests, at once.
    failed
        Called on the page's thread with one sentence when work fails.
    """

    def __init__(self, schedule: Schedule, failed: Callable[[str], None]) -> None:
        self._schedule, self._failed = schedule, failed
        self._pools: dict[str, ThreadPoolExecutor] = {}
        self._current: dict[str, object] = {}
        self._closed = False

    def run(
        self,
        topic: str,
        work: Callable[["Ticket"], T],
        done: Callable[[T], None],
        *,
        patience_s: float = 0.0,
    ) -> None:
        """Do `work` for a topic; work for the same topic that is under way becomes stale.

        What takes no longer than `patience_s` is waited for, and is done when this returns.
        """
        if self._closed:
            return
        ticket = Ticket(self, topic)
        self._current[topic] = ticket
        if topic not in self._pools:
            self._pools[topic] = ThreadPoolExecutor(1, thread_name_prefix=f"markermend-{topic}")
        under_way = self._pools[topic].submit(self._result, ticket, work, done)
        if patience_s and wait([under_way], timeout=patience_s).done:
            under_way.result()()
            return

        def tell(ended: Future[Callable[[], None]]) -> None:
            if not ended.cancelled():
                ticket.tell(ended.result())

        under_way.add_done_callback(tell)

    def _result(
        self, ticket: "Ticket", work: Callable[["Ticket"], T], done: Callable[[T], None]
    ) -> Callable[[], None]:
        """Do the work, and give what is to be said of it on the page's thread."""
        if not ticket.valid():
            return _nothing
        try:
            result = work(ticket)
        except MarkerMendError as refusal:
            sentence = str(refusal)
            return lambda: self._failed(sentence)
        except Exception:
            LOG.exception("%s failed", ticket.topic)
            return lambda: self._failed("That failed inside MarkerMend; the log says why.")
        return lambda: done(result)

    def tell(self, report: Callable[[], None]) -> None:
        """Do something on the page's thread, unless the page is closed by then."""
        self._schedule(lambda: None if self._closed else report())

    def cancel(self, topic: str) -> None:
        """Make work under way for a topic stale."""
        self._current.pop(topic, None)

    def wait(self) -> None:
        """Wait until all work handed in so far is done; its results may still be scheduled."""
        for pool in list(self._pools.values()):
            pool.submit(lambda: None).result()

    def close(self) -> None:
        """Make everything stale and take no more work."""
        self._closed = True
        self._current.clear()
        for pool in self._pools.values():
            pool.shutdown(wait=False, cancel_futures=True)


class Ticket:
    """The right to report for a topic, until newer work takes it over."""

    def __init__(self, jobs: Jobs, topic: str) -> None:
        self._jobs, self.topic = jobs, topic

    def valid(self) -> bool:
        """Whether nobody has asked for newer work on this topic."""
        return self._jobs._current.get(self.topic) is self  # noqa: SLF001  one small machine

    def tell(self, report: Callable[[], None]) -> None:
        """Report on the page's thread, if still valid by then."""
        self._jobs._schedule(lambda: report() if self.valid() else None)  # noqa: SLF001


def _nothing() -> None:
    """Say nothing: what was asked for is not wanted any more."""
