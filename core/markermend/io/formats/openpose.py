"""OpenPose JSON: keypoints in pixels with a confidence, one file per frame in a folder.

A keypoint of confidence 0 was not seen. A repaired one that had none gets the median confidence
of its marker, because whatever reads the files drops keypoints by their confidence.
"""

import hashlib
import json
import re
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from markermend.errors import CannotWrite, UnreadableTake
from markermend.io.contents import Contents, seen_only, warned
from markermend.io.disk import load
from markermend.io.folder import is_packed, pack, unpack
from markermend.io.format import Format, Patch, Patching, Reading
from markermend.io.limits import check_size
from markermend.io.roles import roles_of
from markermend.model import BoolArray, FloatArray

_BODY_25 = [
    *("Nose", "Neck", "RShoulder", "RElbow", "RWrist", "LShoulder", "LElbow", "LWrist"),
    *("MidHip", "RHip", "RKnee", "RAnkle", "LHip", "LKnee", "LAnkle"),
    *("REye", "LEye", "REar", "LEar"),
    *("LBigToe", "LSmallToe", "LHeel", "RBigToe", "RSmallToe", "RHeel"),
]
_COCO = [*_BODY_25[:8], *_BODY_25[9:19]]
_ARRAY = re.compile(r'("pose_keypoints_2d"\s*:\s*\[)([^\[\]]*)(\])')
_TOKEN = re.compile(r"[^\s,]+")
_SPREAD = 10


def recognises(path: Path, head: bytes) -> bool:
    """Whether this is a folder of keypoint files, or one such file."""
    if path.is_dir():
        return any(path.glob("*_keypoints.json"))
    return b"pose_keypoints_2d" in head or (head.lstrip()[:1] == b"{" and b'"people"' in head)


@dataclass(frozen=True, eq=False)
class _Frames:
    """All files of a recording, and which frame each is."""

    files: list[tuple[str, bytes]]
    packed: bool

    @classmethod
    def of(cls, data: bytes) -> "_Frames":
        if is_packed(data):
            named = [file for file in unpack(data) if file[0].endswith("_keypoints.json")]
            if not named:
                raise UnreadableTake("The folder holds no files *_keypoints.json.")
            return cls(named, True)
        return cls([("frame.json", data)], False)

    @cached_property
    def numbers(self) -> list[int]:
        """Frame number of each file, by its name."""
        found = [re.findall(r"\d+", name) for name, _ in self.files]
        numbers = [int(digits[-1]) if digits else -1 for digits in found]
        if len(set(numbers)) != len(numbers) or min(numbers) < 0:
            return list(range(len(numbers)))
        if max(numbers) - min(numbers) > _SPREAD * len(numbers):
            raise UnreadableTake(
                f"The files are numbered from {min(numbers)} to {max(numbers)}, and only "
                f"{len(numbers)} are there; give them in a folder of their own."
            )
        return numbers

    @cached_property
    def rows(self) -> list[int]:
        """Frame index of each file; missing numbers are frames in which nothing was seen."""
        first = min(self.numbers)
        return [number - first for number in self.numbers]

    @cached_property
    def samples(self) -> FloatArray:
        """(n_frames, n_people * n_keypoints, 3): x, y, confidence."""
        n_people, n_points = self.shape
        check_size(max(self.rows) + 1, n_people * n_points)
        values = np.zeros((max(self.rows) + 1, n_people, n_points, 3))
        for row, frame in zip(self.rows, self.people, strict=True):
            for i, person in enumerate(frame):
                values[row, i] = np.reshape(person, (n_points, 3))
        return values.reshape(len(values), -1, 3)

    @cached_property
    def people(self) -> list[list[list[float]]]:
        """The keypoints of each person of each file."""
        return [_people(name, content) for name, content in self.files]

    @cached_property
    def shape(self) -> tuple[int, int]:
        """Numbers of people and of keypoints of each."""
        lengths = {len(person) for frame in self.people for person in frame}
        if len(lengths) != 1 or any(n % 3 for n in lengths):
            raise UnreadableTake(
                "The OpenPose files hold no person, or persons of different numbers of keypoints."
            )
        return max(len(frame) for frame in self.people), lengths.pop() // 3

    @property
    def positions(self) -> FloatArray:
        """(n_frames, n_points, 2) px, NaN = not seen."""
        return seen_only(self.samples[..., :2].copy(), self.samples[..., 2] > 0)[0]


def _people(name: str, content: bytes) -> list[list[float]]:
    try:
        frame: Any = json.loads(content)
        people = [person["pose_keypoints_2d"] for person in frame["people"]]
        return [[float(x) for x in person] for person in people if person]
    except (ValueError, KeyError, TypeError, RecursionError, OverflowError, AttributeError):
        raise UnreadableTake(f"{name} is no keypoint file of OpenPose.") from None


def open_openpose(path: Path, _reading: Reading) -> Contents:
    """Read a folder of keypoint files, or one file.

    Raises
    ------
    UnreadableTake
        If a file is no keypoint file, or nobody is in them.
    """
    data = load(path)
    frames = _Frames.of(data)
    positions, odd = seen_only(frames.samples[..., :2].copy(), frames.samples[..., 2] > 0)
    n_people, n_points = frames.shape
    known = {25: _BODY_25, 18: _COCO}.get(n_points)
    points = known or [f"keypoint{i}" for i in range(n_points)]
    names = [
        name if n_people == 1 else f"person{i}:{name}"
        for i in range(1, n_people + 1)
        for name in points
    ]
    warnings = list(odd)
    if n_people > 1:
        warnings.append(
            f"{n_people} persons are told apart by their order in each file, which may change."
        )
    if len(frames.files) < len(positions):
        warnings.append(f"{len(positions) - len(frames.files)} frames have no file.")
    return Contents(
        path=path,
        format="openpose",
        sha256=hashlib.sha256(data).hexdigest(),
        positions=positions,
        rate=None,
        units="px",
        labels=tuple(names),
        roles=roles_of(names, names),
        first_frame=min(frames.numbers),
        warnings=warned(warnings),
    )


def positions_in(data: bytes, _reading: Reading) -> FloatArray:
    """Decode the keypoints of a file or a packed folder."""
    return _Frames.of(data).positions


def patch(data: bytes, _reading: Reading, positions: FloatArray, changed: BoolArray) -> Patch:
    """Change x and y of keypoints, and the confidence of those that had none."""
    frames = _Frames.of(data)
    _, n_points = frames.shape
    confidence = np.where(frames.samples[..., 2] > 0, frames.samples[..., 2], np.nan)
    file_of = {row: i for i, row in enumerate(frames.rows)}
    files, resolution = list(frames.files), 0.0
    for row in np.flatnonzero(changed.any(axis=1)):
        if int(row) not in file_of:
            raise CannotWrite(
                f"Frame {row} has no file to be repaired in; export the take as .npz."
            )
        i = file_of[int(row)]
        pieces = _pieces(files[i][1])
        decimals = min(6, max((len(t.partition(".")[2]) for p in pieces for t in p[1]), default=3))
        arrays = [p for p in pieces if p[1]]
        for point in np.flatnonzero(changed[row]):
            person, place = divmod(int(point), n_points)
            if person >= len(arrays):
                raise CannotWrite(
                    f"In frame {row} OpenPose found nobody to repair; export the take as .npz."
                )
            tokens = arrays[person][1]
            xy = positions[row, point]
            seen = bool(np.isfinite(xy).all())
            tokens[3 * place : 3 * place + 2] = [f"{x:.{decimals}f}" if seen else "0" for x in xy]
            if not seen:
                tokens[3 * place + 2] = "0"
            elif not frames.samples[row, point, 2] > 0:
                usual = np.nanmedian(confidence[:, point]) if _any(confidence[:, point]) else 0.5
                tokens[3 * place + 2] = f"{usual:.6f}"
        resolution = max(resolution, 10.0**-decimals)
        files[i] = (files[i][0], _joined(pieces))
    return Patch(pack(_with_others(data, files)) if frames.packed else files[0][1], resolution)


def _any(values: FloatArray) -> bool:
    return bool(np.isfinite(values).any())


def _with_others(data: bytes, files: list[tuple[str, bytes]]) -> list[tuple[str, bytes]]:
    new = dict(files)
    return [(name, new.get(name, content)) for name, content in unpack(data)]


def _pieces(content: bytes) -> list[tuple[str, list[str], list[str]]]:
    """Split a file into ``(text before, numbers, text between the numbers)`` for each person.

    The last piece has no numbers, and the text after all persons.
    """
    text, at, pieces = content.decode("utf-8"), 0, []
    for match in _ARRAY.finditer(text):
        body = match.group(2)
        tokens = _TOKEN.findall(body)
        pieces.append((text[at : match.start(2)], tokens, _TOKEN.split(body)))
        at = match.end(2)
    return [*pieces, (text[at:], [], [""])]


def _joined(pieces: list[tuple[str, list[str], list[str]]]) -> bytes:
    parts = []
    for before, tokens, between in pieces:
        parts.append(before + between[0])
        parts += [token + gap for token, gap in zip(tokens, between[1:], strict=True)]
    return "".join(parts).encode()


def compare(old: bytes, new: bytes, _reading: Reading) -> BoolArray | None:
    """Find the keypoints whose numbers differ; None where anything else does."""
    frames = _Frames.of(old)
    _, n_points = frames.shape
    differs = np.zeros(frames.samples.shape[:2], bool)
    all_old = dict(unpack(old)) if frames.packed else dict(frames.files)
    all_new = dict(unpack(new)) if is_packed(new) else {frames.files[0][0]: new}
    if list(all_old) != list(all_new):
        return None
    row_of = {name: row for (name, _), row in zip(frames.files, frames.rows, strict=True)}
    for name, content in all_old.items():
        if content == all_new[name]:
            continue
        before, after = _pieces(content), _pieces(all_new[name])
        skeletons = [[(p[0], p[2], len(p[1])) for p in pieces] for pieces in (before, after)]
        if name not in row_of or skeletons[0] != skeletons[1]:
            return None
        people = [(b[1], a[1]) for b, a in zip(before, after, strict=True) if b[1]]
        for i, (one, two) in enumerate(people):
            for k in {k // 3 for k, (x, y) in enumerate(zip(one, two, strict=True)) if x != y}:
                differs[row_of[name], i * n_points + k] = True
    return differs


FORMAT = Format(
    name="openpose",
    title="OpenPose JSON",
    extensions=(".json",),
    recognises=recognises,
    open=open_openpose,
    patching=Patching(positions_in, patch, compare),
)
