"""Several processes of operators on one server, one of them killed: nothing is lost or doubled."""

from tests.bench.team import measure

from markermend.review.store import Store


def test_of_many_who_decide_at_once_nobody_loses_a_decision(server_store: Store, lab: str) -> None:
    seen = measure(lab, 11, seconds=60, most=12, processes=2, kills=1, pace_s=0.02)
    assert (seen.lost, seen.doubled, seen.faults) == (0, 0, ())
    assert seen.acknowledged >= 11 * 12
