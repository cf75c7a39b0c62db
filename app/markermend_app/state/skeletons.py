"""Bones by the names of the markers, for sets of markers that many laboratories use.

The table is `skeletons.json`: of each set the bones in the middle, and those of the left side, from
which those of the right side follow.
"""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from itertools import groupby
from pathlib import Path

from markermend.model import Take, short

LEAST_BONES = 6
LEAST_SHARE = 1 / 3
"""Of a set's bones that must have both ends in the take, so that it is taken for this set."""
Bone = tuple[int, int]


@dataclass(frozen=True)
class Skeleton:
    """The bones of a set of markers, as pairs of labels."""

    name: str
    bones: frozenset[tuple[str, str]]


@cache
def skeletons() -> tuple[Skeleton, ...]:
    """Give all sets of markers that are known."""
    table = json.loads(Path(__file__).with_suffix(".json").read_text(encoding="utf-8"))
    return tuple(Skeleton(entry["name"], frozenset(_pairs(entry))) for entry in table)


def _pairs(entry: Mapping[str, list[str]]) -> Iterator[tuple[str, str]]:
    for bone in (*entry["middle"], *entry["left"]):
        one, other = bone.upper().split()
        yield one, other
        if bone in entry["left"]:
            yield _mirrored(one), _mirrored(other)


def _mirrored(label: str) -> str:
    return f"R{label[1:]}" if label.startswith("L") else label


def by_labels(take: Take) -> tuple[str, tuple[Bone, ...]] | None:
    """Give the set that fits a take's labels best and its bones, or None where none fits.

    Several subjects are kept apart; capital letters do not matter.
    """
    best: tuple[str, tuple[Bone, ...]] | None = None
    for skeleton in skeletons():
        bones = tuple(bone for there in _subjects(take) for bone in _fitted(skeleton, there))
        if len(bones) >= LEAST_BONES and (best is None or len(bones) > len(best[1])):
            best = skeleton.name, bones
    return best


def _subjects(take: Take) -> Iterator[dict[str, int]]:
    """Give, of each subject, its measured markers by the names in capital letters."""
    markers = sorted((take.labels[m].rpartition(":")[0], int(m)) for m in take.measured)
    for _, own in groupby(markers, key=lambda entry: entry[0]):
        yield {short(take.labels[m]).upper(): m for _, m in own}


def _fitted(skeleton: Skeleton, there: Mapping[str, int]) -> list[Bone]:
    found = [(there[a], there[b]) for a, b in skeleton.bones if a in there and b in there]
    return sorted(found) if len(found) >= LEAST_SHARE * len(skeleton.bones) else []
