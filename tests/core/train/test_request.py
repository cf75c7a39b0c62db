"""What a trainee gets who asks for an exercise, and for the next one."""

from datetime import UTC, datetime

from markermend.train import Request, Result, prepare
from markermend.train.learning import Tally

from .conftest import accepting, swinging

CLEAN = swinging()


def result(level: int, right: int, true: int) -> Result:
    tally = {"peak": Tally(true, right, right, 0)}
    return Result("ben", level, datetime(2026, 1, level, tzinfo=UTC), level, tally, 5, 1, False, 4)  # type: ignore[arg-type]


def test_what_is_asked_for_is_what_is_made() -> None:
    made, why = prepare(Request(CLEAN, level=4, seed=3, kinds=("noise",), hidden=True), [])
    assert (made.level, made.seed, made.kinds, made.hidden, why) == (4, 3, ("noise",), True, "")


def test_what_is_not_asked_for_is_chosen_for_the_weakest_kind() -> None:
    first, why = prepare(Request(CLEAN, seed=3), [])
    assert (first.level, first.kinds, why) == (
        1,
        ("peak",),
        "The first exercise: one obvious peak.",
    )
    second, why = prepare(Request(CLEAN), [result(1, 1, 1), result(2, 4, 4)])
    assert (second.level, second.kinds) == (3, ("gap",))
    assert why == "Your weakest kind is gap: never practised."
    assert prepare(Request(CLEAN), [])[0].seed != prepare(Request(CLEAN), [])[0].seed


def test_after_an_experts_take_comes_a_simulated_person() -> None:
    made, _ = prepare(Request(CLEAN, level=2, seed=1), [])
    expert = accepting(made.truths)
    asked = Request(made.take, hidden=True, expert=expert)
    real, _ = prepare(asked, [])
    assert real.level == 0
    assert [t.span for t in real.truths] == [t.span for t in sorted(made.truths, key=_place)]
    following = asked.another()
    assert (following.take, following.expert, following.hidden) == (None, None, True)
    assert Request(CLEAN, level=3, seed=1).another().take is CLEAN


def _place(truth: object) -> tuple[str, object]:
    return truth.marker, truth.span  # type: ignore[attr-defined]
