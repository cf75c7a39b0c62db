"""Which files of a folder are takes, and what the files made of them are called."""

from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import markermend as mm
from markermend.batch.takes import content_hash, findings_names, takes_below
from markermend.errors import BadInput

PARTS = st.text("aB.1", min_size=1, max_size=4).filter(lambda s: s.strip("."))
NAMES = st.builds(
    lambda folder, stem, end: f"{folder}{stem}{end}",
    st.sampled_from(["", "x/", "x/y/"]),
    PARTS,
    st.sampled_from([".c3d", ".C3D", ".trc", ".csv", ""]),
)


@settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.lists(NAMES, unique=True, max_size=8))
def test_no_two_takes_share_a_findings_file(names: list[str]):
    found = findings_names(names)
    assert list(found) == names
    # A disk that does not tell upper from lower case cannot hold such takes either.
    distinct = {name.casefold() for name in names}
    assert len({one.casefold() for one in found.values()}) == len(distinct)
    for name, one in found.items():
        assert one.rpartition("/")[0] == name.rpartition("/")[0]


def test_the_ending_stays_only_where_it_tells_takes_apart():
    names = ["walk.c3d", "run.c3d", "run.trc", "sub/walk.trc"]
    assert list(findings_names(names).values()) == [
        "walk.findings.json",
        "run.c3d.findings.json",
        "run.trc.findings.json",
        "sub/walk.findings.json",
    ]


def test_takes_of_all_folders_are_found_and_nothing_else(archive: Path):
    (archive / ".hidden").mkdir()
    (archive / ".hidden" / "x.c3d").write_bytes(b"")
    keypoints = archive / "camera"
    keypoints.mkdir()
    (keypoints / "v_000000000000_keypoints.json").write_text('{"people": []}')
    out = archive / "out"
    out.mkdir()
    (out / "a.npz").write_bytes(b"")
    assert takes_below(archive, out) == (
        "a.npz", "b.npz", "broken.c3d", "c.c3d", "c.npz", "camera", "monday/a.npz", "monday/d.trc",
    )  # fmt: skip


def test_a_take_is_known_by_what_reading_calls_its_content(archive: Path):
    for name in ("a.npz", "c.c3d", "monday/d.trc"):
        assert content_hash(archive / name) == mm.read(archive / name).content_hash
    assert content_hash(archive / "gone.c3d") is None


def test_what_is_no_archive_is_refused(tmp_path: Path):
    with pytest.raises(BadInput, match="no folder"):
        takes_below(tmp_path / "nowhere")
    with pytest.raises(BadInput, match="no takes in"):
        takes_below(tmp_path)
