"""What the server counts, as Prometheus reads it."""

import time
from collections.abc import Mapping, Sequence
from typing import Any

from prometheus_client import CollectorRegistry, Counter, Gauge, Histogram, ProcessCollector
from prometheus_client.exposition import CONTENT_TYPE_LATEST, generate_latest
from tornado.ioloop import PeriodicCallback

from markermend.review.store import Action, Entry, Store

SECONDS = (0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0)
TICK_MS = 500.0


class Metrics:
    """Counters of one process, in a registry of their own."""

    content_type = CONTENT_TYPE_LATEST

    def __init__(self) -> None:
        self.registry = CollectorRegistry()
        ProcessCollector(registry=self.registry)
        into = {"registry": self.registry}
        self.sessions = Gauge("markermend_sessions", "Pages that are open.", **into)
        self.opened = Counter("markermend_sessions_opened", "Pages that were opened.", **into)
        self.decisions = Counter("markermend_decisions", "Decisions that are on disk.", **into)
        self.refused = Counter("markermend_conflicts", "Decisions that the store refused.", **into)
        self.deciding = Histogram(
            "markermend_decision_seconds",
            "Time to bring a decision to the store.",
            buckets=SECONDS,
            **into,
        )
        self.requests = Counter(
            "markermend_http_requests", "Answers by status.", ["status"], **into
        )
        self.delay = Histogram(
            "markermend_loop_delay_seconds",
            "How late the server comes to what is due.",
            buckets=SECONDS,
            **into,
        )
        self._due: float | None = None
        self._ticks = PeriodicCallback(self._tick, TICK_MS)

    def text(self) -> bytes:
        """Give everything in Prometheus' text format."""
        return bytes(generate_latest(self.registry))

    def start(self) -> None:
        """Begin to watch how late the loop is; call it on the loop."""
        self._ticks.start()

    def log(self, handler: Any) -> None:
        """Count an answer."""
        self.requests.labels(str(handler.get_status())).inc()

    def _tick(self) -> None:
        now = time.monotonic()
        if self._due is not None:
            self.delay.observe(max(0.0, now - self._due))
        self._due = now + TICK_MS / 1000


class MeasuredStore(Store):
    """A store that counts what is written to it, and how long that takes."""

    def __init__(self, where: str | None, metrics: Metrics) -> None:
        super().__init__(where)
        self._metrics = metrics

    def append(
        self,
        review: int,
        after: int,
        lines: Sequence[tuple[Action, Mapping[str, Any] | None]],
        operator: str,
        token: str = "",
    ) -> tuple[Entry, ...]:
        """Append as `Store.append` does, and count it."""
        try:
            with self._metrics.deciding.time():
                written = super().append(review, after, lines, operator, token)
        except Exception:
            self._metrics.refused.inc()
            raise
        self._metrics.decisions.inc(len(written))
        return written
