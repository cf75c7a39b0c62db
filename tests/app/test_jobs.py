"""Work in threads: what is quick is done at once where that is asked for, all else in its turn."""

import threading
from collections.abc import Callable

from markermend_app.state.jobs import Jobs


def test_what_is_quick_is_done_at_once_and_what_is_slow_in_its_turn() -> None:
    waiting: list[Callable[[], None]] = []
    said: list[str] = []
    jobs = Jobs(waiting.append, said.append)
    jobs.run("preview", lambda _: "quick", said.append, patience_s=60.0)
    assert (said, waiting) == (["quick"], [])

    go_on = threading.Event()

    def slow(_: object) -> str:
        go_on.wait()
        return "slow"

    jobs.run("preview", slow, said.append, patience_s=0.001)
    assert said == ["quick"]
    go_on.set()
    jobs.wait()
    assert said == ["quick"], "it is told on the page's own thread"
    waiting.pop()()
    assert said == ["quick", "slow"]

    go_on.clear()
    jobs.run("preview", slow, said.append, patience_s=0.001)
    jobs.cancel("preview")
    go_on.set()
    jobs.wait()
    for task in waiting:
        task()
    assert said == ["quick", "slow"], "nobody asks for it any more"
    jobs.close()
