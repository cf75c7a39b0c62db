"""Small files of every format to begin from: real takes cut short, and odd ones as they are."""

import io
import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from tests.trust._frame import recordings

from markermend.batch.policy import Policy, Rule
from markermend.errors import MarkerMendError
from markermend.io.c3d_layout import layout_in
from markermend.io.format import all_formats, format_of
from markermend.model import Event, Finding, Span, Take
from markermend.recipes import Recipe
from markermend.review import Accept, Annotate, Merge, MoveEdges, Reject, Review, Split
from markermend.review.decisions import decisions_on

LONGEST, _LINES = 48_000, 10
"""Bytes and lines of a seed: a short file is tried more often in the same time."""

_NEXUS = """Trajectories
100
,,S:A,,,S:B,,
Frame,Sub Frame,X,Y,Z,X,Y,Z
,,mm,mm,mm,mm,mm,mm
1,0,1,2,3,,,
2,0,1.5,2,3,4,5,6
"""
_MOTIVE = """Format Version,1.23,Export Frame Rate,120,Length Units,Meters

,,Marker,Marker,Marker
,,A,A,A
,,1,1,1
,,Position,Position,Position
Frame,Time,X,Y,Z
0,0,1,2,3
1,0.00833,1,2,
"""


def small_take(n_frames: int = 6, n_dims: int = 3) -> Take:
    """Give a take with a gap, a model's output and an unlabelled trajectory."""
    rng = np.random.default_rng(3)
    positions = rng.normal(0, 300, (n_frames, 4, n_dims)).round(3)
    positions[1:3, 1] = np.nan
    return Take(
        positions, 100.0, ("A", "Ann:B", "*3", "LKneeAngles"), "mm" if n_dims == 3 else "px",
        events=[Event("Foot Strike", 0.02, "Left")],
    )  # fmt: skip


def seeds(name: str) -> Iterator[bytes]:
    """Yield the seeds of a format, or of ``"decisions"`` or ``"recipe"``."""
    if name == "decisions":
        yield decisions()
        return
    if name == "recipe":
        yield recipe()
        return
    yield from (_cut(path, name) for path in recordings() if _is(path, name))
    writer = next(f.write for f in all_formats() if f.name == name)
    if writer is not None:
        yield writer(small_take())
    if name == "npz":
        yield writer(small_take(n_dims=2)) if writer else b""
        yield _fortran()
    if name == "openpose":
        yield openpose(1, 25)
        yield openpose(2, 18)
    if name == "nexus_csv":
        yield _NEXUS.encode()
    if name == "motive_csv":
        yield _MOTIVE.encode()


def decisions() -> bytes:
    """Give a decision file with every sort of decision in it."""
    take = small_take(60)
    found = [Finding("A", Span(a, a + 6), "peak", amplitude=4.0) for a in (0, 10, 20, 30, 40)]
    review = Review()
    for command in (
        Accept((found[0],), "pchip", {"context": 10}), Reject((found[1],)),
        MoveEdges((found[2],), Span(19, 27)), Annotate((found[2],), "left knee"),
        Split((found[3],), 33), Merge((found[4], found[0])),
    ):  # fmt: skip
        review = command.apply(review)
    text = json.dumps(decisions_on(take, review).to_json())
    return text.encode()


def recipe() -> bytes:
    """Give the file of a recipe that says something of everything."""
    whole = Recipe(
        parameters={"peak": 8.0}, kinds=("gap", "peak"), sensitivity={"peak": 2.0}, note="gait",
        policy=Policy({"gap": Rule("auto"), "peak": Rule("pchip", {"context": 12}, 5.0, 1.0)}),
    )  # fmt: skip
    return json.dumps(whole.to_json()).encode()


def openpose(people: int, points: int) -> bytes:
    """Give one file of keypoints."""
    values = np.random.default_rng(1).uniform(0, 500, (people, 3 * points)).round(2)
    return json.dumps(
        {"version": 1.3, "people": [{"pose_keypoints_2d": row.tolist()} for row in values]}
    ).encode()


def _is(path: Path, name: str) -> bool:
    try:
        return format_of(path).name == name
    except MarkerMendError:
        return False


def _cut(path: Path, name: str) -> bytes:
    data = path.read_bytes()
    if name == "c3d" and len(data) > LONGEST:
        try:
            start = layout_in(data).data_start
        except MarkerMendError:
            start = 0
        return data[: max(start + 4096, LONGEST if start == 0 else 0)]
    if name in ("c3d", "npz", "openpose"):
        return data[:LONGEST]
    return b"".join(data.splitlines(keepends=True)[:_LINES])[:LONGEST]


def _fortran() -> bytes:
    file = io.BytesIO()
    np.savez(file, positions=np.asfortranarray(np.ones((3, 2, 3), np.float32)), units="cm")
    return file.getvalue()
