"""Practising, being graded, and comparing operators, from the command line."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

import markermend as mm
from markermend.model import Take
from markermend.review import Accept, AddFinding, Reject
from markermend.review.decisions import decisions_on
from markermend.review.session import ReviewSession
from markermend.review.state import Decision, Judgement, Review
from markermend.review.store import Store
from markermend.train import archive

from .conftest import Command, made_take


@dataclass(frozen=True)
class Lab:
    """A store, a folder for the trainee, and a take without artefacts."""

    store: Path
    folder: Path
    clean: Path


@pytest.fixture
def lab(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Lab:
    monkeypatch.setenv("MARKERMEND_STORE", str(tmp_path / "store" / "reviews.sqlite"))
    monkeypatch.setenv("MARKERMEND_OPERATOR", "ben")
    folder = tmp_path / "practice"
    folder.mkdir()
    take = made_take()
    clean = tmp_path / "clean.c3d"
    positions = take.positions[:, :9].copy()
    positions[200:240, 2] = positions[199, 2]
    positions[400, 6] = positions[399, 6]
    mm.write(Take(positions, 100, take.labels[:9]), clean)
    return Lab(tmp_path / "store", folder, clean)


def handed_out(lab: Lab, command: Command, *words: object) -> dict[str, object]:
    ended = command("train", lab.clean, "--out", lab.folder, "--seed", 5, "--json", *words)
    assert ended.code == 0, ended.err
    record: dict[str, object] = json.loads(ended.out)
    return record


def solve(path: object, who: str = "ben", share: int = 1) -> None:
    """Add and accept every `share`-th artefact of the exercise, in the store."""
    take = mm.read(str(path))
    with Store() as store:
        truths = archive.unseal(store, archive.find(store, take.content_hash), take).truths
        session = ReviewSession.open(store, take, who)
        for truth in truths[::share]:
            finding = mm.Finding(truth.marker, truth.span, truth.kind)
            session.do(AddFinding(finding))
            session.do(Accept(finding, "rigid"))


def test_an_exercise_is_one_file_and_its_truth_lies_in_the_store(
    lab: Lab, command: Command
) -> None:
    record = handed_out(lab, command, "--level", 4)
    (path,) = lab.folder.iterdir()
    assert str(path) == record["file"]
    assert (record["level"], record["seed"], record["hidden"]) == (4, 5, False)
    assert not {"answers", "truth", "neutral"} & set(record)
    take, clean = mm.read(path), mm.read(lab.clean)
    assert take.content_hash == record["take"] != clean.content_hash
    assert (take.positions != clean.positions).any()
    again = command("train", lab.clean, "--out", lab.folder, "--seed", 5, "--level", 4)
    assert "exists; choose another name" in again.refusal


def test_practice_from_the_first_exercise_to_the_report(lab: Lab, command: Command) -> None:
    told = command("train", lab.clean, "--out", lab.folder, "--seed", 1)
    assert "level 1, seed 1. The first exercise: one obvious peak." in told.out
    path = lab.folder / "exercise-1-1.c3d"
    solve(path)
    graded = command("train", path, "--grade")
    assert (graded.code, graded.err) == (0, "")
    assert graded.out.startswith("You found and named 1 of 1, and left the take better")
    assert "\nright " in graded.out
    assert [line.split() for line in graded.out.splitlines()[4:6]] == [["peak"], ["peak", "1"]]
    assert graded.out.splitlines()[-1].startswith("Next: level 2, peak.")
    group = json.loads(command("train", "--group", "--json").out)
    (ben,) = group["trainees"]
    assert (ben["trainee"], ben["exercises"], ben["found"]["peak"]["right"]) == ("ben", 1, 1)
    assert "ben" in command("train", "--group").out
    page = lab.folder / "ben.html"
    assert "1 exercises of ben" in command("train", "--report", page).out
    assert "<h1>ben</h1>" in page.read_text(encoding="utf-8")
    assert "exists" in command("train", "--report", page).refusal


def test_a_file_of_decisions_is_graded_as_its_operators(lab: Lab, command: Command) -> None:
    path = handed_out(lab, command, "--level", 5, "--hidden")["file"]
    solve(path, "anna", share=2)
    take = mm.read(str(path))
    with Store() as store:
        session = ReviewSession.open(store, take, "anna")
        file = lab.folder / "anna.json"
        decisions_on(take, session.review, decided=session.decided).write(file)
    ended = command("train", "--grade", file, "--quick", "--json")
    assert ended.code == 0, ended.err
    record = json.loads(ended.out)
    assert record["trainee"] == "anna"
    assert (record["hidden"], record["level"]) == (True, 5)
    assert [m["outcome"] for m in record["marks"]].count("right") == 3
    assert [m["outcome"] for m in record["marks"]].count("missed") == 3
    assert record["seconds_per_finding"] is not None
    moved = lab.folder / "moved.c3d"
    Path(str(path)).rename(moved)
    assert "give its file as TAKE" in command("train", "--grade", file).refusal
    assert command("train", moved, "--grade", file, "--quick").code == 0


def test_an_experts_decisions_make_an_exercise(lab: Lab, take_path: Path, command: Command) -> None:
    take = mm.read(take_path)
    expert = Review(
        {
            f.id: Judgement(f, Decision("accepted", method="rigid"))
            for f in (
                mm.Finding("M2", mm.Span(200, 240), "gap"),
                mm.Finding("M6", mm.Span(400, 401), "peak"),
            )
        }
    )
    file = lab.folder / "expert.json"
    decisions_on(take, expert).write(file)
    ended = command("train", take_path, "--out", lab.folder, "--expert", file, "--json")
    record = json.loads(ended.out)
    assert (record["level"], record["kinds"]) == (0, ["gap", "peak"])
    assert Path(record["file"]).name == "exercise-small.c3d"
    solve(record["file"])
    graded = json.loads(command("train", record["file"], "--grade", "--quick", "--json").out)
    assert [m["outcome"] for m in graded["marks"]] == ["right", "right"]
    assert graded["rmse_after_mm"] < 0.01 < graded["rmse_before_mm"]


Words = Callable[[Lab], str]


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ("train --level 10", "--level: must be a whole number from 1 to 9"),
        ("train {clean} --level 7 --density 599", "has room for"),
        ("train {clean} --expert {clean}", "is no JSON"),
        ("train --json", "--json belongs to what prints or writes"),
        ("train --group --port 7000", "--port belongs to practice in the browser"),
        ("train --out {folder} --group", "not allowed with argument"),
        ("train --out {folder}/none", "no folder"),
        ("train --out {clean}", "no folder"),
        ("train --out {folder} --level 10", "--level: must be a whole number from 1 to 9"),
        ("train --out {folder} --seed -1", "--seed: must be a whole number"),
        ("train {clean} --out {folder} --kinds hole", "--kinds takes some of"),
        ("train {clean} --out {folder} --amplitude nan", "amplitude_mm must be above 0"),
        ("train {clean} --out {folder} --level 7 --density 599", "has room for"),
        ("train {folder}/no.c3d --out {folder}", "No such file"),
        ("train --out {folder} --expert {clean}", "needs the take that the expert reviewed"),
        ("train {clean} --out {folder} --expert {clean}", "is no JSON"),
        ("train {clean} --out {folder} --expert {clean} --level 2", "leave out --level"),
        ("train --group --seed 3", "--seed belongs to an exercise that is made"),
        ("train --group --hidden", "--hidden belongs to an exercise that is made"),
        ("train {clean} --group", "needs no take"),
        ("train --group --quick", "--quick belongs to --grade"),
        ("train --grade", "needs a file of decisions, or the exercise as TAKE"),
        ("train --grade {clean}", "is no JSON"),
        ("train {clean} --grade", "ben has not reviewed"),
        ("train --report {folder}/r.html", "No exercise of ben was graded"),
        ("train --report {clean}", "exists"),
        ("agree", "required: DECISIONS"),
        ("agree {clean}", "two or more files of decisions"),
        ("agree {clean} {clean}", "is no JSON"),
        ("agree {clean} {clean} --iou 0", "--iou: must be above 0 and at most 1; got '0'"),
        ("agree {clean} {clean} --expert {clean}", "give it with --take"),
        ("agree {clean} {clean} --detector eye", "no detector 'eye'"),
        ("agree {clean} {clean} --page --json", "leave one of them out"),
        ("agree {clean} {clean} --port 7000", "--port belongs to --page"),
        ("agree {clean} {clean} --page", "is no JSON"),
    ],
)
def test_is_refused_in_one_sentence_and_nothing_is_written(
    line: str, says: str, lab: Lab, command: Command
) -> None:
    ended = command(*line.format(folder=lab.folder, clean=lab.clean).split())
    assert says in ended.refusal
    assert list(lab.folder.iterdir()) == []


@pytest.fixture
def two_reviews(lab: Lab, take_path: Path) -> tuple[Path, Path]:
    """Decisions of two people on the small take: one peak alike, one span apart."""
    take = mm.read(take_path)
    peak = mm.Finding("M6", mm.Span(400, 401), "peak", detector="published")
    burst = mm.Finding("M1", mm.Span(100, 150), "noise", detector="published")
    files = []
    with Store() as store:
        for who in ("anna", "ben"):
            session = ReviewSession.open(store, take, who)
            session.do(Accept(peak, "linear"))
            session.do(Accept(burst, "pchip") if who == "ben" else Reject(burst))
            files.append(lab.folder / f"{who}.json")
            decisions_on(take, session.review, decided=session.decided).write(files[-1])
    return files[0], files[1]


def test_two_operators_compared(
    two_reviews: tuple[Path, Path], take_path: Path, command: Command
) -> None:
    ended = command("agree", *two_reviews, "--json")
    record = json.loads(ended.out)
    (pair,) = record["pairs"]
    assert record["operators"] == ["anna", "ben"]
    assert (pair["accepted"], pair["both"], pair["difference"]) == ([1, 2], 1, None)
    assert pair["found_by_both"] == 0.5
    assert pair["kappa_spans"] == pytest.approx(1 / 3)
    with_take = json.loads(command("agree", *two_reviews, "--take", take_path, "--json").out)
    apart = with_take["pairs"][0]["difference"]
    assert apart["samples"] == 51
    assert apart["differing"] == 50
    assert apart["where"][0] == "M1"
    text = command("agree", *two_reviews, "--take", take_path, "--expert", two_reviews[0]).out
    assert "anna and ben:" in text
    assert "M1 100-150: nothing, noise" in text
    table = text[text.index("things by class, anna down, ben across:") :].splitlines()[1:4]
    assert [line.split() for line in table] == [
        ["peak", "noise"],
        ["nothing", ".", "1"],
        ["peak", "1", "."],
    ]
    rows = [line.split() for line in text.splitlines()[-3:]]
    assert [row[:2] for row in rows] == [["none", "1"], ["anna", "1"], ["ben", "2"]]


def test_operators_of_one_name_are_told_apart_by_their_files(
    two_reviews: tuple[Path, Path], command: Command
) -> None:
    one, other = two_reviews
    record = json.loads(other.read_text())
    for finding in record["findings"]:
        finding["operator"] = "anna"
    other.write_text(json.dumps(record))
    told = json.loads(command("agree", one, other, "--json").out)
    assert told["operators"] == ["anna.json", "ben.json"]
    assert "given twice" in command("agree", one, one).refusal
