"""``repair``: what is filled, what stays and why, and the same bytes again from the decisions."""

import hashlib
import json
from pathlib import Path

import numpy as np
import pytest

import markermend as mm
from markermend.repairing import DEFAULTS

from .conftest import Command, made_take
from .test_cli_json import strict


@pytest.fixture
def torn_path(tmp_path: Path) -> Path:
    """A file with gaps of every sort, a spike and a level that is wrong for a while."""
    positions = made_take().positions.copy()
    positions[:7, 0] = positions[590:, 1] = positions[:, 3] = np.nan  # ends, never seen
    positions[100:104, 4] = np.nan  # a second inner gap, beside that of M2
    positions[300:310, 9] = np.nan  # in the unlabelled trajectory
    positions[450:500, 8, 0] += 30
    path = tmp_path / "torn.c3d"
    mm.write(mm.Take(positions, 100, made_take().labels), path)
    return path


STAYING = {
    ("M0", 0, 7): "a gap at the beginning of the take is not filled",
    ("M1", 590, 600): "a gap at the end of the take is not filled",
    ("M3", 0, 600): "the marker is never seen",
    ("*10", 300, 310): "an unlabelled trajectory is not filled",
}


def test_fills_inner_gaps_of_measured_markers_and_lists_what_stays(
    torn_path: Path, tmp_path: Path, command: Command
):
    out, report = tmp_path / "out.c3d", tmp_path / "report.json"
    source = torn_path.read_bytes()
    ended = command("repair", torn_path, "-o", out, "--report", report)
    stays = {f"{m} {a}-{b} stays: {why}" for (m, a, b), why in STAYING.items()}
    assert set(ended.warnings) == stays
    assert "2 spans repaired, 44 samples changed, 4 spans stay (patched)" in ended.out

    before, after = mm.read(torn_path), mm.read(out)
    changed = ~((before.positions == after.positions) | ~before.seen[..., None]).all(axis=2)
    assert not changed.any()
    assert {(label, *gap) for label, gap in _gaps(before)} - {
        (label, *gap) for label, gap in _gaps(after)
    } == {("M2", 200, 240), ("M4", 100, 104)}
    assert torn_path.read_bytes() == source
    assert len(out.read_bytes()) == len(source)

    record = strict(report.read_text())
    assert {(s["marker"], s["start"], s["stop"]): s["reason"] for s in record["stays"]} == STAYING
    assert [(r["marker"], r["start"], r["stop"]) for r in record["repaired"]] == [
        ("M2", 200, 240),
        ("M4", 100, 104),
    ]
    assert all(r["method"] in DEFAULTS["gap"] for r in record["repaired"])
    written = record["written"]
    assert (written["mode"], written["n_changed"]) == ("patched", 44)
    assert written["sha256"] == hashlib.sha256(out.read_bytes()).hexdigest()
    assert written["source_sha256"] == hashlib.sha256(source).hexdigest()
    for one in written["changed"]:
        there = after.positions[one["frame"], after.index(one["marker"])]
        assert one["new"] == pytest.approx(there.tolist(), abs=1e-5)
        assert one["old"] == [None, None, None]


def _gaps(take: mm.Take) -> list[tuple[str, tuple[int, int]]]:
    return [
        (label, (span.start, span.stop)) for label in take.labels for span, _ in take.gaps(label)
    ]


def test_model_outputs_stay(shared: Path, tmp_path: Path, command: Command):
    path = shared / "data" / "public" / "walk_pig_over255pts_HC030A05.c3d"
    take, out, report = mm.read(path), tmp_path / "out.c3d", tmp_path / "report.json"
    ended = command("repair", path, "-o", out, "--method", "linear", "--report", report)
    assert ended.code == 0
    after = mm.read(out)
    unlike = [m for m, role in enumerate(take.roles) if role != "measured"]
    assert "model" in take.roles
    assert np.array_equal(after.positions[:, unlike], take.positions[:, unlike], equal_nan=True)
    stays = strict(report.read_text())["stays"]
    by_model = {s["marker"] for s in stays if "a model computed it" in s["reason"]}
    with_gaps = {
        take.labels[m] for m in unlike if take.roles[m] == "model" and not take.seen[:, m].all()
    }
    assert by_model == with_gaps != set()


def test_nothing_to_repair_gives_the_same_bytes(take_path: Path, tmp_path: Path, command: Command):
    whole, out = tmp_path / "whole.c3d", tmp_path / "out.c3d"
    positions = made_take().positions.copy()
    positions[200:240, 2] = positions[199, 2]
    mm.write(mm.Take(positions, 100, made_take().labels), whole)
    ended = command("repair", whole, "-o", out)
    assert ended.warnings == []
    assert "0 spans repaired, 0 samples changed, 0 spans stay (copied)" in ended.out
    assert out.read_bytes() == whole.read_bytes()


def test_a_method_can_be_named(torn_path: Path, tmp_path: Path, command: Command):
    out = tmp_path / "out.c3d"
    assert command("repair", torn_path, "-o", out, "--method", "linear").code == 0
    before, after = mm.read(torn_path), mm.read(out)
    done = mm.repair(before, "M2", (200, 240), method="linear")
    np.testing.assert_allclose(after.positions[200:240, 2], done.values, atol=1e-3)


def test_a_method_that_applies_nowhere_leaves_the_gaps_and_says_so(
    torn_path: Path, tmp_path: Path, command: Command
):
    alone = tmp_path / "alone.c3d"
    mm.write(mm.Take(mm.read(torn_path).positions[:, 2:3], 100, ["M2"]), alone)
    ended = command("repair", alone, "-o", tmp_path / "out.c3d", "--method", "rigid")
    (warning,) = ended.warnings
    assert warning.startswith("M2 200-240 stays: ")
    assert (tmp_path / "out.c3d").read_bytes() == alone.read_bytes()


@pytest.mark.parametrize("kinds", [None, "gap", "gap,peak,noise,step,slow", "peak,step"])
def test_the_decisions_of_an_export_give_the_same_bytes_again(
    kinds: str | None, torn_path: Path, tmp_path: Path, command: Command
):
    first, again = tmp_path / "first.c3d", tmp_path / "again.c3d"
    words = () if kinds is None else ("--kinds", kinds)
    done = command("repair", torn_path, "-o", first, *words)
    assert done.code == 0, done.err
    assert first.read_bytes() != torn_path.read_bytes()
    decisions = tmp_path / "first.c3d.decisions.json"
    assert command("repair", torn_path, "-o", again, "--decisions", decisions).code == 0
    assert again.read_bytes() == first.read_bytes()
    repeated = strict((tmp_path / "again.c3d.decisions.json").read_text())
    for record in (repeated, original := strict(decisions.read_text())):
        record.pop("written")
    assert repeated == original


def test_other_kinds_are_repaired_only_when_named(
    torn_path: Path, tmp_path: Path, command: Command
):
    before = mm.read(torn_path)
    spike = (slice(400, 401), before.index("M6"))
    assert command("repair", torn_path, "-o", tmp_path / "gaps.c3d").code == 0
    assert (mm.read(tmp_path / "gaps.c3d").positions[spike] == before.positions[spike]).all()
    ended = command("repair", torn_path, "-o", tmp_path / "peaks.c3d", "--kinds", "peak")
    assert ended.warnings == []  # gaps were not asked for, so that none stays
    after = mm.read(tmp_path / "peaks.c3d")
    assert np.linalg.norm(after.positions[spike] - before.positions[spike]) > 15
    assert _gaps(after) == _gaps(before)


def test_who_decided_is_handed_on(torn_path: Path, tmp_path: Path, command: Command):
    assert command("repair", torn_path, "-o", tmp_path / "first.c3d").code == 0
    decisions = tmp_path / "first.c3d.decisions.json"
    record = json.loads(decisions.read_text())
    for finding in record["findings"]:
        finding |= {"operator": "A. Smith", "decided": "2020-01-02T03:04:05+00:00"}
    decisions.write_text(json.dumps(record))
    done = command("repair", torn_path, "-o", tmp_path / "again.c3d", "--decisions", decisions)
    assert done.code == 0, done.err
    again = json.loads((tmp_path / "again.c3d.decisions.json").read_text())
    assert again["findings"] == record["findings"] != []


def test_decisions_of_another_take_are_refused(
    torn_path: Path, take_path: Path, tmp_path: Path, command: Command
):
    out = tmp_path / "out.c3d"
    assert command("repair", torn_path, "-o", tmp_path / "first.c3d").code == 0
    decisions = tmp_path / "first.c3d.decisions.json"
    ended = command("repair", take_path, "-o", out, "--decisions", decisions)
    assert "give the take they were made on" in ended.refusal
    slower = command("repair", torn_path, "-o", out, "--decisions", decisions, "--rate", "50")
    assert slower.code == 2
    assert "100 Hz" in slower.err
    newer = json.loads(decisions.read_text()) | {"version": 99}
    decisions.write_text(json.dumps(newer))
    ended = command("repair", torn_path, "-o", out, "--decisions", decisions)
    assert "newer markermend" in ended.refusal
    assert not out.exists()


def test_what_is_there_is_replaced_only_by_force(torn_path: Path, tmp_path: Path, command: Command):
    out, report = tmp_path / "out.c3d", tmp_path / "report.json"
    words = ("repair", torn_path, "-o", out, "--report", report)
    assert command(*words).code == 0
    first = out.read_bytes()
    assert "add --force" in command(*words).refusal
    out.unlink()
    assert "out.c3d.decisions.json exists" in command(*words).refusal
    assert command(*words, "--force", "--method", "linear").code == 0
    assert out.read_bytes() != first
    assert [p.name for p in tmp_path.iterdir() if p.name.endswith(".part")] == []


def test_a_file_written_anew_is_said_to_be_so(torn_path: Path, tmp_path: Path, command: Command):
    out, report = tmp_path / "out.npz", tmp_path / "report.json"
    ended = command("repair", torn_path, "-o", out, "--report", report)
    anew = [sentence for sentence in ended.warnings if "stays" not in sentence]
    assert "The source is C3D" in anew[0]
    assert "holds what the take knows and nothing else" in anew[0]
    record = strict(report.read_text())
    assert record["warnings"] == anew
    assert record["written"]["mode"] == "rewritten"
    assert mm.read(out).seen[200:240, 2].all()


def test_the_decision_file_of_the_take_itself_may_be_used_in_place(
    torn_path: Path, tmp_path: Path, command: Command
):
    out = tmp_path / "out.c3d"
    assert command("repair", torn_path, "-o", out).code == 0
    first = out.read_bytes()
    out.unlink()
    decisions = tmp_path / "out.c3d.decisions.json"
    ended = command("repair", torn_path, "-o", out, "--decisions", decisions, "--force")
    assert ended.code == 0, ended.err
    assert out.read_bytes() == first


HOSTILE = [
    "<img src=x onerror=alert(1)>",
    "a\"b'c",
    "\x1b[2J\x1b[31mred",
    "bell\x07back\x08",
    "line\nbreak\tand tab",
    "n" * 200,
    "\u202egnol\u202c",  # turns the direction of writing
    "קרסול",  # written from right to left, as it should be
    "=1+1",
    "../../up",
    "é́\u200b",
    "{0}%s%n",
]
UNSEEN = {  # what cannot be seen in a label is left out when it is read
    "\x1b[2J\x1b[31mred": "[2J [31mred",
    "bell\x07back\x08": "bell back",
    "line\nbreak\tand tab": "line break and tab",
    "\u202egnol\u202c": "gnol",
    "é́\u200b": "é́",
}
SHOWN = [UNSEEN.get(label, label) for label in HOSTILE]


@pytest.fixture
def hostile_path(tmp_path: Path) -> Path:
    positions = made_take().positions.copy()
    positions = np.concatenate([positions, positions[:, :2] + 500], axis=1)
    positions[:7] = np.nan
    path = tmp_path / "hostile.npz"
    mm.write(mm.Take(positions, 100, HOSTILE), path)
    return path


def test_hostile_labels_cannot_steer_the_terminal(
    hostile_path: Path, tmp_path: Path, command: Command
):
    out, report = tmp_path / "out.npz", tmp_path / "report.json"
    for words in (
        ("info", hostile_path),
        ("detect", hostile_path),
        ("repair", hostile_path, "-o", out, "--report", report),
    ):
        ended = command(*words)
        assert ended.code == 0, ended.err
        printed = (ended.out + ended.err).replace("\n", "")
        assert printed.isprintable(), [c for c in printed if not c.isprintable()]
    stay = [sentence for sentence in ended.warnings if " stays: " in sentence]
    assert len(stay) == len(HOSTILE)  # one line each, whatever is in the label
    stays = strict(report.read_text())["stays"]
    assert [s["marker"] for s in stays] == SHOWN
    table = command("detect", hostile_path, "--kinds", "gap").out
    assert "<img src=x onerror=alert(1)>" in table
    assert "\n[2J [31mred " in table
    assert "\ngnol " in table
    assert "קרסול" in table
    assert len(table.splitlines()) == len(HOSTILE) + 1 + 2


@pytest.mark.parametrize("name", ["info", "detect"])
def test_hostile_labels_come_out_as_shown_in_the_json(
    name: str, hostile_path: Path, command: Command
):
    text = command(name, hostile_path, "--json").out
    assert text.isascii()
    record = strict(text)
    listed = record["gaps"] if name == "info" else record["findings"]
    assert {one["marker"] for one in listed if one["start"] == 0} == set(SHOWN)
