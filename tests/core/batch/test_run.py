"""A batch: its files, what it refuses, and what it goes on from."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

import markermend as mm
from markermend.batch import pool, records
from markermend.batch.locks import MARK, alone
from markermend.batch.overview import overview
from markermend.batch.policy import Policy, Rule
from markermend.batch.run import Outcome, run
from markermend.batch.settings import Settings
from markermend.batch.work import work
from markermend.errors import BadInput
from markermend.review.decisions import read_decisions
from markermend.review.store import Store

from .conftest import GAPS, load, small_take

DONE = ["a.npz", "b.npz", "c.c3d", "c.npz", "monday/a.npz", "monday/d.trc"]
FINDINGS = [
    "a.findings.json", "b.findings.json", "c.c3d.findings.json", "c.npz.findings.json",
    "monday/a.findings.json", "monday/d.findings.json",
]  # fmt: skip
REPAIR = replace(GAPS, policy=Policy({"gap": Rule("pchip")}))  # which costs little


@pytest.fixture
def here(monkeypatch: pytest.MonkeyPatch) -> None:
    """Work in this process, where it does not matter in which."""
    monkeypatch.setattr(pool, "results", lambda tasks, **_: map(work, tasks))


def files(folder: Path) -> list[str]:
    paths = (p for p in folder.rglob("*") if p.is_file() and p.name != MARK)
    return sorted(p.relative_to(folder).as_posix() for p in paths)


def stamps(folder: Path) -> dict[str, int]:
    return {name: (folder / name).stat().st_mtime_ns for name in files(folder)}


def test_every_take_ends_somewhere_and_none_stops_the_others(
    archive: Path, store: Store, tmp_path: Path, trap: Callable[[Path, str], None]
):
    trap(archive / "bad.trap", "crash")
    out, told = tmp_path / "out", []
    outcome = run(archive, GAPS, store, out=out, jobs=2, progress=lambda *n: told.append(n))
    summary = load(out / "summary.json")
    assert summary == outcome.to_json()
    assert (summary["version"], summary["done"], summary["resumed"]) == (1, DONE, 0)
    assert [one["take"] for one in summary["refused"]] == ["broken.c3d"]
    assert "no C3D" in summary["refused"][0]["reason"]
    assert [one["take"] for one in summary["failed"]] == ["bad.trap"]
    assert told == [(n, 8) for n in range(9)]
    assert files(out) == sorted([*FINDINGS, "summary.json"])
    for name, found in zip(DONE, FINDINGS, strict=True):
        record = load(out / found)
        assert record["take"] == Path(name).name
        assert [(f["marker"], f["start"], f["stop"]) for f in record["findings"]] == [
            (f.marker, f.span.start, f.span.stop) for f in mm.detect(mm.read(archive / name),
                                                                     kinds=["gap"])
        ]  # fmt: skip


@pytest.mark.usefixtures("here")
def test_a_second_run_computes_nothing_and_mends_the_files(
    archive: Path, store: Store, tmp_path: Path
):
    out = tmp_path / "out"
    first = run(archive, REPAIR, store, out=out)
    before = stamps(out)
    second = run(archive, REPAIR, store, out=out)
    assert (first.resumed, second.resumed) == (0, len(DONE))
    assert second.lines == first.lines
    after = stamps(out)
    before.pop("summary.json"), after.pop("summary.json")
    assert after == before  # what is right on the disk is not written again
    (out / "a.findings.json").write_text("{}")
    (out / "monday/d.findings.json").unlink()
    (out / "b.npz").unlink()
    assert run(archive, REPAIR, store, out=out).resumed == len(DONE) - 1
    assert files(out) == sorted([*before, "summary.json"])
    assert load(out / "a.findings.json")["take"] == "a.npz"


@pytest.mark.usefixtures("here")
def test_what_changed_is_looked_at_again_and_what_is_gone_is_forgotten(
    archive: Path, store: Store, tmp_path: Path
):
    out = tmp_path / "out"
    run(archive, REPAIR, store, out=out)
    mm.write(small_take(99), archive / "a.npz", overwrite=True)
    (archive / "b.npz").write_bytes(b"broken now")
    (archive / "c.npz").rename(archive / "e.npz")
    (archive / "monday/d.trc").unlink()
    outcome = run(archive, REPAIR, store, out=out)
    summary = outcome.to_json()
    assert summary["done"] == ["a.npz", "c.c3d", "e.npz", "monday/a.npz"]
    assert [one["take"] for one in summary["refused"]] == ["b.npz", "broken.c3d"]
    assert outcome.resumed == 2  # a renamed take is known, but its repaired file had another name
    assert not (out / "b.findings.json").exists()
    assert not (out / "b.npz").exists()
    seen = overview(store, archive)
    assert seen is not None
    assert [line.name for line in seen.lines] == [
        "a.npz", "b.npz", "broken.c3d", "c.c3d", "e.npz", "monday/a.npz",
    ]  # fmt: skip


@pytest.mark.usefixtures("here")
def test_repairs_are_made_only_by_a_policy_and_as_the_decisions_beside_say(
    archive: Path, store: Store, tmp_path: Path
):
    out = tmp_path / "out"
    run(archive, REPAIR, store, out=out)
    expected = [*FINDINGS, "summary.json", *DONE, *(f"{name}.decisions.json" for name in DONE)]
    assert files(out) == sorted(expected)
    for name in DONE:
        take, repaired = mm.read(archive / name), mm.read(out / name)
        review = read_decisions(out / f"{name}.decisions.json").review
        changed = (take.seen != repaired.seen).sum(axis=0)
        accepted = {(wish.marker, wish.span) for wish in review.accepted()}
        assert accepted
        assert changed.sum() == sum(len(span) for _, span in accepted)


@pytest.mark.usefixtures("here")
def test_settings_do_not_share_results(archive: Path, store: Store, tmp_path: Path):
    run(archive, GAPS, store)
    policies = (
        Policy({"gap": Rule("linear")}),
        Policy({"gap": Rule("linear", most_s=0.05)}),
    )
    settings = [GAPS, *(replace(GAPS, policy=policy) for policy in policies), Settings(rate=50)]
    assert len({one.key for one in settings}) == len(settings)
    assert run(archive, settings[1], store, out=tmp_path / "out").resumed == 0
    assert run(archive, GAPS, store).resumed == len(DONE)


def test_results_do_not_depend_on_how_many_work(archive: Path, store: Store, tmp_path: Path):
    def results(jobs: int) -> tuple[Outcome, dict[str, bytes]]:
        with Store(tmp_path / f"{jobs}.sqlite") as own:
            outcome = run(archive, REPAIR, own, out=tmp_path / str(jobs), jobs=jobs)
        folder = tmp_path / str(jobs)
        # The decision files say when they were written; all else is the same bytes.
        names = [name for name in files(folder) if not name.endswith(".decisions.json")]
        return outcome, {name: (folder / name).read_bytes() for name in names}

    assert results(1) == results(3)


@pytest.mark.usefixtures("here")
def test_files_of_somebody_else_are_not_replaced(archive: Path, store: Store, tmp_path: Path):
    out = tmp_path / "out"
    (out / "monday").mkdir(parents=True)
    (out / "unrelated.txt").write_text("")
    (out / "monday" / "a.npz").write_bytes(b"a recording")
    with pytest.raises(BadInput, match=r"monday/a\.npz is there and no batch wrote it"):
        run(archive, REPAIR, store, out=out)
    assert files(out) == ["monday/a.npz", "unrelated.txt"]
    run(archive, GAPS, store, out=out)  # nothing of that name is written without repairs
    assert (out / "monday" / "a.npz").read_bytes() == b"a recording"


def test_repairs_go_to_a_place_of_their_own(archive: Path, store: Store):
    with pytest.raises(BadInput, match="place to go"):
        run(archive, REPAIR, store)
    with pytest.raises(BadInput, match="never replaced"):
        run(archive, REPAIR, store, out=archive)


@pytest.mark.usefixtures("here")
def test_results_may_lie_in_the_archive(archive: Path, store: Store):
    for resumed in (0, len(DONE)):
        outcome = run(archive, REPAIR, store, out=archive / "results")
        assert outcome.resumed == resumed
        assert outcome.to_json()["done"] == DONE


@pytest.mark.usefixtures("here")
def test_only_one_at_a_time(archive: Path, store: Store, tmp_path: Path):
    out, other = tmp_path / "out", tmp_path / "other"
    other.mkdir()
    mm.write(small_take(), other / "a.npz")
    with alone(archive, None), pytest.raises(BadInput, match="Another batch is at work on"):
        run(archive, GAPS, store)
    out.mkdir()
    with alone(archive, out), pytest.raises(BadInput, match="Another batch is at work on"):
        run(other, GAPS, store, out=out)
    assert len(run(archive, GAPS, store, out=out).lines) == 7


def test_a_store_that_is_asked_for_an_unknown_folder_has_none(store: Store, tmp_path: Path):
    assert overview(store, tmp_path) is None
    assert records.latest(store, tmp_path) is None
