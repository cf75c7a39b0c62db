"""Bones by the names of markers."""

from pathlib import Path

import numpy as np
import pytest

import markermend as mm
from markermend_app.state.skeletons import by_labels, skeletons


def named(labels: list[str]) -> mm.Take:
    return mm.Take(np.zeros((3, len(labels), 3)), 100, labels)


@pytest.mark.parametrize("skeleton", skeletons(), ids=lambda s: s.name)
def test_a_set_is_known_by_its_labels_in_any_order(skeleton):
    labels = sorted({label for bone in skeleton.bones for label in bone}, reverse=True)
    found = by_labels(named(labels))
    assert found is not None
    name, bones = found
    assert name == skeleton.name
    assert {frozenset((labels[a], labels[b])) for a, b in bones} == {
        frozenset(bone) for bone in skeleton.bones
    }
    sides = [
        sum(label.startswith(side) for bone in skeleton.bones for label in bone) for side in "LR"
    ]
    assert sides[0] == sides[1], "both sides have the same bones"


def test_bones_do_not_lead_from_one_subject_to_another():
    labels = sorted({label for bone in skeletons()[0].bones for label in bone})
    both = [f"{who}:{label.lower()}" for who in ("Anna", "Ben") for label in labels]
    _, bones = by_labels(named(both))
    assert len(bones) == 2 * len(skeletons()[0].bones)
    assert all((a < len(labels)) == (b < len(labels)) for a, b in bones)


def test_other_names_fit_no_set():
    assert by_labels(named([f"M{i}" for i in range(40)])) is None
    assert by_labels(named(["LASI", "RASI", "C7", "CLAV"])) is None, "too little of it"


@pytest.mark.parametrize(
    ("file", "name"),
    [
        ("hdm05_mm_01-02_clean.c3d", "Vicon full body"),
        ("pair_gait_raw_dec_int.c3d", "Plug-in Gait"),
        ("qualisys_c3d_events.c3d", "IOR"),
    ],
)
def test_public_takes(shared: Path, file: str, name: str):
    found = by_labels(mm.read(shared / "data" / "public" / file))
    assert found is not None
    assert found[0] == name
